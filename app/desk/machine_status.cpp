#include "app/desk/machine_status.hpp"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "app/record/summary.hpp"
#include "core/units.hpp"

namespace gantry::desk {

using Json = nlohmann::ordered_json;

namespace {

Json on_the_wire(const run::WireCounts& wire) {
  return {{"frames", record::to_json(wire.frames)},
          {"mailbox_repeats", wire.mailbox_repeats},
          {"other_master", wire.other_master.empty() ? Json() : Json(wire.other_master)}};
}

}  // namespace

Json machine_status(const config::Machine& machine, const run::Owner& owner) {
  const cycle::Snapshot& s = owner.latest();
  const run::Progress p = owner.progress();
  const std::optional<double> stop_mm = owner.stop_mm();
  Json axes = Json::array(), faults = Json::array();
  for (const config::Axis& axis : machine.axes)
    axes.push_back({{"name", axis.name},
                    {"unit", axis.rotary ? "rad" : "mm"},
                    {"position", s.actual[axis.id.value]},
                    {"enabled", (s.enabled >> axis.id.value & 1u) != 0},
                    {"referenced", (s.referenced >> axis.id.value & 1u) != 0}});
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
          {"held", owner.held()},
          {"cycle", s.cycle},
          {"faults", faults},
          {"doing", p.doing},
          {"features_done", p.features_done},
          {"features_total", p.features_total},
          {"elapsed_s", p.elapsed_s},
          {"override", s.override_factor},
          {"stop_mm", stop_mm ? Json(*stop_mm) : Json(nullptr)},
          {"wire", on_the_wire(owner.wire())},
          {"axes", axes}};
}

std::string in_words(const Json& status) {
  std::string text = fmt::format("{}, {}, override {:.0f} %", status.value("state", "?"), status.value("mode", "?"),
                                 status.value("override", 1.0) * 100);
  if (const auto stop = status.find("stop_mm"); stop != status.end() && stop->is_number())
    text += fmt::format(", would stop within {:.2g} mm", stop->get<double>());
  if (status.value("held", false) && status.value("state", "") != "held") text += ", on hold";
  if (const auto total = status.value("features_total", 0); total > 0) {
    text +=
        fmt::format("\njob: {} of {} features, {}", status.value("features_done", 0), total, status.value("doing", ""));
    if (const auto left = status.find("remaining_s"); left != status.end() && left->is_number())
      text += fmt::format(", about {:.0f} s left", left->get<double>());
  }
  for (const Json& fault : status.value("faults", Json::array()))
    text += fmt::format("\nfault {}: {}\n    remedy: {}", fault.value("code", ""), fault.value("text", ""),
                        fault.value("remedy", ""));
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
