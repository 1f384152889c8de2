// Outputs and inputs of a machine file: names, bits, terminals, and what `check` says of the wiring.
#include <algorithm>
#include <fmt/format.h>
#include <map>

#include "config/machine_file.hpp"
#include "core/near_word.hpp"

namespace gantry::config {
namespace {

using written::ChannelRow;

constexpr std::array<std::string_view, kOutputs> kOutputNames{
    "valve", "camera_light", "camera_trigger", "stack_red", "stack_yellow", "stack_green", "clamp", "healthy"};
constexpr std::array<std::string_view, kInputs> kInputNames{"start",       "stop",   "reset",        "hold",     "mode",
                                                            "door_closed", "air_ok", "clamp_closed", "safety_ok"};

/// One list of the file, `outputs` or `inputs`.
class Channels {
 public:
  Channels(bool outputs, const Machine& machine, Mistakes& mistakes)
      : outputs_(outputs), machine_(machine), mistakes_(mistakes) {}

  template <std::size_t N>
  void resolve(const std::vector<ChannelRow>& rows, const std::array<std::string_view, N>& known,
               std::array<std::optional<Channel>, N>& to, std::vector<FreeChannel>& rest) {
    for (const ChannelRow& row : rows) {
      const auto which = std::find(known.begin(), known.end(), row.name);
      if (which == known.end() && !may_be_free(row, rows, known, rest.size() + N)) continue;
      const auto channel = resolve(row);
      if (!channel) continue;
      if (outputs_ && row.name == kOutputNames[0] && row.invert)
        mistakes_.add(Fault::Inconsistent,
                      "an inverted valve is open whenever nobody writes its output: when the bus is lost, the program "
                      "ends or the station starts; wire a valve that is shut without current, and leave `invert` out",
                      row.invert_location);
      if (which == known.end())
        rest.push_back({row.name, *channel});
      else
        to[static_cast<std::size_t>(which - known.begin())] = channel;
    }
  }

 private:
  /// A free name that is nearly a known one which the file lacks is a slip of the pen: the light would stay dark, the
  /// clamp open. Where it would cost an interlock, or the valve, a name has to be less like it than elsewhere.
  template <std::size_t N>
  bool may_be_free(const ChannelRow& row, const std::vector<ChannelRow>& rows,
                   const std::array<std::string_view, N>& known, std::size_t bit) {
    std::string_view meant;
    std::vector<std::string_view> grave;
    for (std::size_t i = 0; i < N; ++i) {
      if (std::any_of(rows.begin(), rows.end(), [&](const ChannelRow& r) { return r.name == known[i]; })) continue;
      if (outputs_ ? known[i] == kOutputNames[0] : normally_closed(static_cast<Input>(i))) grave.push_back(known[i]);
      if (meant.empty() && slip_of(row.name, known[i])) meant = known[i];
    }
    if (const std::string_view near = nearest(row.name, grave); !near.empty()) meant = near;
    if (!meant.empty()) {
      mistakes_.add(Fault::UnknownReference,
                    fmt::format("'{}' is a free name, and this file has no '{}'; {} (a free name must be less like it)",
                                row.name, meant, did_you_mean(meant)),
                    row.location);
      return false;
    }
    if (bit < kChannelBits) return true;
    mistakes_.add(Fault::OutOfRange,
                  fmt::format("'{}' is one too many: {} names are known, and {} more may be free", row.name,
                              outputs_ ? kOutputs : kInputs, kChannelBits - (outputs_ ? kOutputs : kInputs)),
                  row.location);
    return false;
  }

  std::optional<Channel> resolve(const ChannelRow& row) {
    if (row.unread || !row.station.given() || machine_.stations.empty())
      return std::nullopt;  // that it is missing is told already
    std::vector<std::string_view> names;
    const Station* station = nullptr;
    for (const Station& s : machine_.stations) {
      names.push_back(s.name);
      if (s.name == row.station.value) station = &s;
    }
    if (station == nullptr) {
      mistakes_.add(
          Fault::UnknownReference,
          fmt::format("there is no station '{}'; {}", row.station.value, did_you_mean(row.station.value, names)),
          row.station.location);
      return std::nullopt;
    }
    if (station->profile.name.empty()) return std::nullopt;  // its profile has mistakes of its own
    if (station->profile.slots > 0) {
      mistakes_.add(Fault::Inconsistent, fmt::format("'{}' is a drive; name a station that is none", station->name),
                    row.station.location);
      return std::nullopt;
    }
    const auto bit = bit_of(row, *station);
    if (!bit) return std::nullopt;
    const Location location = row.terminal.given() ? row.terminal.location : row.bit.location;
    const auto [other, is_new] = taken_.try_emplace({station->id, *bit}, row.name);
    if (!is_new) mistakes_.add(Fault::Inconsistent, fmt::format("'{}' has this bit already", other->second), location);
    return Channel{station->id, static_cast<std::uint8_t>(*bit), row.invert};
  }

  std::optional<int> bit_of(const ChannelRow& row, const Station& station) {
    if (row.bit.given() == row.terminal.given()) {
      mistakes_.add(row.bit.given() ? Fault::Inconsistent : Fault::MissingKey,
                    fmt::format("'{}' needs exactly one of: bit, terminal", row.name), row.location);
      return std::nullopt;
    }
    if (row.terminal.given()) return bit_of_terminal(row.terminal, station);
    const int width = image_bits(station.profile, outputs_);
    if (row.bit.value < width) return single_bit(row.bit, station);
    mistakes_.add(Fault::OutOfRange, fmt::format("'{}' has {} bits, 0 first", station.name, width), row.bit.location);
    return std::nullopt;
  }

