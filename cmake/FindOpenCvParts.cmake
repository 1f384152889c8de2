# The parts of OpenCV that the project may use, as imported targets opencv::core and opencv::imgproc.
# Debian's OpenCVConfig.cmake belongs to libopencv-dev, which pulls in every module with VTK and Qt; the parts' own -dev
# packages carry no CMake files. imgcodecs is not a part of ours: in Debian it loads GDAL and with it libpoppler, which
# is under the GPL (docs/decisions/005-images-without-imgcodecs.md); PNG goes through libpng.
find_path(OPENCV_INCLUDE_DIR opencv2/core.hpp PATH_SUFFIXES opencv4)
set(_opencv_needed OPENCV_INCLUDE_DIR)
foreach(_part core imgproc)
  find_library(OPENCV_${_part}_LIBRARY opencv_${_part})
  list(APPEND _opencv_needed OPENCV_${_part}_LIBRARY)
  if(OPENCV_${_part}_LIBRARY AND NOT TARGET opencv::${_part})
    add_library(opencv::${_part} SHARED IMPORTED)
    set_target_properties(opencv::${_part} PROPERTIES IMPORTED_LOCATION ${OPENCV_${_part}_LIBRARY}
      INTERFACE_INCLUDE_DIRECTORIES ${OPENCV_INCLUDE_DIR})
  endif()
endforeach()
if(TARGET opencv::imgproc)
  set_property(TARGET opencv::imgproc PROPERTY INTERFACE_LINK_LIBRARIES opencv::core)
endif()
include(FindPackageHandleStandardArgs)
find_package_handle_standard_args(OpenCvParts REQUIRED_VARS ${_opencv_needed})
mark_as_advanced(${_opencv_needed})
