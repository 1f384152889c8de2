# Tests of the virtual bus.
gantry_test(sim_motor_test SOURCES motor_test.cpp DEPS gantry_sim_bus)
gantry_test(sim_segment_test LABELS unit sanitized SOURCES segment_test.cpp esc_test.cpp DEPS gantry_sim_bus)
gantry_test(sim_station_test LABELS unit sanitized SOURCES station_test.cpp DEPS gantry_sim_bus)
gantry_test(sim_drive_test SOURCES drive_test.cpp DEPS gantry_sim_bus)
gantry_test(sim_no_allocation_test SOURCES no_allocation_test.cpp DEPS gantry_sim_bus gantry_trap_hooks)
gantry_test(sim_dissected_test SOURCES dissected_test.cpp DEPS gantry_sim_bus)
gantry_test(sim_coe_server_test LABELS unit sanitized SOURCES coe_server_test.cpp DEPS gantry_sim_bus)
gantry_test(sim_faults_test LABELS unit sanitized SOURCES faults_test.cpp DEPS gantry_sim_bus)
