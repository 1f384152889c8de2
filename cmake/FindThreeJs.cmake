# three.js as Debian's libjs-three has it: one script that any page can hold, its orbit controls and its thick lines.
# The scripts in the order in which they must run are in THREE_JS_SCRIPTS.
find_path(THREE_JS_DIR three.min.js PATHS /usr/share/javascript/three)
set(THREE_JS_SCRIPTS)
foreach(_script three.min.js examples/js/controls/OrbitControls.js examples/js/lines/LineSegmentsGeometry.js
    examples/js/lines/LineMaterial.js examples/js/lines/LineSegments2.js)
  list(APPEND THREE_JS_SCRIPTS ${THREE_JS_DIR}/${_script})
endforeach()
include(FindPackageHandleStandardArgs)
find_package_handle_standard_args(ThreeJs REQUIRED_VARS THREE_JS_DIR
  REASON_FAILURE_MESSAGE "scripts/setup installs Debian's libjs-three")
mark_as_advanced(THREE_JS_DIR)
