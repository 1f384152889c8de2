# The simulated machine put together, and its process of its own: segment and world behind one object, socket, interface.
gantry_library(gantry_sim
  SOURCES machine/simulated_machine.cpp machine/wiring.cpp machine/bus_actions.cpp machine/serve.cpp machine/world_server.cpp machine/world_client.cpp machine/line_socket.cpp
  DEPS gantry_sim_world gantry_sim_bus gantry_devices)
