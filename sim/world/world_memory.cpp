// World: what it remembers from one life to the next.
#include <cstring>
#include <fmt/format.h>
#include <limits>
#include <nlohmann/json.hpp>

#include "core/log.hpp"
#include "sim/world/world.hpp"
#include "sim/world/world_json.hpp"

namespace gantry::sim {

namespace {

/// Longer ago than hands need to change a board.
constexpr Time kInAnotherLife{std::numeric_limits<Time::rep>::min() / 2};

std::string_view text_of(std::span<const std::byte> bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

std::optional<ShotRecord> shot_of(std::span<const std::byte> bytes) {
  ShotRecord r;
  if (bytes.size() != sizeof r) return std::nullopt;
  std::memcpy(&r, bytes.data(), sizeof r);
  return r;
}

}  // namespace

void World::keep_board() {
  if (!log_) return;
  nlohmann::json j{{"plan", to_json(board_->plan)},
                   {"placement", to_json(board_->placement())},
                   {"boards", boards_},
                   {"stains", nlohmann::json::array()}};
  for (const Stain& s : board_->stains) j["stains"].push_back({s.at.x, s.at.y, s.diameter, s.grey});
  const std::string text = j.dump();
  log_->append(WorldLog::Kind::Board, std::as_bytes(std::span(text)));
}

void World::keep_clamp(WorldLog::Kind what) {
  if (log_) log_->append(what, {});
}

void World::keep_motors(std::span<const double> values) {
  if (log_) log_->append(WorldLog::Kind::Motors, std::as_bytes(values));
}

void World::keep_collision(const Collision& collision) {
  if (!log_) return;
  const std::string text = to_json(collision).dump();
  log_->append(WorldLog::Kind::Collision, std::as_bytes(std::span(text)));
}

void World::recall_board(std::string_view text) {
  const auto forget = [](std::string_view why) { log::warn("the board of the last life is not remembered: {}", why); };
  const auto j = parse_json(text);
  if (!j || !j->is_object()) return forget("its record is no JSON");
  const auto plan = plan_from_json(j->value("plan", nlohmann::json()));
  const auto placement = placement_from_json(j->value("placement", nlohmann::json()));
  if (!plan || !placement) return forget((plan ? placement.error() : plan.error()).message);
  const config::WorkFrame* frame = config::find_frame(machine_, plan->board.frame);
  if (frame == nullptr) return forget(fmt::format("the machine has no frame '{}'", plan->board.frame));
  auto board = std::make_shared<BoardTruth>(*plan, frame->origin, *placement);
  for (const auto& s : j->value("stains", nlohmann::json::array())) board->stains.push_back({{s[0], s[1]}, s[2], s[3]});
  whole_ = board->plan;
  board_ = std::move(board);
  boards_ = j->value("boards", std::uint64_t{1});
}

void World::remember(std::unique_ptr<WorldLog> log) {
  const std::scoped_lock lock(mutex_);
  for (const WorldLog::Record& r : log->records()) {
    const auto point = shot_of(r.payload);
    switch (r.kind) {
      case WorldLog::Kind::Board:
        recall_board(text_of(r.payload));
        opened_clamp_.reset();
        break;
      case WorldLog::Kind::JobBegin:
        job_shot_ = shots_.size() + (open_ ? 1 : 0);
        job_collision_ = collisions_.size();
        break;
      case WorldLog::Kind::ShotOpened:
        if (!point) break;
        if (open_) shots_.push_back(std::move(open_));
        open_ = std::make_shared<Shot>();
        open_->opened = Time(point->at_ns);
        open_->opened_cycle = point->cycle;
        open_->path.push_back({point->x, point->y, point->z});
        open_->since.push_back(0);
        ++valve_shots_;
        break;
      case WorldLog::Kind::ShotPoint:
      case WorldLog::Kind::ShotClosed:
        if (!point || !open_) break;
        open_->path.push_back({point->x, point->y, point->z});
        open_->since.push_back(static_cast<std::uint32_t>(point->cycle - open_->opened_cycle));
        open_->closed_cycle = point->cycle;
        if (r.kind == WorldLog::Kind::ShotPoint) break;
        open_->closed = Time(point->at_ns);
        shots_.push_back(std::move(open_));
        open_.reset();
        break;
      case WorldLog::Kind::Motors: {
        std::vector<double> values(r.payload.size() / sizeof(double));
        std::memcpy(values.data(), r.payload.data(), values.size() * sizeof(double));
        remembered_motors_ = std::move(values);
        break;
      }
      case WorldLog::Kind::ClampOpened: opened_clamp_ = kInAnotherLife; break;
      case WorldLog::Kind::ClampClosed: opened_clamp_.reset(); break;
      case WorldLog::Kind::Collision:
        if (const auto j = parse_json(text_of(r.payload)))
          if (const auto c = collision_from_json(*j)) collisions_.push_back(*c);
        break;
    }
  }
  // The valve closed when the world went dark; a shot that was open then ends where it was last seen.
  if (open_) shots_.push_back(std::move(open_));
  open_.reset();
  log_ = std::move(log);
  place_solids();
}

bool World::holds_board(const BoardPlan& plan) {
  const auto held = [&] {
    const std::scoped_lock lock(mutex_);
    return board_;
  }();
  if (held == nullptr) return false;
  auto ours = to_json(held->plan), theirs = to_json(plan);
  ours.erase("marks"), theirs.erase("marks");  // a script may have taken one away
  return ours == theirs;
}

}  // namespace gantry::sim
