# Tests of the virtual bus.
gantry_test(sim_motor_test SOURCES motor_test.cpp DEPS gantry_sim_bus)
gantry_test(sim_segment_test SOURCES segment_test.cpp DEPS gantry_sim_bus)
gantry_test(sim_station_test SOURCES station_test.cpp DEPS gantry_sim_bus)
gantry_test(sim_drive_test SOURCES drive_test.cpp DEPS gantry_sim_bus)
