#include "motion/plan/cells.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace gantry::motion {
namespace {

using State = CellTree::State;

Cell point(Vec3 p) { return {{p.x, p.y, p.z}, {p.x, p.y, p.z}}; }

Vec3 clamped(Vec3 p, const Cell& c) {
  return {std::clamp(p.x, c.low[0], c.high[0]), std::clamp(p.y, c.low[1], c.high[1]),
          std::clamp(p.z, c.low[2], c.high[2])};
}

Cell overlap(const Cell& a, const Cell& b) {
  Cell out;
  for (std::size_t i = 0; i < 3; ++i)
    out.low[i] = std::max(a.low[i], b.low[i]), out.high[i] = std::min(a.high[i], b.high[i]);
  return out;
}

}  // namespace

/// Cuts about an end until it lies in a free cell.
bool CellSearch::free_leaf_around(Vec3 p) {
  std::uint32_t leaf = tree_.leaf_at(p);
  for (; tree_.state(leaf) == State::Undecided; leaf = tree_.leaf_at(p), ++cuts_)
    if (!tree_.cut(leaf)) return false;
  return tree_.state(leaf) == State::Free;
}

/// What a leaf adds to the number of undecided cells on a walk; kFar: no walk leads through it.
std::uint32_t CellSearch::weight(std::uint32_t leaf) const {
  if (tree_.state(leaf) == State::Free) return 0;
  if (!tree_.stuck(leaf)) return 1;
  return past_stuck_ ? 0 : kFar;
}

/// The fewest undecided cells on a walk from `from` to each leaf, that leaf included, up to `most`; returns that to
/// `to`, where it ends. A breadth-first search, level by level.
std::uint32_t CellSearch::count(const Cell& from, const Cell& to, std::uint32_t most,
                                std::vector<std::uint32_t>& cells) const {
  cells.assign(tree_.size(), kFar);
  std::vector<bool> target(tree_.size());
  for (const std::uint32_t leaf : tree_.leaves_in(to)) target[leaf] = true;
  std::vector<std::uint32_t> open, next;
  std::uint32_t level = 0;
  const auto reach = [&](std::uint32_t leaf) {
    const std::uint32_t w = cells[leaf] == kFar ? weight(leaf) : kFar;
    if (w == kFar) return;
    cells[leaf] = level + w;
    (w == 0 ? open : next).push_back(leaf);
  };
  for (const std::uint32_t leaf : tree_.leaves_in(from)) reach(leaf);
  for (; level <= most; ++level) {
    while (!open.empty()) {
      const std::uint32_t leaf = open.back();
      open.pop_back();
      if (target[leaf]) return level;
      for (const std::uint32_t n : tree_.neighbours(leaf)) reach(n);
    }
    if (next.empty()) break;
    open.swap(next);
  }
  return kFar;
}

/// Cuts each undecided cell that lies on a walk with the fewest of them.
void CellSearch::cut_fewest(std::uint32_t fewest) {
  const auto& [from, to] = undecided_;
  for (std::uint32_t i = 0; i < from.size() && cuts_ < most_cuts_; ++i)
    if (from[i] != kFar && to[i] != kFar && from[i] + to[i] == fewest + 1 && weight(i) == 1) cuts_ += tree_.cut(i);
}

/// Does a path lead from one region to the other? Yes: one through free cells.
CellSearch::Joined CellSearch::joined(const Cell& here, const Cell& there) {
  for (past_stuck_ = false; cuts_ < most_cuts_;) {
    const std::uint32_t fewest = count(here, there, kFar - 1, undecided_[0]);
    if (fewest == kFar) {
      if (past_stuck_) return Joined::No;
      past_stuck_ = true;
      continue;
    }
    if (fewest == 0) return past_stuck_ ? Joined::Unknown : Joined::Yes;
    count(there, here, fewest, undecided_[1]);
    cut_fewest(fewest);
  }
  return Joined::Unknown;
}

