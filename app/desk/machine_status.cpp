#include "app/desk/machine_status.hpp"

#include <algorithm>
#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "app/record/summary.hpp"
#include "config/inputs.hpp"
#include "core/digits.hpp"
#include "core/units.hpp"

namespace gantry::desk {

using Json = nlohmann::ordered_json;

namespace {

Json on_the_wire(const run::WireCounts& wire) {
  return {{"frames", record::to_json(wire.frames)},
          {"mailbox_repeats", wire.mailbox_repeats},
          {"other_master", wire.other_master.empty() ? Json() : Json(wire.other_master)}};
}

/// Null: the machine has no such input.
Json door_word(const config::Machine& machine, std::uint32_t inputs) {
  if (!machine.inputs[static_cast<std::size_t>(config::Input::DoorClosed)]) return nullptr;
  return config::is_low(machine, inputs, config::Input::DoorClosed) ? "open" : "closed";
}

std::string text_of(const Json& status, const char* key) {
  const auto found = status.find(key);
  return found != status.end() && found->is_string() ? found->get<std::string>() : "";
}

/// Of a job, also one that is prepared; else what else is under way. "": nothing is.
std::string undertaking_in_words(const Json& status) {
  const std::string recipe = text_of(status, "recipe"), feature = text_of(status, "feature"),
                    doing = text_of(status, "doing");
  const auto total = status.value("features_total", 0);
  if (total == 0 && recipe.empty()) {
    const std::string order = text_of(status, "busy_with");
    return order.empty() ? "" : fmt::format("\nunder way: '{}'", order);
  }
  std::string text = "\njob: ";
  if (total > 0) text += fmt::format("{} of {} features", status.value("features_done", 0), total);
  if (!doing.empty()) text += (total > 0 ? ", " : "") + doing;
  if (!feature.empty() && doing.find(feature) == std::string::npos) text += fmt::format(", at '{}'", feature);
  if (total > 0) text += fmt::format(", {:.0f} s gone", status.value("elapsed_s", 0.0));
  if (const auto left = status.find("remaining_s"); left != status.end() && left->is_number())
    text += fmt::format(", about {:.0f} s left", left->get<double>());
  if (!recipe.empty()) text += "\n     " + recipe;
  return text;
}

}  // namespace

Json machine_status(const config::Machine& machine, const run::Owner& owner) {
  const cycle::Snapshot& s = owner.latest();
  const run::Progress p = owner.progress();
  const std::optional<double> stop_mm = owner.stop_mm();
  Json axes = Json::array(), faults = Json::array();
  for (const config::Axis& axis : machine.axes) {
    const bool referenced = (s.referenced >> axis.id.value & 1u) != 0;
    axes.push_back({{"name", axis.name},
                    {"unit", axis.rotary ? "rad" : "mm"},
                    {"position", s.actual[axis.id.value]},
                    {"enabled", (s.enabled >> axis.id.value & 1u) != 0},
                    {"referenced", referenced}});
  }
  for (const Error& e : owner.active_faults()) {
    const FaultInfo& f = info(e.fault);
    faults.push_back({{"code", std::string_view(code(e.fault))},
                      {"name", f.name},
                      {"text", e.message},
                      {"where", e.where},
                      {"remedy", f.remedy}});
  }
  return {{"ok", true},
          {"state", cycle::name(owner.state())},
          {"mode", owner.in_setup() ? "setup" : "automatic"},
          {"door", door_word(machine, s.inputs)},
          {"held", owner.held()},
          {"cycle", s.cycle},
          {"faults", faults},
          {"doing", p.doing},
          {"feature", p.feature.empty() ? Json() : Json(p.feature)},
          {"features_done", p.features_done},
          {"features_total", p.features_total},
          {"elapsed_s", p.elapsed_s},
          {"override", s.override_factor},
          {"override_next", p.override_next ? Json(*p.override_next) : Json(nullptr)},
          {"stop_mm", stop_mm ? Json(*stop_mm) : Json(nullptr)},
          {"wire", on_the_wire(owner.wire())},
          {"axes", axes}};
}

std::string at_most_mm(double mm) {
  constexpr double kLeast_mm = 0.01;  // nobody looks closer
  return fmt::format("{:.6g} mm", mm > 0 ? in_digits_up(std::max(mm, kLeast_mm), 2) : 0);
}

std::string in_words(const Json& status) {
  std::string text = fmt::format("{}, {}, override {:.0f} %", status.value("state", "?"), status.value("mode", "?"),
                                 status.value("override", 1.0) * 100);
  if (const auto next = status.find("override_next"); next != status.end() && next->is_number())
    text += fmt::format(" ({:.0f} % when the valve has shut)", next->get<double>() * 100);
  if (const std::string door = text_of(status, "door"); !door.empty()) text += ", door " + door;
  if (const auto stop = status.find("stop_mm"); stop != status.end() && stop->is_number())
    text += ", would stop within " + at_most_mm(stop->get<double>());
  text += undertaking_in_words(status);
  if (const auto held = status.find("held_by"); held != status.end() && held->is_object())
    text += fmt::format("\n{}; {}", text_of(*held, "words"), text_of(*held, "next"));
  else if (status.value("held", false))
    text += "\non hold";
  for (const Json& fault : status.value("faults", Json::array()))
    text += fmt::format("\nfault {}: {}{}\n    remedy: {}", fault.value("code", ""),
                        fault.value("where", "").empty() ? "" : fault.value("where", "") + ": ",
                        fault.value("text", ""), fault.value("remedy", ""));
  for (const Json& axis : status.value("axes", Json::array())) {
    const bool rotary = axis.value("unit", "mm") == "rad", referenced = axis.value("referenced", false);
    const double position = axis.value("position", 0.0) * (rotary ? units::deg(1) : 1);
    text += fmt::format("\n{:<6} {:>12} {:<3}  {}, {}", axis.value("name", ""),
                        referenced ? fmt::format("{:.3f}", position) : "-", rotary ? "deg" : "mm",
                        axis.value("enabled", false) ? "torque on" : "torque off",
                        referenced ? "referenced" : "not referenced");
  }
  return text;
}

}  // namespace gantry::desk
