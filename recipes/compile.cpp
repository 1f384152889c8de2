#include <algorithm>
#include <cmath>
#include <fmt/format.h>

#include "core/near_word.hpp"
#include "recipes/job.hpp"
#include "recipes/recipe_file.hpp"
#include "recipes/seat.hpp"
#include "recipes/surface_doubt.hpp"
#include "recipes/twice.hpp"
#include "recipes/valve_leads.hpp"

namespace gantry::recipes {
namespace {

using config::Mistakes;

/// Judges a recipe on a machine: every point within reach wherever the rules allow the board to lie.
class Feasibility {
 public:
  Feasibility(const Recipe& recipe, const config::Machine& machine, Mistakes& mistakes)
      : recipe_(recipe), machine_(machine), mistakes_(mistakes) {}

  void check() {
    const bool framed = frame();
    general();
    if (!framed) return;
    check_seat(recipe_, machine_, mistakes_);
    for (const MarkDef& m : recipe_.marks) mark(m);
    for (const TouchPoint& t : recipe_.touches) touch(t);
    purge();
    for (const Feature& f : recipe_.features) std::visit([&](const auto& each) { feature(each); }, f);
    check_surface_doubt(recipe_, machine_, mistakes_);
  }
  /// What does not ask where anything lies.
  void general() {
    outputs();
    check_tools(recipe_, machine_, mistakes_);
    for (const Material& material : recipe_.materials) speed(material);
  }
  bool frame() { return known_frame(recipe_.board.frame, recipe_.board.frame_place); }

 private:
  bool known_frame(const std::string& name, Location place) {
    if (config::find_frame(machine_, name)) return true;
    std::vector<std::string_view> known;
    for (const auto& frame : machine_.frames) known.push_back(frame.name);
    mistakes_.add(Fault::UnknownReference,
                  fmt::format("machine '{}' has no frame '{}'; {}", machine_.name, name, did_you_mean(name, known)),
                  place);
    return false;
  }

  /// How far a point of the board may stand from its nominal place by the mark rules.
  [[nodiscard]] double wander(Vec2 at) const {
    if (recipe_.marks.empty()) return 0;
    return recipe_.mark_rules.max_shift_mm + 2 * norm(at) * std::sin(recipe_.mark_rules.max_rotation_rad / 2);
  }

  /// Tool's tip at a point of the board, `low` .. `high` above the nominal surface, `around` mm to every side.
  bool reach(std::string_view tool_name, Vec2 at, double low, double high, double around, Location place,
             std::string_view what) {
    return reach(tool_name, to_machine(recipe_, machine_, {}, {}, at, 0), low, high, around, place, what);
  }
  /// The same of a point of the machine frame.
  bool reach(std::string_view tool_name, Vec3 tip, double low, double high, double around, Location place,
             std::string_view what) {
    const config::Tool* tool = config::find_tool(machine_, tool_name);
    if (!tool) return false;  // told by check_tools()
    const AxisVec q = tool_at(machine_, *tool, tip, 0);
    const auto bounds = {
        std::tuple{machine_.x, -around, around}, {machine_.y, -around, around}, {machine_.z, low, high}};
    for (const auto& [id, down, up] : bounds) {
      const config::Axis& axis = machine_.axes[id.value];
      const double least = q[id.value] + down, most = q[id.value] + up;
      if (least >= axis.p_min && most <= axis.p_max) continue;
      mistakes_.add(Fault::OutOfReach,
                    fmt::format("{} needs axis {} at {:.2f} .. {:.2f} mm (the {}, board off by up to {:.2f} mm); it "
                                "travels {:.6g} .. {:.6g} mm",
                                what, axis.name, least, most, tool_name, around, axis.p_min, axis.p_max),
                    place);
      return false;
    }
    return true;
  }

  /// What a recipe asks of the machine's outputs, told where it asks first.
  void outputs() {
    using config::Output;
    const auto wants = [&](Output output, std::string_view what, Location place) {
      if (!machine_.outputs[static_cast<std::size_t>(output)])
        mistakes_.add(
            Fault::UnknownReference,
            fmt::format("machine '{}' has no output '{}', without which {}", machine_.name, config::name(output), what),
            place);
    };
    if (!recipe_.marks.empty()) wants(Output::CameraTrigger, "the camera sees no mark", recipe_.marks.front().place);
    if (!recipe_.features.empty())
      wants(Output::Valve, "nothing is dispensed",
            std::visit([](const auto& f) { return f.place; }, recipe_.features.front()));
  }

  void speed(const Material& material) {
    const double most = std::min(machine_.axes[machine_.x.value].v_max, machine_.axes[machine_.y.value].v_max);
    if (material.speed > most)
      mistakes_.add(Fault::SpeedNotReachable,
                    fmt::format("material '{}' asks for {:.6g} mm/s; the machine reaches {:.6g} mm/s", material.name,
                                material.speed, most),
                    material.place);
    if (material.min_speed > material.speed)
      mistakes_.add(Fault::Inconsistent,
                    fmt::format("material '{}': 'min_speed' of {:.6g} mm/s is more than its 'speed' of {:.6g} mm/s; "
                                "write at most that",
                                material.name, material.min_speed, material.speed),
                    material.place);
    if (material.min_speed > 0 && material.start_dwell_s > 0)
      mistakes_.add(Fault::Inconsistent,
                    fmt::format("material '{}': with 'start_dwell' a bead begins from rest, and 'min_speed' of {:.6g} "
                                "mm/s forbids that; leave one of them out",
                                material.name, material.min_speed),
                    material.place);
  }