/// From a pocket one comes neither from left to right nor from front to back: of two opposite sides of the space one is
/// out of reach.
bool CellSearch::pocket(const Cell& end) {
  const auto reaches = [&](std::size_t axis, bool high) {
    Cell side = tree_.space();
    (high ? side.low : side.high)[axis] = (high ? side.high : side.low)[axis];
    return joined(end, side) != Joined::No;
  };
  for (const std::size_t axis : {0U, 1U})
    if (tree_.space().low[axis] < tree_.space().high[axis] && reaches(axis, false) && reaches(axis, true)) return false;
  return true;
}

/// Volume of all free and undecided cells that a walk comes to, mm3.
double CellSearch::room(const Cell& end, const Cell& other) {
  count(end, other, kFar - 1, undecided_[0]);
  double sum = 0;
  for (std::uint32_t i = 0; i < tree_.size(); ++i) {
    if (undecided_[0][i] == kFar) continue;
    const Vec3 half = tree_.cell(i).half();
    sum += 8 * half.x * half.y * half.z;
  }
  return sum;
}

/// Of two pockets the one with less room.
ClosedIn CellSearch::closed_in(const Cell& start, const Cell& goal) {
  const bool of_start = pocket(start), of_goal = pocket(goal);
  if (!of_start && !of_goal) return ClosedIn::Neither;
  if (!of_goal || (of_start && room(start, goal) <= room(goal, start))) return ClosedIn::Start;
  return ClosedIn::Goal;
}

/// The shortest walk through free cells that enters each at the point nearest to where it entered the one before
/// (Dijkstra 1959).
std::vector<Vec3> CellSearch::path(Vec3 from, Vec3 to) const {
  struct Reached {
    std::uint32_t before = kFar;
    Vec3 entry;
    double length_mm = std::numeric_limits<double>::infinity();
    bool done = false;
  };
  using Entry = std::pair<double, std::uint32_t>;
  const auto later = [](const Entry& a, const Entry& b) { return a > b; };
  std::vector<Reached> reached(tree_.size());
  std::vector<Entry> heap;
  std::vector<bool> target(tree_.size());
  for (const std::uint32_t leaf : tree_.leaves_in(point(to))) target[leaf] = true;
  for (const std::uint32_t leaf : tree_.leaves_in(point(from)))
    if (tree_.state(leaf) == State::Free) reached[leaf] = {kFar, from, 0, false}, heap.push_back({0, leaf});
  std::uint32_t last = kFar;
  while (!heap.empty() && last == kFar) {
    std::pop_heap(heap.begin(), heap.end(), later);
    const std::uint32_t leaf = heap.back().second;
    heap.pop_back();
    if (std::exchange(reached[leaf].done, true)) continue;
    if (target[leaf]) last = leaf;
    for (const std::uint32_t n : tree_.neighbours(leaf)) {
      if (tree_.state(n) != State::Free) continue;
      const Vec3 entry = clamped(reached[leaf].entry, overlap(tree_.cell(leaf), tree_.cell(n)));
      const double length = reached[leaf].length_mm + norm(entry - reached[leaf].entry);
      if (length >= reached[n].length_mm) continue;
      reached[n] = {leaf, entry, length, false};
      heap.push_back({length, n});
      std::push_heap(heap.begin(), heap.end(), later);
    }
  }
  std::vector<Vec3> out{to};
  for (std::uint32_t i = last; i != kFar; i = reached[i].before) out.push_back(reached[i].entry);
  std::reverse(out.begin(), out.end());
  return out;
}

CellAnswer CellSearch::search(Vec3 from, Vec3 to, std::size_t most_cuts) {
  CellAnswer out;
  most_cuts_ = most_cuts;
  if (free_leaf_around(from) && free_leaf_around(to)) {
    const Joined found = joined(point(from), point(to));
    if (found == Joined::Yes) out.kind = CellAnswer::Kind::Path, out.points = path(from, to);
    if (found == Joined::No) out.kind = CellAnswer::Kind::NoPath, out.closed_in = closed_in(point(from), point(to));
  }
  out.cuts = cuts_;
  return out;
}

}  // namespace gantry::motion
