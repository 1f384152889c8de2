# The world of the virtual machine: board, needle, valve, camera, contact, scripts, memory. Knows nothing of the bus.
find_package(fcl REQUIRED)
gantry_library(gantry_sim_world
  SOURCES board.cpp head.cpp obstacles.cpp overlap.cpp collisions.cpp deposits.cpp render.cpp camera.cpp world.cpp
    world_script.cpp world_memory.cpp world_log.cpp world_json.cpp script.cpp
  DEPS gantry_core gantry_config nlohmann_json::nlohmann_json fcl)
# FCL 0.7 of Debian is built with Eigen's 16-byte alignment; other flags would change the size of its types.
target_compile_definitions(gantry_sim_world PRIVATE EIGEN_MAX_ALIGN_BYTES=16 EIGEN_MAX_STATIC_ALIGN_BYTES=16)
