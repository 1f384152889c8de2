#include "devices/ethercat/master.hpp"

#include <algorithm>
#include <fmt/format.h>

#include "devices/ethercat/mapping.hpp"
#include "devices/ethercat/scan.hpp"
#include "devices/ethercat/sdo.hpp"
#include "devices/ethercat/states.hpp"

namespace gantry::devices {
namespace {

using namespace wire;

constexpr std::uint32_t kLogicalStart = 0x0001'0000;

/// Errors of registers do not know whose register it was.
template <class T>
Result<T> at(const StationRecord& s, Result<T> result) {
  if (!result && result.error().where.empty()) result.error().where = s.where;
  return result;
}

}  // namespace

EthercatMaster::EthercatMaster(const config::Machine& machine, FramePort& port, Clock& clock)
    : machine_(machine), port_(port), clock_(clock), link_(port, clock) {}

Result<void> EthercatMaster::enter(AlState state) {
  for (const auto& s : stations_)
    if (auto ok = at(s, request_state(link_, s, state)); !ok) return ok;
  for (const auto& s : stations_)
    if (auto ok = at(s, wait_for_state(link_, s, state)); !ok) return ok;
  return {};
}

Result<void> EthercatMaster::configure(StationRecord& s) {
  if (auto ok = at(s, write_startup(link_, s)); !ok) return ok;
  if (auto ok = at(s, write_pdo_mapping(link_, s)); !ok) return ok;
  return at(s, write_process_data(link_, s));
}

Result<void> EthercatMaster::bring_up() {
  exchanging_ = false;
  link_.ride_in(nullptr);
  notes_.clear();
  auto found = scan(link_, machine_, false, notes_);
  if (!found) return tl::unexpected(found.error());
  stations_ = std::move(*found);

  const auto size = lay_out(stations_, kLogicalStart);
  if (!size) return tl::unexpected(size.error());
  for (const auto& s : stations_)
    if (auto ok = at(s, write_mailbox_setup(link_, s)); !ok) return ok;
  if (auto ok = enter(AlState::PreOp); !ok) return ok;
  for (auto& s : stations_)
    if (auto ok = configure(s); !ok) return ok;

  const auto dc = set_up_clocks(link_, stations_, notes_);
  if (!dc) return tl::unexpected(dc.error());
  dc_ = *dc;
  if (auto ok = start_sync0(link_, stations_, dc_, machine_.bus.cycle); !ok) return ok;

  output_image_.assign(size->output_bytes, std::byte{0});
  input_image_.assign(size->input_bytes, std::byte{0});
  places_.assign(machine_.stations.size(), Place{});
  for (const auto& s : stations_)
    places_[s.id.value] = {s.output_offset, s.output_bytes, s.input_offset, s.input_bytes};
  cyclic_ = Cyclic({.logical_start = kLogicalStart,
                    .output_bytes = static_cast<std::uint16_t>(size->output_bytes),
                    .input_bytes = static_cast<std::uint16_t>(size->input_bytes),
                    .working_counter = size->working_counter,
                    .stations = static_cast<std::uint16_t>(stations_.size()),
                    .reference_address = dc_.reference_address},
                   output_image_, input_image_);
  return enter(AlState::SafeOp);
}

/// While the loop exchanges in a thread of its own, datagrams ride in its frames. On a virtual clock one thread owns
/// everything, and they go out by themselves between two cycles.
void EthercatMaster::choose_way() noexcept { link_.ride_in(exchanging_ && !clock_.is_virtual() ? &acyclic_ : nullptr); }

Result<void> EthercatMaster::request_operation() {
  choose_way();
  for (const auto& s : stations_)
    if (auto ok = at(s, request_state(link_, s, AlState::Op)); !ok) return ok;
  return {};
}

Result<void> EthercatMaster::check_operation() {
  choose_way();
  for (const auto& s : stations_) {
    const auto status = at(s, read_al_status(link_, s));
    if (!status) return tl::unexpected(status.error());
    if (status->state != AlState::Op || status->error)
      return fail(Fault::StationLeftOp,
                  fmt::format("is in {}: AL status code {:04X}h, {}", name(status->state), status->code,
                              al_status_text(status->code)),
                  s.where);
  }
  return {};
}

Time EthercatMaster::first_cycle(Time not_before) const noexcept {
  if (dc_.reference_address == 0) return not_before;
  const Time cycle = machine_.bus.cycle, half = cycle / 2;
  const Time periods{(not_before - half + cycle - Time{1}) / cycle * cycle.count()};
  return periods + half;
}

void EthercatMaster::shut_down() {
  exchanging_ = false;
  link_.ride_in(nullptr);
  if (stations_.empty()) return;
  std::fill(output_image_.begin(), output_image_.end(), std::byte{0});
  cyclic_.run(port_, acyclic_, clock_.now() + Link::kReplyTimeout);
  constexpr std::array<std::byte, 1> off{};
  for (const auto state : {AlState::SafeOp, AlState::Init}) {
    std::array<std::byte, 2> raw{};
    put_le<std::uint16_t>(raw, 0, static_cast<std::uint16_t>(state));
    // The bus may be gone; the stations' watchdogs have answered then.
    if (!link_.write_all(reg::kAlControl, raw)) return;
  }
  if (!link_.write_all(reg::kDcActivation, off)) return;
  stations_.clear();
}

Result<StationRecord*> EthercatMaster::record(StationId station) {
  const auto it = std::find_if(stations_.begin(), stations_.end(), [&](auto& s) { return s.id == station; });
  if (it == stations_.end())
    return fail(Fault::StationMissing,
                fmt::format("station {} is not on this bus, or the bus is not up", station.value));
  choose_way();
  return &*it;
}

Result<Bytes> EthercatMaster::read_object(StationId station, config::ObjectAddress address) {
  auto s = record(station);
  if (!s) return tl::unexpected(s.error());
  return at(**s, sdo_upload(link_, **s, address));
}

Result<void> EthercatMaster::write_object(StationId station, config::ObjectAddress address,
                                          std::span<const std::byte> value) {
  auto s = record(station);
  if (!s) return tl::unexpected(s.error());
  return at(**s, sdo_download(link_, **s, address, value));
}

std::span<std::byte> EthercatMaster::outputs(StationId station) noexcept {
  if (station.value >= places_.size()) return {};
  const Place& p = places_[station.value];
  return std::span(output_image_).subspan(p.output_offset, p.output_bytes);
}

std::span<const std::byte> EthercatMaster::inputs(StationId station) const noexcept {
  if (station.value >= places_.size()) return {};
  const Place& p = places_[station.value];
  return std::span<const std::byte>(input_image_).subspan(p.input_offset, p.input_bytes);
}

Exchange EthercatMaster::exchange(Time deadline) noexcept {
  exchanging_.store(true, std::memory_order_relaxed);
  return cyclic_.run(port_, acyclic_, deadline);
}

}  // namespace gantry::devices
