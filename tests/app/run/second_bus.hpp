// A bus that is no EtherCAT: nodes on a party line that are asked one after the other and answer or do not. No frames,
// no working counter, no states with numbers, no clock; a node is "awake" or "asleep". It stands in for the bus that
// comes next, so that the loop and recovery are tried on something that shares no line with EtherCAT's master.
//   SecondBus bus({{"shoulder"}, {"elbow"}});   bus.node(1).answers = false;   bus.node(1).lose_supply();
#pragma once
#include <array>
#include <cstdlib>
#include <functional>
#include <string>
#include <vector>

#include "devices/station_bus.hpp"
#include "devices/wire/bytes.hpp"

namespace gantry::test {

/// A CiA 402 drive, as far as a loop asks for it: 6040h, 6060h, 607Ah in; 6041h, 6061h, 6064h, 60FDh out. It follows
/// its targets at once, and its homing goes down to a switch below counts 0.
struct PartyNode {
  std::string name;
  std::int32_t position = 500;  ///< true counts from the switch
  bool answers = true;          ///< the party line reaches it
  bool awake = false;
  bool lost_supply = true;
  unsigned crackles = 0;  ///< that its plug has counted
  std::vector<devices::Emergency> mail{};

  std::array<std::byte, 7> out{};
  std::array<std::byte, 11> in{};
  bool fresh = false;
  std::uint64_t missed = 0;
  int level = 0;  ///< no torque, ready, switched on, enabled
  bool homed = false;
  std::int32_t zero = -777;  ///< what it counts at its switch before it was homed

  void lose_supply() { awake = homed = false, lost_supply = true, level = 0, zero = -4242; }

  void step() {
    using devices::wire::get_le;
    using devices::wire::put_le;
    const auto word = get_le<std::uint16_t>(out, 0);
    const auto mode = static_cast<std::int8_t>(out[2]);
    const int asked = (word & 0x06) != 0x06 ? 0 : (word & 0x0F) == 0x0F ? 3 : (word & 0x01) != 0 ? 2 : 1;
    level = asked > level ? level + 1 : asked;
    const bool homing = level == 3 && mode == 6 && (word & 0x10) != 0;
    if (mode != 6 || (word & 0x10) == 0) homed = false;
    if (level == 3 && mode == 8) position = get_le<std::int32_t>(out, 3) - zero;
    if (homing && !homed) {
      if (position >= 0)
        position -= 10;
      else
        position = zero = 0, homed = true;  // back at the edge, where the switch opens
    }
    constexpr std::array<std::uint16_t, 4> kStatus{0x0240, 0x0221, 0x0233, 0x0237};  // IEC 61800-7-201, table 29
    put_le<std::uint16_t>(in, 0,
                          static_cast<std::uint16_t>(kStatus[static_cast<std::size_t>(level)] | (homed ? 0x1400 : 0)));
    in[2] = out[2];
    put_le<std::int32_t>(in, 3, position + zero);
    put_le<std::uint32_t>(in, 7, position < 0 ? 1 : 0);
  }
};

class SecondBus final : public devices::StationBus {
 public:
  explicit SecondBus(std::vector<PartyNode> nodes, const config::Machine& machine) : nodes_(std::move(nodes)) {
    for (std::size_t i = 0; i < nodes_.size(); ++i) {
      auto& s = stations_.emplace_back();
      s.id = StationId{static_cast<std::uint16_t>(i)};
      s.where = "node '" + nodes_[i].name + "'";
      s.config = &machine.stations[i];
    }
  }
  [[nodiscard]] PartyNode& node(std::size_t i) { return nodes_[i]; }
  int attempts = 0;  ///< of recover()

  Result<void> bring_up() override {
    for (PartyNode& n : nodes_) n.lost_supply = false;
    return {};
  }
  Result<void> request_operation() override {
    for (PartyNode& n : nodes_) n.awake = n.answers;
    return {};
  }
  Result<void> check_operation() override {
    for (std::size_t i = 0; i < nodes_.size(); ++i)
      if (!nodes_[i].awake) return fail(Fault::StationLeftOp, "is asleep", stations_[i].where);
    return {};
  }
  [[nodiscard]] Time first_cycle(Time not_before) const noexcept override { return not_before; }
  void shut_down() override {
    for (PartyNode& n : nodes_) n.awake = false;
  }
  Result<devices::Bytes> read_object(StationId, config::ObjectAddress) override { return devices::Bytes{}; }
  Result<void> write_object(StationId, config::ObjectAddress, std::span<const std::byte>) override { return {}; }

