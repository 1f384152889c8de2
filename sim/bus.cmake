# The virtual bus: stations, drives, motors and the two ports they stand behind. Each room knows only those above it.
gantry_library(gantry_sim_bus
  SOURCES
    esc/dc_unit.cpp esc/esc.cpp esc/esc_buffers.cpp esc/esc_logical.cpp esc/esc_registers.cpp esc/sii_unit.cpp
    objects/coe_information.cpp objects/coe_server.cpp objects/object_access.cpp objects/object_dictionary.cpp
    objects/object_shapes.cpp objects/pdo_map.cpp objects/sii_image.cpp
    drive/drive402.cpp drive/drive402_homing.cpp drive/drive_motion.cpp drive/homing_methods.cpp drive/motor.cpp
    station/station.cpp station/station_mailbox.cpp station/station_states.cpp
    segment/can_segment.cpp segment/datagram.cpp segment/foreign_frame.cpp segment/frame_faults.cpp segment/segment.cpp
    segment/segment_frames.cpp segment/segment_line.cpp segment/segment_port.cpp
  DEPS gantry_config gantry_core)
