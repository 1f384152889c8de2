#include "motion/plan/sweep.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <fmt/format.h>

#include "motion/plan/gap.hpp"

namespace gantry::motion {
namespace {

constexpr double kFraction_mm = 1e-4;  // how exactly the position of a hit is found where overlap is allowed

/// Room along one direction between a swept body and a standing one; below 0 they overlap along it.
double room_along(const Solid& a, Vec3 sweep, const Solid& b, Vec3 n) {
  const double ahead = std::max(0.0, dot(n, sweep));
  return dot(n, b.centre - a.centre) - ahead - extent(a, n) - extent(b, n);
}

/// Overlap is allowed down to `margin` < 0: along Z or an upright face normal of the standing body.
std::optional<Vec3> prove_overlap(const Solid& a, Vec3 sweep, const Solid& b, double margin) {
  for (const Vec3 n : {Vec3{0, 0, 1}, Vec3{b.cos, b.sin, 0}, Vec3{-b.sin, b.cos, 0}})
    for (const double sign : {-1.0, 1.0})
      if (room_along(a, sweep, b, n * sign) > margin) return n * sign;
  return std::nullopt;
}

std::optional<Vec3> prove(const Solid& a, Vec3 sweep, const Solid& b, double margin) {
  const Gap g = gap(a, sweep, b, margin);
  if (g.lower > margin) return g.direction;
  return margin < 0 ? prove_overlap(a, sweep, b, margin) : std::nullopt;
}

}  // namespace

double Margins::of(std::size_t head, std::size_t standing) const {
  double least = clearance_mm;
  for (const PairMargin& p : pairs)
    if (p.head == head && p.standing == standing) least = std::min(least, p.clearance_mm);
  return least;
}

bool Margins::by_design(std::size_t head, std::size_t standing) const {
  return std::any_of(pairs.begin(), pairs.end(),
                     [&](const PairMargin& p) { return p.by_design && p.head == head && p.standing == standing; });
}

Result<Margins> make_margins(const Scene& scene, double clearance_mm, const std::vector<AllowedApproach>& approaches,
                             double extra_mm) {
  const auto index = [](const std::vector<SceneBody>& bodies, const std::string& name) {
    return static_cast<std::size_t>(
        std::find_if(bodies.begin(), bodies.end(), [&](const SceneBody& b) { return b.name == name; }) -
        bodies.begin());
  };
  Margins out{clearance_mm + extra_mm, {}};
  for (const AllowedApproach& t : approaches) {
    const std::size_t head = index(scene.head(), t.head), standing = index(scene.standing(), t.standing);
    if (head == scene.head().size() || standing == scene.standing().size())
      return fail(Fault::UnknownReference,
                  fmt::format("an allowed approach names '{}' and '{}', but there is no such body {}", t.head,
                              t.standing, head == scene.head().size() ? "on the head" : "in the scene"));
    out.pairs.push_back({head, standing, t.clearance_mm + extra_mm, t.by_design});
  }
  return out;
}

BodySweep::BodySweep(const Scene& scene, std::size_t head, const AxisVec& from, const AxisVec& to,
                     const BodySweep* other)
    : scene_(&scene), head_(head), half_box_(scene.head()[head].half_box) {
  const SceneBody& body = scene.head()[head];
  const Vec3 start = scene.carried(body, from);
  sweep_ = scene.carried(body, to) - start;
  if (body.turning_mm > 0) {
    start_ = moved(turned(body.solid, scene.turn_axis(), between(from, to, 0.5)[scene.c()]), start);
    const double most_rad = std::abs(scene.turn_of(body, from, to)) / 2;
    start_.disc = body.turning_mm * std::min(most_rad, 2.0);  // no two places on a circle are farther apart
    half_box_ = half_box(start_);
  } else {
    start_ = moved(body.solid, start);
  }
  if (other != nullptr && other->sweep_ == sweep_) {
    across_ = other->across_, across_parts_ = other->across_parts_;
  } else {
    const std::array<Vec3, 3> n{{{0, sweep_.z, -sweep_.y}, {-sweep_.z, 0, sweep_.x}, {sweep_.y, -sweep_.x, 0}}};
    for (std::size_t i = 0; i < 3; ++i) {
      const double length = norm(n[i]);
      if (length > 1e-9) across_[i] = n[i] * (1 / length);
      across_parts_[i] = {std::abs(across_[i].x), std::abs(across_[i].y), std::abs(across_[i].z)};
    }
  }
  look_around();
}

void BodySweep::look_around() {
  middle_ = start_.centre + sweep_ * 0.5;
  reach_ = half_box_ + Vec3{std::abs(sweep_.x), std::abs(sweep_.y), std::abs(sweep_.z)} * 0.5;
}

void BodySweep::cut(double fraction) {
  sweep_ = sweep_ * (fraction / cut_), cut_ = fraction;
  look_around();
}

bool BodySweep::far(const Box& b, double margin_mm) const noexcept {
  const Vec3 d = b.centre - middle_, half = b.half + half_box_;
  const double margin = margin_mm + kContact_mm;
  if ((std::abs(d.z) - reach_.z - b.half.z > margin) | (std::abs(d.x) - reach_.x - b.half.x > margin) |
      (std::abs(d.y) - reach_.y - b.half.y > margin))
    return true;
  bool far = false;
  for (std::size_t i = 0; i < 3; ++i) far |= std::abs(dot(across_[i], d)) - dot(across_parts_[i], half) > margin;
  return far & (margin > 0);  // a direction that is 0 leaves a room of 0
}

Vec3 BodySweep::parts(const Box& b, double margin_mm) const noexcept {
  const Vec3 d = b.centre - middle_, half = b.half + half_box_;
  const double margin = margin_mm + kContact_mm;
  if (std::abs(d.z) - reach_.z - b.half.z > margin) return {0, 0, std::copysign(1.0, d.z)};
  if (std::abs(d.x) - reach_.x - b.half.x > margin) return {std::copysign(1.0, d.x), 0, 0};
  if (std::abs(d.y) - reach_.y - b.half.y > margin) return {0, std::copysign(1.0, d.y), 0};
  // Three directions across motion and axis: with the axes, for boxes, every one that can part them.
  for (std::size_t i = 0; i < 3; ++i) {
    const double to = dot(across_[i], d);
    if (std::abs(to) - dot(across_parts_[i], half) > margin && across_[i] != Vec3{})
      return across_[i] * std::copysign(1.0, to);
  }
  return {};
}

double BodySweep::room(const Box& b) const noexcept {
  const Vec3 d = b.centre - middle_, half = b.half + half_box_;
  double most = std::max(
      {std::abs(d.x) - reach_.x - b.half.x, std::abs(d.y) - reach_.y - b.half.y, std::abs(d.z) - reach_.z - b.half.z});
  for (std::size_t i = 0; i < 3; ++i)
    if (across_[i] != Vec3{}) most = std::max(most, std::abs(dot(across_[i], d)) - dot(across_parts_[i], half));
  return most;
}

std::optional<Vec3> BodySweep::prove(std::size_t standing, double margin) const {
  const SceneBody& b = scene_->standing()[standing];
  if (const Vec3 n = parts({b.solid.centre, b.half_box}, margin); n != Vec3{}) return n;
  return motion::prove(start_, sweep_, b.solid, margin + kContact_mm);
}

Hit BodySweep::locate(std::size_t standing, double margin) const {
  const SceneBody& b = scene_->standing()[standing];
  double t = 0;
  if (margin >= 0) {
    t = first_contact(start_, sweep_, b.solid, margin + kContact_mm);
  } else if (motion::prove(start_, {}, b.solid, margin)) {  // a longer motion never frees a shorter one
    for (double hit = 1; (hit - t) * norm(sweep_) > kFraction_mm;) {
      const double middle = (t + hit) / 2;
      (motion::prove(start_, sweep_ * middle, b.solid, margin) ? t : hit) = middle;
    }
  }
  return {head_, standing, t * cut_, nearest_point(moved(start_, sweep_ * t), b.solid), margin};
}

namespace {

/// A walk over the tree for one body on a part of the motion that ends at `upto`. What is parted off goes into the
/// proof; `met(standing, margin)` is asked of what is not, and ends the walk when it says false.
template <class Met>
void walk(const Scene& scene, std::size_t head, const BodySweep& body, const Margins& margins, double upto,
          Proof* proof, const Met& met) {
  const auto& nodes = scene.tree().nodes();
  for (std::uint32_t node = 0; node < nodes.size();) {
    // An allowed approach only lowers a margin, so what keeps the full clearance need not be looked up.
    const Tree::Node& at = nodes[node];
    auto direction = std::optional(body.parts(at.box, margins.clearance_mm));
    if (*direction == Vec3{} && at.body == Tree::kInner) {
      ++node;
      continue;
    }
    if (*direction == Vec3{}) direction = body.prove(at.body, margins.clearance_mm);
    if (!direction) {
      const double margin = margins.of(head, at.body);
      if (margin < margins.clearance_mm) direction = body.prove(at.body, margin);
      if (!direction && !met(at.body, margin)) return;
    }
    if (direction && proof != nullptr) proof->push_back({static_cast<std::uint32_t>(head), node, *direction, upto});
    node = at.skip;
  }
}

/// Looks for the first hit of bodies that turn: a motion is halved until what its turn leaves open is next to nothing.
class TurningHit {
 public:
  TurningHit(const Scene& scene, const AxisVec& from, const AxisVec& to, const Margins& margins, Proof* proof)
      : scene_(scene), from_(from), to_(to), margins_(margins), proof_(proof) {}

