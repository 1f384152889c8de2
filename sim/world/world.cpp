#include "sim/world/world.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>

namespace gantry::sim {

namespace {

using config::bit;
using config::Input;
using config::Output;

constexpr double kNoContact = -1e9;
/// A point of a bead is kept when the needle has moved by this since the last.
constexpr double kSameSpot_mm = 5e-4;

Time time_of(double seconds_) { return Time(static_cast<std::int64_t>(std::llround(seconds_ * 1e9))); }

/// Contacts that are normally closed are closed, the clamp is where its output puts it, the mode is automatic, and no
/// button is pressed.
std::uint32_t inputs_at_rest() {
  std::uint32_t closed = bit(Input::ClampClosed) | bit(Input::Mode);
  for (std::size_t i = 0; i < config::kInputs; ++i)
    if (config::normally_closed(static_cast<Input>(i))) closed |= bit(static_cast<Input>(i));
  return closed;
}

AxisVec between(const AxisVec& a, const AxisVec& b, double t) {
  AxisVec out;
  for (std::size_t i = 0; i < out.size(); ++i) out[i] = a[i] + (b[i] - a[i]) * t;
  return out;
}

}  // namespace

World::World(const config::Machine& machine, Clock& clock, std::uint64_t seed, std::optional<PlacementText> placement)
    : machine_(machine),
      seed_(seed),
      placement_text_(placement),
      head_(machine),
      camera_(machine, clock, seed),
      watch_(head_),
      valve_(time_of(machine.sim.valve_open_lag_s), time_of(machine.sim.valve_close_lag_s)),
      steady_inputs_(inputs_at_rest()) {
  for (const config::WordBit& input : config::input_bits(machine))
    if (input.channel.invert) inverted_inputs_ |= 1u << input.bit;
  shots_.reserve(4096);
  place_solids();
}

Senses World::step(std::uint64_t cycle, Time now, const Moment& moment) {
  const std::scoped_lock lock(mutex_);
  bus_actions_.clear();
  if (!stepped_) {
    stepped_ = true;
    last_ = now;
    before_ = moment;
  }
  const double dt_s = std::max(seconds(now - last_), 1e-9);
  run_valve(last_, now, before_.axes, moment.axes, cycle);
  run_collisions(before_.axes, moment.axes, dt_s, cycle);
  run_clamp(moment, now);
  valve_.command((moment.outputs & bit(Output::Valve)) != 0, now);
  if ((moment.outputs & ~before_.outputs) & bit(Output::CameraTrigger)) run_camera(moment, dt_s, now);

  Senses senses;
  senses.probe_contact = probe_contact(moment.axes);
  const bool touching = head_.probe.exists && moment.axes[machine_.probe.axis.value] <= senses.probe_contact;
  if (touching && !touching_) fire(Trigger::Kind::NthTouch, ++job_touches_, {}, now);
  touching_ = touching;

  if (!script_.empty()) run_script(cycle, now);
  senses.inputs = inputs(moment.outputs, now);
  senses.bus = bus_actions_;
  last_ = now;
  before_ = moment;
  return senses;
}

// --- Needle and valve ---

Vec3 World::needle_on_board(const AxisVec& q) const {
  const Vec3 tip = head_.in_machine(head_.needle, q);
  return board_ ? board_->to_board(tip) : tip;
}

void World::run_valve(Time from, Time to, const AxisVec& a, const AxisVec& b, std::uint64_t cycle) {
  const double length = std::max(seconds(to - from), 1e-9);
  while (const auto edge = valve_.next_edge(to)) {
    const double t = std::clamp(seconds(edge->at - from) / length, 0.0, 1.0);
    const Vec3 at = needle_on_board(between(a, b, t));
    edge->open ? opened(at, edge->at, cycle) : closed(at, edge->at, cycle);
  }
  if (!open_) return;
  const Vec3 at = needle_on_board(b);
  if (norm(at - open_->path.back()) < kSameSpot_mm) return;
  open_->path.push_back(at);
  open_->since.push_back(static_cast<std::uint32_t>(cycle - open_->opened_cycle));
  if (log_) {
    const ShotRecord r{0, cycle, at.x, at.y, at.z};
    log_->append(WorldLog::Kind::ShotPoint, std::as_bytes(std::span(&r, 1)));
  }
}

void World::opened(Vec3 at, Time when, std::uint64_t cycle) {
  open_ = std::make_shared<Shot>();
  open_->path.reserve(4096);
  open_->opened = when;
  open_->opened_cycle = cycle;
  open_->path.push_back(at);
  open_->since.push_back(0);
  ++valve_shots_;
  if (log_) {
    const ShotRecord r{when.count(), cycle, at.x, at.y, at.z};
    log_->append(WorldLog::Kind::ShotOpened, std::as_bytes(std::span(&r, 1)));
  }
  const int feature = board_ ? feature_begun(board_->plan, board_->starts(), {at.x, at.y}) : -1;
  if (feature < 0) return;
  const BoardPlan::Feature& f = board_->plan.features[static_cast<std::size_t>(feature)];
  f.bead ? fire(Trigger::Kind::NthBead, ++job_beads_, {}, when) : fire(Trigger::Kind::NthDot, ++job_dots_, {}, when);
  fire(Trigger::Kind::FeatureId, 0, f.id, when);
}

void World::closed(Vec3 at, Time when, std::uint64_t cycle) {
  if (!open_) return;
  open_->closed = when;
  open_->closed_cycle = cycle;
  open_->path.push_back(at);
  open_->since.push_back(static_cast<std::uint32_t>(cycle - open_->opened_cycle));
  if (log_) {
    const ShotRecord r{when.count(), cycle, at.x, at.y, at.z};
    log_->append(WorldLog::Kind::ShotClosed, std::as_bytes(std::span(&r, 1)));
  }
  open_->since.shrink_to_fit();
  open_->path.shrink_to_fit();  // thousands of dots keep a few points each
  shots_.push_back(std::move(open_));
  open_.reset();
}

// --- Solids, probe, camera ---

void World::place_solids() {
  std::vector<Solid> solids = solids_of(machine_.scene, board_.get());
  for (const config::Body& b : obstacles_) solids.push_back({b.name, b.shape, b.centre, b.rotation_rad, {}});
  watch_.set_solids(std::move(solids));
  contact_known_ = false;
}

void World::run_collisions(const AxisVec& from, const AxisVec& to, double dt_s, std::uint64_t cycle) {
  for (const Contact& c : watch_.step(from, to, dt_s)) {
    const Time now = last_ + time_of(dt_s);
    collisions_.push_back({std::string(c.moving), std::string(c.standing), c.at, cycle, seconds(now - job_began_)});
    keep_collision(collisions_.back());
  }
}

double World::probe_contact(const AxisVec& q) {
  if (!head_.probe.exists) return kNoContact;
  const Vec3 tip = head_.in_machine(head_.probe, q);
  const double reach = tip.z - q[machine_.probe.axis.value];  // changes only with the lift
  const Vec3 key{tip.x, tip.y, reach};
  if (contact_known_ && key == contact_key_) return contact_;
  double top = kNoContact;
  for (const std::uint32_t i : watch_.solids_at({tip.x, tip.y}))
    if (const auto there = heights_at(watch_.solids()[i], {tip.x, tip.y}); there && there->low <= tip.z)
      top = std::max(top, there->high);
  contact_key_ = key;
  contact_known_ = true;
  contact_ = top <= kNoContact ? kNoContact : top - reach;
  return contact_;
}

void World::run_camera(const Moment& moment, double dt_s, Time exposed_at) {
  if (!head_.camera.exists) return;
  const Vec3 focus = head_.in_machine(head_.camera, moment.axes),
             earlier = head_.in_machine(head_.camera, before_.axes);
  if (board_) {
    const Vec3 at = board_->to_board(focus);
    if (const int i = nearest_mark(board_->plan, {at.x, at.y}); i >= 0)
      fire(Trigger::Kind::MarkExposed, 0, board_->plan.marks[static_cast<std::size_t>(i)].name, exposed_at);
  }
  const Vec2 speed = Vec2{focus.x - earlier.x, focus.y - earlier.y} * (1 / dt_s);
  camera_.expose(focus, speed, (moment.outputs & bit(Output::CameraLight)) != 0, board_);
}

std::uint32_t World::inputs(std::uint32_t outputs, Time now) const {
  std::uint32_t out = steady_inputs_;
  const auto clamp_output = machine_.outputs[static_cast<std::size_t>(Output::Clamp)];
  if (clamp_output && (outputs & bit(Output::Clamp)) == 0) out &= ~bit(Input::ClampClosed);
  if (emergency_) out &= ~bit(Input::SafetyOk);
  for (std::size_t i = 0; i < config::kChannelBits; ++i)
    if (now < pressed_until_[i])
      out = config::normally_closed(static_cast<Input>(i)) ? out & ~(1u << i) : out | 1u << i;
  return (out & ~broken_wires_) | (broken_wires_ & inverted_inputs_);
}

// --- The board under the clamp ---

void World::run_clamp(const Moment& moment, Time now) {
  if (!moment.clamp_commanded) return;  // a clamp that nobody commands stays as it is
  if ((moment.outputs & bit(Output::Clamp)) == 0) {
    if (!clamped_ || opened_clamp_) return;
    opened_clamp_ = now;
    keep_clamp(WorldLog::Kind::ClampOpened);
    return;
  }
  if (opened_clamp_ && now - *opened_clamp_ >= kChange) exchange_board();
  if (!clamped_ || opened_clamp_) keep_clamp(WorldLog::Kind::ClampClosed);
  clamped_ = true;
  opened_clamp_.reset();
}

void World::exchange_board() {
  if (board_) put_board(whole_, board_->frame_origin());
  clamped_ = false;
  opened_clamp_.reset();
}

void World::put_board(BoardPlan plan, Vec3 frame_origin) {
  whole_ = plan;
  const BoardPlacement placement = draw_placement(machine_.sim, seed_, boards_++, placement_text_, plan.in_fixture);
  board_ = std::make_shared<const BoardTruth>(std::move(plan), frame_origin, placement);
  place_solids();
  keep_board();
}

// --- What other threads ask ---

Result<void> World::load_board(BoardPlan plan) {
  const config::WorkFrame* frame = config::find_frame(machine_, plan.board.frame);
  if (frame == nullptr)
    return fail(Fault::UnknownReference, fmt::format("the machine has no work frame '{}'", plan.board.frame));
  const std::scoped_lock lock(mutex_);
  std::vector<ScriptEntry> waiting;
  for (const Waiting& w : script_) waiting.push_back(w.entry);
  if (auto fits = script_fits(waiting, plan); !fits) return fits;
  if (log_)
    if (auto room = log_->make_room(); !room) return room;
  put_board(std::move(plan), frame->origin);
  clamped_ = false;
  opened_clamp_.reset();
  return {};
}

void World::begin_job() {
  const std::scoped_lock lock(mutex_);
  if (opened_clamp_ && last_ - *opened_clamp_ >= kChange) exchange_board();
  job_shot_ = shots_.size() + (open_ ? 1 : 0);  // what still comes out is of the job before
  job_collision_ = collisions_.size();
  job_dots_ = job_beads_ = job_touches_ = 0;
  job_began_ = last_;
  camera_.begin_job();
  if (log_) log_->append(WorldLog::Kind::JobBegin, {});
  fire(Trigger::Kind::JobStart, 0, {}, last_);
}

std::vector<Deposit> World::deposits() {
  std::vector<std::shared_ptr<const Shot>> shots;
  std::shared_ptr<const BoardTruth> board;
  {
    const std::scoped_lock lock(mutex_);
    const std::size_t first = std::min(job_shot_, shots_.size());
    shots.assign(shots_.begin() + static_cast<std::ptrdiff_t>(first), shots_.end());
    if (open_ && first == job_shot_) shots.push_back(std::make_shared<const Shot>(*open_));
    board = board_;
  }
  if (!board) return judge({}, shots);
  std::optional<Vec2> purge_at;
  if (const auto& purge = board->plan.purge) {
    const config::WorkFrame* frame = config::find_frame(machine_, purge->frame);
    purge_at = flat(frame != nullptr ? board->to_board(frame->origin + purge->at) : purge->at);
  }
  return judge(board->plan, shots, purge_at, &machine_);
}

std::vector<Collision> World::collisions() {
  const std::scoped_lock lock(mutex_);
  return {collisions_.begin() + static_cast<std::ptrdiff_t>(job_collision_), collisions_.end()};
}

std::string World::placement() {
  const std::scoped_lock lock(mutex_);
  return board_ ? to_text(board_->placement()) : std::string();
}

}  // namespace gantry::sim
