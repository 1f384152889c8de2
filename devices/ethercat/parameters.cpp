#include "devices/ethercat/parameters.hpp"

#include <algorithm>
#include <fmt/format.h>

#include "config/held_limits.hpp"
#include "devices/ethercat/sdo.hpp"
#include "devices/profiles/object_value.hpp"

namespace gantry::devices {

using config::ObjectType;

namespace {

std::string text(const config::StartupRow& row) {
  return fmt::format("{} ({})", config::to_text(row.address), row.name.empty() ? row.why : row.name);
}

/// The station refused, as against one that does not answer.
bool refused(const Error& e) { return e.fault == Fault::SdoAbort || e.fault == Fault::SdoSizeMismatch; }

/// What is wrong with one row after everything that may be done about it; nothing: it holds its value.
Result<std::optional<Error>> settle(Link& link, StationRecord& s, const config::StartupRow& row) {
  const auto doubt = [&](Fault fault, std::string words) {
    return std::optional<Error>(Error{fault, fmt::format("{} {}", text(row), words), s.where});
  };
  auto held = read_held(link, s, row);
  if (!held && !refused(held.error())) return tl::unexpected(held.error());
  if (!held) {
    if (row.declared) return std::nullopt;
    return doubt(
        Fault::ParameterDiffers,
        fmt::format("cannot be read, so that it is not known to be {}: {}{}", row.value, held.error().message,
                    row.name.empty() ? "" : fmt::format("; if it is set otherwise, write `declared: [{}]`", row.name)));
  }
  if (held->value == row.value) return std::nullopt;
  const std::string differs = fmt::format("is {}, the machine file asks for {}", held->value, row.value);
  if (row.rule == config::ParameterRule::MustEqual)
    return doubt(Fault::ParameterDiffers,
                 differs + "; it is never written: check the station, or correct the machine file");
  if (row.acts == config::ActsAt::PowerUp) {
    const std::string name = s.config != nullptr ? s.config->name : fmt::format("{}", s.position);
    return doubt(
        Fault::ParameterDiffers,
        fmt::format("{}, and it acts at power-up: `gantry commission {} --write`, then switch its supply off and on",
                    differs, name));
  }
  const auto ignored = [&](std::int64_t read_back) {
    return doubt(Fault::ParameterDiffers,
                 fmt::format("reads back as {}, written was {}: the station ignores it", read_back, row.value));
  };
  const auto known = std::ranges::find_if(
      s.ignored, [&](const IgnoredWrite& w) { return w.address == row.address && w.written == row.value; });
  if (known != s.ignored.end()) return ignored(known->read_back);
  if (auto ok = write_held(link, s, row, held->bytes); !ok) {
    if (!is_refusal(ok.error())) return tl::unexpected(ok.error());
    return doubt(Fault::ParameterDiffers, fmt::format("{}, and was refused: {}", differs, ok.error().message));
  }
  held = read_held(link, s, row);
  if (!held && !refused(held.error())) return tl::unexpected(held.error());
  if (held && held->value == row.value) return std::nullopt;
  if (!held) return doubt(Fault::ParameterDiffers, fmt::format("cannot be read back: {}", held.error().message));
  s.ignored.push_back({row.address, row.value, held->value});
  return ignored(held->value);
}

/// What it holds of limits that nothing pins. One that it does not show is not known; that is no doubt.
Result<void> read_limits(Link& link, StationRecord& s) {
  s.held.clear();
  if (s.config == nullptr || !s.config->profile.drive) return {};
  for (const config::StartupRow& row : config::not_pinned(s.config->profile)) {
    if (!config::is_limit(row)) continue;
    const auto held = read_held(link, s, row);
    if (held) s.held.push_back({row.address, held->value});
    if (!held && !refused(held.error())) return tl::unexpected(held.error());
  }
  return {};
}

}  // namespace

bool is_refusal(const Error& of_write) { return refused(of_write) || of_write.fault == Fault::OutOfRange; }

Result<HeldObject> read_held(Link& link, StationRecord& s, const config::StartupRow& row) {
  const auto bytes = sdo_upload(link, s, row.address, SdoAccess::Single, nullptr, bytes_of(row.type));
  if (!bytes) return tl::unexpected(bytes.error());
  const bool minus = is_signed(row.type);
  const std::size_t n = bytes->size();
  const ObjectType type = n == 1   ? (minus ? ObjectType::I8 : ObjectType::U8)
                          : n == 2 ? (minus ? ObjectType::I16 : ObjectType::U16)
                                   : (minus ? ObjectType::I32 : ObjectType::U32);
  const auto value = to_number(type, *bytes);
  if (!value)
    return fail(Fault::SdoSizeMismatch, fmt::format("{} has {} bytes, which is no number", text(row), n), s.where);
  return HeldObject{*value, n};
}

Result<void> write_held(Link& link, StationRecord& s, const config::StartupRow& row, std::size_t bytes) {
  const int width = static_cast<int>(8 * bytes);
  const std::int64_t high = (std::int64_t{1} << (is_signed(row.type) ? width - 1 : width)) - 1;
  const std::int64_t low = is_signed(row.type) ? -high - 1 : 0;
  if (row.value < low || row.value > high)
    return fail(Fault::OutOfRange, fmt::format("{} does not fit its {} bytes", row.value, bytes), s.where);
  Bytes raw = to_bytes(ObjectType::I32, row.value);
  raw.resize(bytes);
  return sdo_download(link, s, row.address, raw);
}

std::optional<Error> needs_restart(const config::Station& station, bool since_power_up, const std::string& where) {
  if (!station.restart_pending || since_power_up) return std::nullopt;
  return Error{Fault::RestartNeeded, "parameters were written that act at power-up; switch its supply off and on",
               where};
}

Result<void> write_startup(Link& link, StationRecord& s) {
  s.doubts.clear();
  if (s.config != nullptr)
    if (auto doubt = needs_restart(*s.config, s.since_power_up, s.where)) s.doubts.push_back(*std::move(doubt));
  for (const auto& row : s.startup) {
    auto doubt = settle(link, s, row);
    if (!doubt) return tl::unexpected(doubt.error());
    if (*doubt) s.doubts.push_back(std::move(**doubt));
  }
  return read_limits(link, s);
}

Result<void> compare_held(Link& link, StationRecord& s, const config::StartupRow& row) {
  const auto held = read_held(link, s, row);
  if (!held && !refused(held.error())) return tl::unexpected(held.error());
  if (!held || held->value == row.value) return {};
  s.doubts.push_back({Fault::ParameterDiffers,
                      fmt::format("{} is {} since the drive is enabled, and was {} before: the station changes it by "
                                  "itself; look for what sets it there (its own software, another master)",
                                  text(row), held->value, row.value),
                      s.where});
  return {};
}

Result<void> save_parameters(Link& link, StationRecord& s, const config::StationProfile& profile,
                             std::span<const config::ObjectAddress> written) {
  if (profile.storage != config::Storage::OnSave) return {};
  constexpr std::uint16_t kStore = 0x1010, kProfileArea = 0x6000, kVendorArea = 0x2000;
  constexpr std::int64_t kSave = 0x65766173;  // "save"
  struct Group {
    std::uint8_t sub;
    std::uint16_t first, end;
  };
  for (const Group& group : {Group{1, kProfileArea, 0xA000}, Group{2, kVendorArea, kProfileArea}}) {
    const auto in_group = [&](config::ObjectAddress a) { return a.index >= group.first && a.index < group.end; };
    if (std::ranges::none_of(written, in_group)) continue;
    if (auto ok = write_number(link, s, {kStore, group.sub}, ObjectType::U32, kSave); !ok) return ok;
  }
  return {};
}

}  // namespace gantry::devices
