# How many seconds the long tests take on two cores, about. ctest begins with them where it has no figures of its own yet,
# as on a cold machine: else one of them is left alone at the end, and those that are asleep most of the time come together
# while nothing computes.
set(GANTRY_LONG_TESTS
  cli_parts 106
  cli_terminal 60
  machine_hold_test 50
  cli_plan 50
  cli_results 47
  machine_orders_test 40
  machine_outlived_stops_test 40
  boards_test 36
  cli_owner 37
  cli_veth 35
  config_test.sanitized 35
  recipes_test.sanitized 34
  motion_profile_test 34
  machine_demo_test 32
  motion_path_test 32
  desk_machine_test 30
  cli_certificate 29
  cli_clients 28
  monitor_dds_test 28
  cli_monitored 26
  machine_timed_clearance_test 25
  cli_bus 24
  record_test.sanitized 24
  vision_test 23
  machine_lasting_faults_test 22
  motion_plan_test 21
  machine_stop_ahead_test 20
  job_plan_test 20
  wherever_test 20
  cli_silent_world 20
  cli_package 19
  config_test 17
  run_runner_test 17
  cli_suspended_client 16)

# gantry_schedule(NAME [COMPUTES]): where a test stands in the order, and how many places it takes; COMPUTES: two of ctest's
# `-j`, so that with three places for a core (scripts/test) not more tests compute at once than one and a half for a core,
# and those that sleep fill the rest.
function(gantry_schedule name)
  list(FIND GANTRY_LONG_TESTS ${name} at)
  if(NOT at EQUAL -1)
    math(EXPR at "${at} + 1")
    list(GET GANTRY_LONG_TESTS ${at} seconds)
    set_tests_properties(${name} PROPERTIES COST ${seconds})
  endif()
  if("COMPUTES" IN_LIST ARGN)
    set_tests_properties(${name} PROPERTIES PROCESSORS 2)
  endif()
endfunction()
