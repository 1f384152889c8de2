# The virtual bus: stations, drives, motors and the two ports they stand behind.
gantry_library(gantry_sim_bus
  SOURCES
    can_segment.cpp coe_information.cpp coe_server.cpp dc_unit.cpp drive402.cpp drive402_homing.cpp drive_motion.cpp esc.cpp esc_buffers.cpp esc_logical.cpp
    esc_registers.cpp frame_faults.cpp homing_methods.cpp motor.cpp object_access.cpp object_dictionary.cpp pdo_map.cpp segment.cpp
    segment_frames.cpp segment_line.cpp segment_port.cpp sii_image.cpp sii_unit.cpp station.cpp station_mailbox.cpp
    station_states.cpp
  DEPS gantry_config gantry_core)
