#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <set>

#include "core/near_word.hpp"
#include "core/units.hpp"
#include "recipes/body_names.hpp"
#include "recipes/job.hpp"
#include "recipes/reach.hpp"
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
    if (!framed || !check_seat(recipe_, machine_, mistakes_)) return;
    for (const MarkDef& m : recipe_.marks) mark(m);
    marks_are_seen();
    touches();
    purge();
    for (const Feature& f : recipe_.features) std::visit([&](const auto& each) { feature(each); }, f);
    check_surface_doubt(recipe_, machine_, mistakes_);
    reach_.tell();
  }
  /// What does not ask where anything lies.
  void general() {
    outputs();
    check_body_names(recipe_, machine_, mistakes_);
    check_tools(recipe_, machine_, mistakes_);
    for (const Material& material : recipe_.materials) speed(material);
  }
  bool frame() { return known_frame(recipe_.board.frame, recipe_.board.frame_location); }

 private:
  bool known_frame(const std::string& name, Location location) {
    if (config::find_frame(machine_, name)) return true;
    if (name.empty()) return false;  // that it could not be read is told already
    std::vector<std::string_view> known;
    for (const auto& frame : machine_.frames) known.push_back(frame.name);
    mistakes_.add(Fault::UnknownReference,
                  fmt::format("machine '{}' has no frame '{}'; {}", machine_.name, name, did_you_mean(name, known)),
                  location);
    return false;
  }

  /// How far a point of the board may stand from its nominal place by the mark rules.
  [[nodiscard]] double wander(Vec2 at) const {
    if (recipe_.marks.empty()) return 0;
    return recipe_.mark_rules.max_shift_mm + 2 * norm(at) * std::sin(recipe_.mark_rules.max_rotation_rad / 2);
  }

  /// A tool's tip over a point of the board.
  Reach::Ask over(std::string_view tool, Vec2 at, double height_mm, Location location, std::string what) const {
    return {.tool = tool,
            .tip = to_machine(recipe_, machine_, {}, {}, at, height_mm),
            .location = location,
            .what = std::move(what)};
  }
  /// The board may lie off by as much as the rules of the marks allow.
  Reach::Ask wherever(Reach::Ask ask, Vec2 at) const {
    ask.around = wander(at);
    if (!recipe_.marks.empty()) ask.by_turn = ask.around - recipe_.mark_rules.max_shift_mm;
    return ask;
  }

  /// What a recipe asks of the machine's outputs, told where it asks first.
  void outputs() {
    using config::Output;
    const auto wants = [&](Output output, std::string_view what, Location location) {
      if (!machine_.outputs[static_cast<std::size_t>(output)])
        mistakes_.add(
            Fault::UnknownReference,
            fmt::format("machine '{}' has no output '{}', without which {}", machine_.name, config::name(output), what),
            location);
    };
    if (!recipe_.marks.empty()) wants(Output::CameraTrigger, "the camera sees no mark", recipe_.marks.front().location);
    if (!recipe_.features.empty())
      wants(Output::Valve, "nothing is dispensed",
            std::visit([](const auto& f) { return f.location; }, recipe_.features.front()));
  }

  void speed(const Material& material) {
    const double most = std::min(machine_.axes[machine_.x.value].v_max, machine_.axes[machine_.y.value].v_max);
    if (material.speed > most)
      mistakes_.add(Fault::SpeedNotReachable,
                    fmt::format("material '{}' asks for {:.6g} mm/s; the machine reaches {:.6g} mm/s", material.name,
                                material.speed, most),
                    material.locations.speed.line > 0 ? material.locations.speed : material.location);
    if (material.min_speed > material.speed)
      mistakes_.add(Fault::Inconsistent,
                    fmt::format("material '{}': 'min_speed' of {:.6g} mm/s is more than its 'speed' of {:.6g} mm/s; "
                                "write at most that",
                                material.name, material.min_speed, material.speed),
                    material.locations.min_speed);
    if (material.min_speed > 0 && material.start_dwell_s > 0)
      mistakes_.add(Fault::Inconsistent,
                    fmt::format("material '{}': with 'start_dwell' a bead begins from rest, and 'min_speed' of {:.6g} "
                                "mm/s forbids that; leave one of them out",
                                material.name, material.min_speed),
                    material.locations.min_speed);
  }

  /// How far from the middle of the picture a mark's centre may be to be found.
  [[nodiscard]] double seen_mm(const MarkDef& m) const {
    const config::CameraConfig& camera = machine_.camera;
    return std::min(camera.search_mm,
                    0.5 * camera.mm_per_px * std::min(camera.width_px, camera.height_px) - m.diameter / 2);
  }

  void mark(const MarkDef& m) {
    // The camera looks where the mark should be; where it is then is looked for within the image.
    reach_.look(over("camera", m.at, 0, m.location, fmt::format("mark '{}'", m.name)));
    const config::CameraConfig& camera = machine_.camera;
    const double image = 0.5 * camera.mm_per_px * std::min(camera.width_px, camera.height_px);
    if (m.diameter / 2 >= std::min(image, camera.search_mm) && too_large_.insert(m.diameter).second)
      mistakes_.add(Fault::OutOfReach,
                    fmt::format("mark '{}' of {:.6g} mm is larger than what the camera sees ({:.6g} mm)", m.name,
                                m.diameter, 2 * std::min(image, camera.search_mm)),
                    m.location);
  }

  /// A board that lies off as far as the rules allow has to show its marks; of one that is turned, two of them.
  void marks_are_seen() {
    const MarkRules& rules = recipe_.mark_rules;
    if (recipe_.marks.size() < 2) return;
    const auto least = std::min_element(recipe_.marks.begin(), recipe_.marks.end(),
                                        [&](auto& a, auto& b) { return seen_mm(a) < seen_mm(b); });
    const double most = seen_mm(*least);
    if (most <= 0) return;  // a mark that is too large is told itself
    if (rules.locations.max_shift.line > 0 && rules.max_shift_mm > most)
      mistakes_.add(Fault::OutOfReach,
                    fmt::format("with 'max_shift' a board may lie {:.6g} mm off, and the camera finds mark '{}' up to "
                                "{:.6g} mm from where it should be; write at most that",
                                rules.max_shift_mm, least->name, most),
                    rules.locations.max_shift);
    std::vector<double> arms;  // from the board's origin, about which it turns
    for (const MarkDef& m : recipe_.marks) arms.push_back(norm(m.at));
    std::nth_element(arms.begin(), arms.begin() + 1, arms.end());
    const double turned_mm = 2 * arms[1] * std::sin(rules.max_rotation_rad / 2);
    if (rules.locations.max_rotation.line == 0 || turned_mm <= most) return;
    mistakes_.add(
        Fault::OutOfReach,
        fmt::format("with 'max_rotation' a board may be turned by {:.6g} deg, which takes all marks but one "
                    "{:.6g} mm and more away, and the camera finds them up to {:.6g} mm from where they should "
                    "be; write at most {:.2g} deg",
                    units::deg(rules.max_rotation_rad), turned_mm, most,
                    units::deg(2 * std::asin(most / (2 * arms[1])))),
        rules.locations.max_rotation);
  }

  [[nodiscard]] bool window_is_covered() const {
    const config::ProbeConfig& probe = machine_.probe;
    const double window = recipe_.touch_rules.window_mm;
    return probe.approach_mm >= window && probe.approach_mm - probe.travel_mm <= -window;
  }
  /// What the probe does not cover is told itself, and nothing besides is by it.
  [[nodiscard]] double window() const { return window_is_covered() ? recipe_.touch_rules.window_mm : 0; }

  /// The probe's own way, and where the touches are.
  void touches() {
    const config::ProbeConfig& probe = machine_.probe;
    const double end = probe.approach_mm - probe.travel_mm;
    if (!recipe_.touches.empty() && !window_is_covered()) {
      const TouchPoint& first = recipe_.touches.front();
      const Location written = recipe_.touch_rules.window_location;
      mistakes_.add(Fault::OutOfReach,
                    fmt::format("touch '{}': the probe goes from {:.6g} to {:.6g} mm above nominal, which does not "
                                "cover the 'window' of +-{:.6g} mm; write at most {:.6g} mm",
                                first.name, probe.approach_mm, end, recipe_.touch_rules.window_mm,
                                std::min(probe.approach_mm, -end)),
                    written.line > 0 ? written : first.location);
    }
    for (const TouchPoint& t : recipe_.touches) {
      Reach::Ask ask = wherever(over("probe", t.at, end, t.location, fmt::format("touch '{}'", t.name)), t.at);
      ask.lift = std::max(probe.approach_mm, window() + probe.retract_mm) - end;
      reach_.look(std::move(ask));
    }
  }

  void purge() {
    if (!recipe_.purge) return;
    const Purge& purge = *recipe_.purge;
    if (!purge.frame.empty() && !known_frame(purge.frame, purge.frame_location)) return;
    const Material* material = find_material(recipe_, purge.material);
    if (material == nullptr) return;
    const bool on_board = purge.frame.empty();
    Reach::Ask ask{.tool = "needle",
                   .tip = purge_tip(recipe_, machine_, {}, {}),
                   .lift = material->retract,
                   .window = on_board && !recipe_.touches.empty() ? window() : 0,
                   .location = purge.at_location,
                   .what = "purging",
                   .material = material,
                   .on_board = on_board};
    reach_.look(on_board ? wherever(std::move(ask), flat(purge.at)) : std::move(ask));
    const Vec3 on_the_board = purge_tip(recipe_, machine_, {}, {}) - to_machine(recipe_, machine_, {}, {}, {}, 0);
    if (const Feature* hit = feature_near(recipe_, flat(on_the_board), kPurgeClear_mm))
      mistakes_.add(Fault::Inconsistent,
                    fmt::format("the purge shoots onto '{}', or within {:.6g} mm of it; put its 'at' beside the work",
                                id_of(*hit), kPurgeClear_mm),
                    purge.at_location);
  }

  void needle(Vec3 at, const std::string& material_name, const std::string& id, Location location, bool& told,
              bool by_tail = false) {
    const Material* material = find_material(recipe_, material_name);
    if (told || !material) return;
    Reach::Ask ask = wherever(over("needle", flat(at), at.z + material->gap, location, id), flat(at));
    ask.lift = by_tail ? material->tail_lift : material->retract;
    ask.by_tail = by_tail;
    ask.window = recipe_.touches.empty() ? 0 : window();
    ask.material = material;
    told = !reach_.look(std::move(ask));
  }
  void feature(const Dot& dot) {
    bool told = false;
    needle({dot.at.x, dot.at.y, dot.height_mm}, dot.material, dot.id, dot.location, told);
  }
  void feature(const Bead& bead) {
    bool told = false;
    for (const Vec3 p : bead.points) needle(p, bead.material, bead.id, bead.location, told);
    const Material* material = find_material(recipe_, bead.material);
    if (told || material == nullptr || material->tail_lift <= 0) return;
    const Vec3 leaves =
        material->back_track > 0 ? retrace(bead, material->back_track, 0).points.back() : bead.points.back();
    needle(leaves, bead.material, bead.id, bead.location, told, true);
  }

  const Recipe& recipe_;
  const config::Machine& machine_;
  Mistakes& mistakes_;
  Reach reach_{recipe_, machine_, mistakes_};
  std::set<double> too_large_;  ///< diameters of marks that are told
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
    if (draft.recipe.board.frame_location.line > 0) of_machine.frame();
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
