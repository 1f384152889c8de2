#include "sim/world/camera.hpp"

#include <algorithm>
#include <limits>

#include "sim/random.hpp"

namespace gantry::sim {

namespace {
constexpr std::size_t kKept = 16;  ///< frames that nobody fetched are dropped beyond this

std::uint64_t hash(std::string_view text) {
  std::uint64_t h = 0;
  for (const char c : text) h = mix(h, static_cast<unsigned char>(c));
  return h;
}
}  // namespace

int nearest_mark(const BoardPlan& plan, Vec2 at) {
  int best = -1;
  double nearest = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < plan.marks.size(); ++i)
    if (const double d = norm(plan.marks[i].at - at); d < nearest) nearest = d, best = static_cast<int>(i);
  return best;
}

SimCamera::SimCamera(const config::Machine& machine, Clock& clock, std::uint64_t seed)
    : config_(machine.camera), noise_(machine.sim.camera_noise), clock_(clock), seed_(seed) {}

void SimCamera::expose(Vec3 focus, Vec2 speed_mm_s, bool light, std::shared_ptr<const BoardTruth> board) {
  auto e = std::make_shared<Exposure>();
  e->view.focus = focus;
  e->view.drift = speed_mm_s * config_.exposure_s;
  e->view.light = light;
  e->view.width_px = config_.width_px;
  e->view.height_px = config_.height_px;
  e->view.mm_per_px = config_.mm_per_px;
  e->view.noise = noise_;
  std::string mark;
  if (board) {
    const Vec3 at = board->to_board(focus);
    if (const int i = nearest_mark(board->plan, {at.x, at.y}); i >= 0)
      mark = board->plan.marks[static_cast<std::size_t>(i)].name;
  }
  e->board = std::move(board);
  const std::scoped_lock lock(mutex_);
  if (dead_) return;
  e->noise_seed = mix(mix(seed_, hash(mark)), attempts_[mark]++);
  e->counter = ++counter_;
  kept_.push_back(std::move(e));
  if (kept_.size() > kKept) kept_.pop_front();
}

void SimCamera::begin_job() {
  const std::scoped_lock lock(mutex_);
  attempts_.clear();
}

void SimCamera::set_dead(bool dead) {
  const std::scoped_lock lock(mutex_);
  dead_ = dead;
}

std::uint64_t SimCamera::latest() {
  const std::scoped_lock lock(mutex_);
  return counter_;
}

std::shared_ptr<const SimCamera::Exposure> SimCamera::first_after(std::uint64_t after) {
  const std::scoped_lock lock(mutex_);
  const auto at = std::find_if(kept_.begin(), kept_.end(), [&](const auto& e) { return e->counter > after; });
  return at == kept_.end() ? nullptr : *at;
}

Result<vision::Frame> SimCamera::fetch(std::uint64_t after, Time timeout) {
  const Time give_up = clock_.now() + timeout;
  std::shared_ptr<const Exposure> e = first_after(after);
  // Virtual time stands still in here: nothing can be exposed any more.
  while (!e && !clock_.is_virtual() && clock_.now() < give_up) {
    clock_.sleep_until(std::min(give_up, clock_.now() + milliseconds(1)));
    e = first_after(after);
  }
  if (!e) return fail(Fault::CameraTimeout, "the camera gave no frame: nothing was exposed in time", "camera");
  return vision::Frame{e->counter, render(e->view, e->board.get(), e->noise_seed)};
}

}  // namespace gantry::sim