  [[nodiscard]] std::span<std::byte> outputs(StationId s) noexcept override { return nodes_[s.value].out; }
  [[nodiscard]] std::span<const std::byte> inputs(StationId s) const noexcept override { return nodes_[s.value].in; }
  [[nodiscard]] bool fresh(StationId s) const noexcept override { return nodes_[s.value].fresh; }
  devices::Exchange exchange(Time) noexcept override {
    devices::Exchange e;
    e.inputs_fresh = e.complete = e.operational = true;
    for (PartyNode& n : nodes_) {
      n.fresh = n.answers && n.awake;
      if (n.fresh) n.step();
      if (!n.fresh) ++n.missed;
      e.inputs_fresh = e.inputs_fresh && n.fresh;
      e.complete = e.complete && n.fresh;
      e.operational = e.operational && n.answers && n.awake;
      e.detail += n.fresh ? 1 : 0;
    }
    if (!e.complete && operated_) e.fault = Fault::TooFewTookPart;
    operated_ = operated_ || e.operational;
    ++cycles_;
    return e;
  }
  std::size_t spare_frames(std::span<const devices::ImageChange>, std::span<devices::FrameBytes>) noexcept override {
    return 0;
  }

  [[nodiscard]] std::size_t station_count() const noexcept override { return nodes_.size(); }
  [[nodiscard]] const devices::BusStation& station(std::size_t i) const noexcept override { return stations_[i]; }
  [[nodiscard]] const std::vector<std::string>& notes() const noexcept override { return notes_; }
  [[nodiscard]] std::uint64_t cycles() const noexcept override { return cycles_; }
  bool presence(std::size_t i, devices::Presence& out) const noexcept override {
    const PartyNode& n = nodes_[i];
    out = {.missed = n.missed, .asked_at = n.answers ? cycles_ : 0, .operational = n.awake};
    return true;
  }
  bool look(std::size_t i, devices::StationLook& out) const noexcept override {
    out = {.looks = cycles_, .message_waiting = !nodes_[i].mail.empty()};
    return nodes_[i].answers;
  }
  [[nodiscard]] devices::ErrorCounts error_counts(std::size_t i) const noexcept override {
    devices::ErrorCounts counts;
    counts.push_back({"plug", "crackles", nodes_[i].crackles});
    return counts;
  }
  [[nodiscard]] std::string state_words(std::size_t i) const override { return nodes_[i].awake ? "awake" : "asleep"; }
  [[nodiscard]] devices::CyclicCounts counters() const noexcept override { return {}; }

  void heed(std::function<bool()>) override {}
  void step_by(std::function<void()> step) override { step_ = std::move(step); }
  Result<std::optional<devices::Recovered>> recover(std::size_t i) override {
    PartyNode& n = nodes_[i];
    if (n.answers && n.awake) return std::nullopt;
    ++attempts;
    if (!n.answers) return fail(Fault::StationMissing, "does not answer", stations_[i].where);
    for (int k = 0; k < 5; ++k) step_();  // it is told what it has to do, while the loop goes on
    n.awake = true;
    for (int k = 0; k < 5; ++k) step_();
    return devices::Recovered{.found = "asleep", .restarted = std::exchange(n.lost_supply, false)};
  }
  std::vector<std::pair<StationId, devices::Emergency>> take_emergencies() override {
    std::vector<std::pair<StationId, devices::Emergency>> all;
    for (std::size_t i = 0; i < nodes_.size(); ++i)
      for (const auto& e : std::exchange(nodes_[i].mail, {})) all.emplace_back(stations_[i].id, e);
    return all;
  }

 private:
  std::vector<PartyNode> nodes_;
  std::vector<devices::BusStation> stations_;
  std::vector<std::string> notes_;
  std::uint64_t cycles_ = 0;
  bool operated_ = false;
  std::function<void()> step_;
};

}  // namespace gantry::test
