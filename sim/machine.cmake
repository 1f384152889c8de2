# The virtual machine put together, and its process of its own: segment and world behind one object, socket, interface.
gantry_library(gantry_sim
  SOURCES virtual_machine.cpp serve.cpp world_server.cpp world_client.cpp line_socket.cpp
  DEPS gantry_sim_world gantry_sim_bus gantry_devices)