  /// One of an analogue value's bits is none that a machine can be switched by.
  std::optional<int> single_bit(const At<int>& bit, const Station& station) {
    for (const Terminal& t : station.profile.terminals)
      if (t.output == outputs_ && t.bits > 1 && bit.value >= t.bit && bit.value < t.bit + t.bits) {
        mistakes_.add(Fault::Inconsistent,
                      fmt::format("bit {} of '{}' is one of the {} of terminal '{}'; a channel is a bit of its own",
                                  bit.value, station.name, t.bits, t.name),
                      bit.location);
        return std::nullopt;
      }
    return bit.value;
  }

  std::optional<int> bit_of_terminal(const At<std::string>& name, const Station& station) {
    std::vector<std::string_view> names;
    for (const Terminal& t : station.profile.terminals) {
      if (t.output != outputs_) continue;
      names.push_back(t.name);
      if (t.name != name.value) continue;
      if (t.bits == 1 && t.bit < 256) return t.bit;
      mistakes_.add(Fault::Inconsistent,
                    fmt::format("terminal '{}' carries {} bits; a channel is one bit, below 256", t.name, t.bits),
                    name.location);
      return std::nullopt;
    }
    mistakes_.add(Fault::UnknownReference,
                  fmt::format("'{}' ({}) has no {} terminal '{}'; {}", station.name, station.profile.title,
                              outputs_ ? "output" : "input", name.value, did_you_mean(name.value, names)),
                  name.location);
    return std::nullopt;
  }

  bool outputs_;
  const Machine& machine_;
  Mistakes& mistakes_;
  std::map<std::pair<StationId, int>, std::string> taken_;
};

/// An EtherCAT station that carries what must be heard, and said, when the drives have lost their supply.
void note_station_behind_drives(const Machine& m, const Station& station, std::string_view carries,
                                std::vector<std::string>& out) {
  if (station.bus != BusKind::EtherCat) return;
  const auto drive = std::find_if(m.stations.begin(), m.stations.end(), [&](const Station& s) {
    return s.bus == BusKind::EtherCat && s.profile.drive && s.position < station.position;
  });
  if (drive != m.stations.end())
    out.push_back(fmt::format(
        "warning: station '{}' carries {} and stands behind drive '{}': it leaves the bus with the drives when an "
        "emergency stop takes their supply; put it first on the line, with a supply of its own",
        station.name, carries, drive->name));
}

}  // namespace

std::string_view name(Output output) {
  const auto i = static_cast<std::size_t>(output);
  return i < kOutputs ? kOutputNames[i] : "";
}
std::string_view name(Input input) {
  const auto i = static_cast<std::size_t>(input);
  return i < kInputs ? kInputNames[i] : "";
}

bool normally_closed(Input input) {
  return input == Input::Stop || input == Input::DoorClosed || input == Input::AirOk || input == Input::SafetyOk;
}

namespace {
template <std::size_t N>
std::vector<WordBit> word_bits(const std::array<std::optional<Channel>, N>& known,
                               const std::array<std::string_view, N>& names, const std::vector<FreeChannel>& rest) {
  std::vector<WordBit> out;
  for (std::size_t i = 0; i < N; ++i)
    if (known[i]) out.push_back({static_cast<unsigned>(i), names[i], *known[i]});
  for (std::size_t i = 0; i < rest.size(); ++i)
    out.push_back({static_cast<unsigned>(N + i), rest[i].name, rest[i].channel});
  return out;
}
}  // namespace

std::vector<WordBit> output_bits(const Machine& m) { return word_bits(m.outputs, kOutputNames, m.free_outputs); }
std::vector<WordBit> input_bits(const Machine& m) { return word_bits(m.inputs, kInputNames, m.free_inputs); }

void resolve_channels(const written::MachineFile& file, Machine& m, Mistakes& mistakes) {
  Channels(true, m, mistakes).resolve(file.outputs, kOutputNames, m.outputs, m.free_outputs);
  Channels(false, m, mistakes).resolve(file.inputs, kInputNames, m.inputs, m.free_inputs);
}

std::vector<std::string> channel_notes(const Machine& m) {
  std::vector<std::string> out;
  for (const Station& station : m.stations) {
    std::vector<std::string_view> carries;
    for (std::size_t i = 0; i < kInputs; ++i)
      if (const auto& c = m.inputs[i]; c && c->station == station.id && normally_closed(static_cast<Input>(i)))
        carries.push_back(kInputNames[i]);
    if (const auto& valve = m.outputs[static_cast<std::size_t>(Output::Valve)]; valve && valve->station == station.id)
      carries.push_back(name(Output::Valve));
    if (!carries.empty()) note_station_behind_drives(m, station, fmt::format("{}", fmt::join(carries, ", ")), out);
  }
  if (const auto& green = m.outputs[static_cast<std::size_t>(Output::StackGreen)]; green && green->invert)
    out.push_back("warning: output 'stack_green' is inverted: it is lit while nobody writes it, as if all were well");
  for (std::size_t i = 0; i < kInputs; ++i) {
    if (!normally_closed(static_cast<Input>(i))) continue;
    if (m.inputs[i] && m.inputs[i]->invert)
      out.push_back(
          fmt::format("warning: input '{}' is inverted: a broken wire reads as all well; wire a contact that opens, "
                      "without `invert`",
                      kInputNames[i]));
    if (!m.inputs[i])
      out.push_back(fmt::format("input '{}' is not there: the program does not stop by it", kInputNames[i]));
  }
  return out;
}

}  // namespace gantry::config
