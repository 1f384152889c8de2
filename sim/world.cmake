# The world of the simulated machine: board, needle, valve, camera, contact, scripts, memory. Knows nothing of the stations.
find_package(fcl REQUIRED)
gantry_library(gantry_sim_world
  SOURCES
    script/actions.cpp script/names.cpp script/script.cpp
    world/board.cpp world/camera.cpp world/collisions.cpp world/deposits.cpp world/deposit_speed.cpp world/head.cpp world/obstacles.cpp
    world/overlap.cpp world/render.cpp world/script_on_board.cpp world/solid_tree.cpp world/world.cpp world/world_json.cpp world/world_log.cpp world/world_memory.cpp
    world/world_script.cpp
  DEPS gantry_core gantry_config gantry_recipes nlohmann_json::nlohmann_json fcl)
# FCL 0.7 of Debian is built with Eigen's 16-byte alignment; other flags would change the size of its types.
target_compile_definitions(gantry_sim_world PRIVATE EIGEN_MAX_ALIGN_BYTES=16 EIGEN_MAX_STATIC_ALIGN_BYTES=16)
if(GANTRY_SANITIZE) # with -fsanitize g++ 12 warns, wrongly, of a variant that is copied
  set_source_files_properties(script/actions.cpp PROPERTIES COMPILE_OPTIONS -Wno-maybe-uninitialized)
endif()
gantry_compile_alone(world/deposits.cpp)
