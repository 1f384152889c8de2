# The virtual bus: stations, drives, motors and the two ports they stand behind.
gantry_library(gantry_sim_bus
  SOURCES
    can_segment.cpp coe_server.cpp dc_unit.cpp drive402.cpp drive_motion.cpp esc.cpp homing_methods.cpp motor.cpp
    object_dictionary.cpp pdo_map.cpp segment.cpp segment_port.cpp sii_image.cpp station.cpp
  DEPS gantry_config gantry_core)
