// A bus of values: what its cycles have seen of each station is what a test puts there.
//   ToldBus bus({"y1", "z"});   bus.row(1).presence.missed = 3;   bus.pass(20);
#pragma once
#include <string>
#include <utility>
#include <vector>

#include "devices/station_bus.hpp"

namespace gantry::test {

class ToldBus final : public devices::StationBus {
 public:
  struct Row {
    devices::BusStation station;
    devices::Presence presence;
    devices::StationLook look;
    devices::ErrorCounts counts;
    std::string state = "in OP";
    bool looked_at = true;
  };

  explicit ToldBus(const std::vector<std::string>& names) {
    for (const std::string& name : names) {
      Row& row = rows_.emplace_back();
      row.station.id = StationId{static_cast<std::uint16_t>(rows_.size() - 1)};
      row.station.where = "station " + std::to_string(rows_.size() - 1) + " '" + name + "'";
    }
  }
  [[nodiscard]] Row& row(std::size_t i) { return rows_[i]; }
  void pass(std::uint64_t cycles) { cycles_ += cycles; }
  std::vector<std::pair<StationId, devices::Emergency>> mail;

  [[nodiscard]] std::size_t station_count() const noexcept override { return rows_.size(); }
  [[nodiscard]] const devices::BusStation& station(std::size_t i) const noexcept override { return rows_[i].station; }
  [[nodiscard]] const std::vector<std::string>& notes() const noexcept override { return notes_; }
  [[nodiscard]] std::uint64_t cycles() const noexcept override { return cycles_; }
  bool presence(std::size_t i, devices::Presence& out) const noexcept override {
    out = rows_[i].presence;
    return rows_[i].looked_at;
  }
  bool look(std::size_t i, devices::StationLook& out) const noexcept override {
    out = rows_[i].look;
    return rows_[i].looked_at;
  }
  [[nodiscard]] devices::ErrorCounts error_counts(std::size_t i) const noexcept override { return rows_[i].counts; }
  [[nodiscard]] std::string state_words(std::size_t i) const override { return rows_[i].state; }
  [[nodiscard]] devices::CyclicCounts counters() const noexcept override { return {}; }
  std::vector<std::pair<StationId, devices::Emergency>> take_emergencies() override { return std::exchange(mail, {}); }

  // What news and culprits have no business with.
  Result<void> bring_up() override { return {}; }
  Result<void> request_operation() override { return {}; }
  Result<void> check_operation() override { return {}; }
  [[nodiscard]] Time first_cycle(Time not_before) const noexcept override { return not_before; }
  void shut_down() override {}
  Result<devices::Bytes> read_object(StationId, config::ObjectAddress) override { return devices::Bytes{}; }
  Result<void> write_object(StationId, config::ObjectAddress, std::span<const std::byte>) override { return {}; }
  [[nodiscard]] std::span<std::byte> outputs(StationId) noexcept override { return {}; }
  [[nodiscard]] std::span<const std::byte> inputs(StationId) const noexcept override { return {}; }
  [[nodiscard]] bool fresh(StationId) const noexcept override { return true; }
  devices::Exchange exchange(Time) noexcept override { return {}; }
  std::size_t spare_frames(std::span<const devices::ImageChange>, std::span<devices::FrameBytes>) noexcept override {
    return 0;
  }
  void heed(std::function<bool()>) override {}
  void step_by(std::function<void()>) override {}
  Result<std::optional<devices::Recovered>> recover(std::size_t) override { return std::nullopt; }

 private:
  std::vector<Row> rows_;
  std::vector<std::string> notes_;
  std::uint64_t cycles_ = 0;
};

}  // namespace gantry::test
