// Whose packet sockets stand on an interface: for the words of a refusal, as far as /proc tells this user.
#pragma once
#include <cstdint>
#include <string>

namespace gantry::devices {

/// "process 4711 (gantry)" of another process than this one that has a packet socket of this protocol (a number as in
/// if_ether.h) on the interface; empty where none is seen.
std::string packet_socket_owner(unsigned interface_index, std::uint16_t protocol);

}  // namespace gantry::devices