  void look(std::size_t head, double begin, double end, std::optional<Hit>& first) const {
    if (first && first->fraction <= begin) return;
    const BodySweep body(scene_, head, on_line(from_, to_, begin), on_line(from_, to_, end));
    const std::size_t proved = proof_ != nullptr ? proof_->size() : 0;
    const double middle = (begin + end) / 2;
    bool open = false;
    walk(scene_, head, body, margins_, end, proof_, [&](std::uint32_t standing, double margin) {
      if (body.left_open_mm() > kTurn_mm) return open = true, false;
      Hit hit = body.locate(standing, margin);
      hit.fraction = begin + (end - begin) * hit.fraction;
      if (!first || hit.fraction < first->fraction) first = hit;
      return true;
    });
    if (!open) return;
    if (proof_ != nullptr) proof_->resize(proved);
    look(head, begin, middle, first);
    look(head, middle, end, first);
  }

 private:
  const Scene& scene_;
  const AxisVec &from_, &to_;
  const Margins& margins_;
  Proof* proof_;
};

bool turns(const Scene& scene, std::size_t head, const AxisVec& from, const AxisVec& to) {
  return scene.turn_of(scene.head()[head], from, to) != 0;
}

/// One body on a motion as a whole.
bool keeps_all(const Scene& scene, std::size_t head, const BodySweep& body, const Margins& margins) {
  bool clear = true;
  scene.wide_tree().visit(body.question(margins.clearance_mm), [&](std::uint32_t standing) {
    if (body.prove(standing, margins.clearance_mm)) return true;
    const double margin = margins.of(head, standing);
    return clear = margin < margins.clearance_mm && body.prove(standing, margin);
  });
  return clear;
}

/// One body that turns, whose motion is halved until it is proved or hardly anything is left open.
bool is_clear_turning(const Scene& scene, std::size_t head, const AxisVec& from, const AxisVec& to,
                      const Margins& margins) {
  const BodySweep body(scene, head, from, to);
  const bool clear = keeps_all(scene, head, body, margins);
  if (clear || body.left_open_mm() <= kTurn_mm) return clear;
  const AxisVec middle = between(from, to, 0.5);
  return is_clear_turning(scene, head, from, middle, margins) && is_clear_turning(scene, head, middle, to, margins);
}

}  // namespace

std::optional<Hit> first_hit(const Scene& scene, const AxisVec& from, const AxisVec& to, const Margins& margins,
                             Proof* proof) {
  std::optional<Hit> first;
  for (std::size_t i = 0; i < scene.head().size(); ++i) {
    if (turns(scene, i, from, to)) {
      TurningHit(scene, from, to, margins, proof).look(i, 0, 1, first);
    } else {
      BodySweep body(scene, i, from, to);
      if (first) body.cut(first->fraction);
      walk(scene, i, body, margins, 1, proof, [&](std::uint32_t standing, double margin) {
        const Hit hit = body.locate(standing, margin);
        if (!first || hit.fraction < first->fraction) first = hit;
        if (first->fraction > 0) body.cut(first->fraction);
        return first->fraction > 0;
      });
    }
    if (first && first->fraction <= 0) return first;
  }
  return first;
}

WideQuestion BodySweep::question(double margin_mm) const {
  return {middle_, reach_, half_box_, across_, margin_mm + kContact_mm, scene_->wide_tree().largest_mm()};
}

bool is_clear(const Scene& scene, const AxisVec& from, const AxisVec& to, const Margins& margins) {
  std::optional<BodySweep> body;
  bool clear = true;
  for (std::size_t i = 0; i < scene.head().size() && clear; ++i) {
    if (turns(scene, i, from, to)) {
      clear = is_clear_turning(scene, i, from, to, margins);
      continue;
    }
    body.emplace(BodySweep(scene, i, from, to, body ? &*body : nullptr));
    clear = keeps_all(scene, i, *body, margins);
  }
  return clear;
}

bool is_clear(const Scene& scene, std::size_t head, std::size_t standing, const AxisVec& from, const AxisVec& to,
              double margin_mm) {
  const BodySweep body(scene, head, from, to);
  if (body.prove(standing, margin_mm)) return true;
  if (body.left_open_mm() <= kTurn_mm) return false;
  const AxisVec middle = between(from, to, 0.5);
  return is_clear(scene, head, standing, from, middle, margin_mm) &&
         is_clear(scene, head, standing, middle, to, margin_mm);
}

}  // namespace gantry::motion
