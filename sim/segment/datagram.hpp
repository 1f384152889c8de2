// A datagram on its way from station to station: each one acts on it, and adds to its working counter
// (ETG.1000.4, 5.4).
//   Datagram d(bytes);   d.pass(first.esc(), t);   d.pass(second.esc(), t + hop);   d.put_back();
#pragma once
#include <cstddef>
#include <cstdint>
#include <span>

#include "core/clock.hpp"
#include "devices/wire/ethercat.hpp"

namespace gantry::sim {

class Esc;

class Datagram {
 public:
  static const std::size_t kMostOfAFrame;  ///< as many as one frame has room for

  /// `bytes` begins with the header and holds data and working counter whole.
  explicit Datagram(std::span<std::byte> bytes) noexcept;

  /// One station acts on it, at the instant at which it comes by. Data changes in place.
  void pass(Esc& esc, Time at) noexcept;
  /// Header and working counter go back into the frame.
  void put_back() const noexcept;

  [[nodiscard]] std::size_t size() const noexcept { return bytes_.size(); }
  [[nodiscard]] bool more() const noexcept { return header_.more; }

 private:
  devices::wire::DatagramHeader header_;
  std::uint16_t adp_, ado_, working_counter_;
  std::span<std::byte> bytes_;
};

}  // namespace gantry::sim