  void mark(const MarkDef& m) {
    // The camera looks where the mark should be; where it is then is looked for within the image.
    reach("camera", m.at, 0, 0, 0, m.place, fmt::format("mark '{}'", m.name));
    const config::CameraConfig& camera = machine_.camera;
    const double image = 0.5 * camera.mm_per_px * std::min(camera.width_px, camera.height_px);
    if (m.diameter / 2 >= std::min(image, camera.search_mm))
      mistakes_.add(Fault::OutOfReach,
                    fmt::format("mark '{}' of {:.6g} mm is larger than what the camera sees ({:.6g} mm)", m.name,
                                m.diameter, 2 * std::min(image, camera.search_mm)),
                    m.place);
  }

  void touch(const TouchPoint& t) {
    const config::ProbeConfig& probe = machine_.probe;
    const double window = recipe_.touch_rules.window_mm;
    const double end = probe.approach_mm - probe.travel_mm;
    if (probe.approach_mm < window || end > -window)
      mistakes_.add(
          Fault::OutOfReach,
          fmt::format("touch '{}': the probe goes from {:.6g} to {:.6g} mm above nominal, which does not cover "
                      "the window of +-{:.6g} mm",
                      t.name, probe.approach_mm, end, window),
          t.place);
    reach("probe", t.at, end, std::max(probe.approach_mm, window + probe.retract_mm), wander(t.at), t.place,
          fmt::format("touch '{}'", t.name));
  }

  void purge() {
    if (!recipe_.purge) return;
    const Purge& purge = *recipe_.purge;
    if (!purge.frame.empty() && !known_frame(purge.frame, purge.frame_place)) return;
    const Material* material = find_material(recipe_, purge.material);
    if (material == nullptr) return;
    const bool on_board = purge.frame.empty();
    const double window = on_board && !recipe_.touches.empty() ? recipe_.touch_rules.window_mm : 0;
    reach("needle", purge_tip(recipe_, machine_, {}, {}), -window, material->retract + window,
          on_board ? wander(flat(purge.at)) : 0, purge.at_place, "purging");
    const Vec3 on_the_board = purge_tip(recipe_, machine_, {}, {}) - to_machine(recipe_, machine_, {}, {}, {}, 0);
    if (const Feature* hit = feature_near(recipe_, flat(on_the_board), kPurgeClear_mm))
      mistakes_.add(Fault::Inconsistent,
                    fmt::format("the purge shoots onto '{}', or within {:.6g} mm of it; put its 'at' beside the work",
                                id_of(*hit), kPurgeClear_mm),
                    purge.at_place);
  }

  void needle(Vec2 at, double height_mm, const std::string& material_name, const std::string& id, Location place,
              bool& told) {
    const Material* material = find_material(recipe_, material_name);
    if (told || !material) return;
    const double window = recipe_.touches.empty() ? 0 : recipe_.touch_rules.window_mm;
    const double gap = height_mm + material->gap;
    told = !reach("needle", at, gap - window, gap + material->retract + window, wander(at), place, id);
  }
  void feature(const Dot& dot) {
    // An array is one line of the recipe: it is told once.
    if (dot.place == last_told_) return;
    bool told = false;
    needle(dot.at, dot.height_mm, dot.material, dot.id, dot.place, told);
    if (told) last_told_ = dot.place;
  }
  void feature(const Bead& bead) {
    bool told = false;
    for (const Vec3 p : bead.points) needle(flat(p), p.z, bead.material, bead.id, bead.place, told);
  }

  const Recipe& recipe_;
  const config::Machine& machine_;
  Mistakes& mistakes_;
  Location last_told_;
};

}  // namespace

Checked<Compiled> load_for(const std::string& path, const config::Machine& machine) {
  auto read = written::draft_file(path);
  if (!read) return tl::unexpected(std::vector{read.error()});
  written::Draft draft = *std::move(read);
  if (draft.mistakes.empty()) {
    auto job = compile(draft.recipe, machine);
    if (!job) return tl::unexpected(job.error());
    return Compiled{std::move(draft.recipe), *std::move(job)};
  }
  if (draft.readable) {
    Mistakes more(path);
    Feasibility of_machine(draft.recipe, machine, more);
    if (draft.recipe.board.frame_place.line > 0) of_machine.frame();
    of_machine.general();
    const std::vector<Error> errors = more.errors();
    draft.mistakes.insert(draft.mistakes.end(), errors.begin(), errors.end());
  }
  return tl::unexpected(std::move(draft.mistakes));
}

Checked<Job> compile(const Recipe& recipe, const config::Machine& machine) {
  Mistakes mistakes(recipe.file);
  Feasibility(recipe, machine, mistakes).check();
  check_valve_leads(recipe, machine, mistakes);
  if (!mistakes.none()) return tl::unexpected(mistakes.errors());

  Job job;
  const auto add = [&job](auto what) {
    job.blocks.push_back({static_cast<std::uint32_t>(job.blocks.size() + 1), std::move(what)});
  };
  for (std::size_t i = 0; i < recipe.marks.size(); ++i) add(LookAtMark{i});
  for (std::size_t i = 0; i < recipe.touches.size(); ++i) add(Touch{i});
  if (recipe.purge) add(PurgeNeedle{});
  add(Dispense{sequence_of(recipe)});
  add(Park{});
  return job;
}

}  // namespace gantry::recipes
