#include "motion/plan/cells.hpp"

#include <algorithm>
#include <cmath>

namespace gantry::motion {
namespace {

constexpr double kHalvingCosts = 0.3;   // each halving makes what is behind it look so much farther
constexpr std::size_t kFew = 12;        // pairs; above, cells are cut in the middle first
constexpr std::size_t kFirstLook = 64;  // cuts until it is first asked whether the ends are parted
constexpr double kPocket = 0.2;         // a pocket takes less than this share of the space

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

CellSearch::CellSearch(std::vector<CellPair> pairs, const Cell& space) : pairs_(std::move(pairs)) {
  Node& root = nodes_.emplace_back();
  splits_.emplace_back();
  root.cell = space;
  root.pairs.resize(pairs_.size());
  for (std::uint32_t i = 0; i < pairs_.size(); ++i) root.pairs[i] = i;
  judge(0);
}

/// Keeps only the pairs that the cell does not settle.
void CellSearch::judge(std::uint32_t index) {
  Node& node = nodes_[index];
  std::size_t kept = 0;
  for (const std::uint32_t p : node.pairs) {
    if (pairs_[p].free(node.cell)) continue;
    if (pairs_[p].blocked(node.cell)) {
      node.state = State::Blocked;
      node.pairs = {};
      return;
    }
    node.pairs[kept++] = p;
  }
  node.pairs.resize(kept);
  node.state = kept == 0 ? State::Free : State::Undecided;
}

/// Few pairs: at a face of the one that covers most. Many: near the middle of the longest edge, at a face when one is
/// there.
Cut CellSearch::choose(const Node& node, bool& possible) const {
  possible = true;
  if (node.pairs.size() > kFew) {
    std::size_t axis = 0;
    const auto length = [&](std::size_t i) { return node.cell.high[i] - node.cell.low[i]; };
    for (std::size_t i = 1; i < 3; ++i)
      if (length(i) > length(axis)) axis = i;
    const double middle = (node.cell.low[axis] + node.cell.high[axis]) / 2;
    double best = middle, nearest = length(axis) / 4;
    for (const std::uint32_t p : node.pairs)
      if (const auto at = pairs_[p].face(node.cell, axis, middle); at && std::abs(*at - middle) < nearest)
        nearest = std::abs(*at - middle), best = *at;
    if (length(axis) > 1.0) return {axis, best, false};
  }
  double most = -1;
  std::optional<Cut> best;
  for (const std::uint32_t p : node.pairs) {
    const double share = pairs_[p].share(node.cell);
    if (share <= most) continue;
    if (const auto cut = pairs_[p].cut(node.cell)) most = share, best = cut;
  }
  possible = best.has_value();
  return best.value_or(Cut{});
}

bool CellSearch::cut(std::uint32_t index) {
  bool possible = false;
  const Cut c = choose(nodes_[index], possible);
  if (!possible) {
    nodes_[index].stuck = true;
    return false;
  }
  const auto child = static_cast<std::uint32_t>(nodes_.size());
  nodes_.resize(nodes_.size() + 2), splits_.resize(nodes_.size());
  Node& node = nodes_[index];
  splits_[index] = {c.at, child, static_cast<std::uint32_t>(c.axis)};
  for (const bool upper : {false, true}) {
    Node& half = nodes_[child + upper];
    half.cell = node.cell;
    (upper ? half.cell.low : half.cell.high)[c.axis] = c.at;
    half.halvings = static_cast<std::uint16_t>(node.halvings + (c.halves ? 1 : 0));
    half.pairs = node.pairs;
  }
  node.pairs = {};
  judge(child), judge(child + 1);
  ++cuts_;
  return true;
}

std::uint32_t CellSearch::leaf_at(Vec3 p) const {
  std::uint32_t i = 0;
  while (splits_[i].child != kNone) i = splits_[i].child + (component(p, splits_[i].axis) > splits_[i].at ? 1 : 0);
  return i;
}

bool CellSearch::share_face(const Cell& a, const Cell& b) const {
  const Cell& space = nodes_.front().cell;
  int touching = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    const double width = std::min(a.high[i], b.high[i]) - std::max(a.low[i], b.low[i]);
    if (width < 0) return false;
    if (width == 0 && space.high[i] > space.low[i]) ++touching;
  }
  return touching <= 1;
}

void CellSearch::collect(std::uint32_t root, const Cell& of, std::uint32_t self,
                         std::vector<std::uint32_t>& out) const {
  const Split& split = splits_[root];
  if (split.child == kNone) {
    const Node& node = nodes_[root];
    if (root != self && node.state != State::Blocked && share_face(of, node.cell)) out.push_back(root);
    return;
  }
  if (of.low[split.axis] <= split.at) collect(split.child, of, self, out);
  if (of.high[split.axis] >= split.at) collect(split.child + 1, of, self, out);
}

void CellSearch::neighbours(std::uint32_t node, std::vector<std::uint32_t>& out) const {
  out.clear();
  collect(0, nodes_[node].cell, node, out);
}

/// Cuts about an end until it lies in a free cell.
bool CellSearch::free_leaf_around(Vec3 p, std::uint32_t& node) {
  for (node = leaf_at(p); nodes_[node].state == State::Undecided; node = leaf_at(p))
    if (nodes_[node].stuck || !cut(node)) return false;
  return nodes_[node].state == State::Free;
}

/// A cell that lies beside one that was taken.
void CellSearch::offer(std::uint32_t index, std::uint32_t from, std::size_t side) {
  Node& node = nodes_[index];
  if (node.state == State::Blocked || node.stuck || node.queued[side]) return;
  const Node& before = nodes_[from];
  node.queued[side] = true;
  node.before[side] = from;
  node.entry[side] = clamped(before.entry[side], overlap(before.cell, node.cell));
  node.way_mm[side] = before.way_mm[side] + norm(node.entry[side] - before.entry[side]);
  const double length = node.way_mm[side] + norm(ends_[1 - side] - node.entry[side]);
  const bool undecided = node.state == State::Undecided;
  near_[side].push_back({undecided ? length * (1 + kHalvingCosts * node.halvings) : length, ++order_, index});
  std::push_heap(near_[side].begin(), near_[side].end());
  if (undecided) refine(index, side);
}

/// An undecided cell that may be reachable, perhaps only through others that are undecided: coarse ones are cut first.
void CellSearch::refine(std::uint32_t index, std::size_t side) {
  Node& node = nodes_[index];
  if (node.state != State::Undecided || node.stuck || node.refined[side]) return;
  node.refined[side] = true;
  coarse_[side].push_back({static_cast<double>(node.halvings), ++order_, index});
  std::push_heap(coarse_[side].begin(), coarse_[side].end());
}

void CellSearch::take(std::uint32_t index, std::size_t side) {
  nodes_[index].taken[side] = true;
  if (nodes_[index].taken[1 - side]) met_ = index;
  std::vector<std::uint32_t> around;
  neighbours(index, around);
  for (const std::uint32_t n : around) offer(n, index, side);
}

/// The halves are offered to each search that has come to a neighbour of theirs.
void CellSearch::cut_and_offer(std::uint32_t index, std::size_t side_of, bool coarse) {
  if (!cut(index)) return;
  std::vector<std::uint32_t> around;
  for (const std::uint32_t half : {splits_[index].child, splits_[index].child + 1}) {
    if (nodes_[half].state == State::Blocked) continue;
    neighbours(half, around);
    for (const std::size_t side : {0U, 1U})
      for (const std::uint32_t n : around)
        if (nodes_[n].taken[side]) offer(half, n, side);
    if (!coarse) continue;
    refine(half, side_of);
    for (const std::uint32_t n : around) refine(n, side_of);
  }
}

/// What to look at next; kNone: there is nothing left.
std::uint32_t CellSearch::next(std::size_t side, bool coarse) {
  std::vector<Entry>& heap = (coarse ? coarse_ : near_)[side];
  while (!heap.empty()) {
    std::pop_heap(heap.begin(), heap.end());
    const std::uint32_t node = heap.back().node;
    heap.pop_back();
    if (splits_[node].child == kNone && !nodes_[node].taken[side] && !nodes_[node].stuck) return node;
  }
  return kNone;
}

CellSearch::Flood CellSearch::flood(std::uint32_t from) const {
  Flood out;
  out.seen.resize(nodes_.size());
  std::vector<std::uint32_t> open{from}, around;
  out.seen[from] = true;
  const Cell& space = nodes_.front().cell;
  while (!open.empty()) {
    const std::uint32_t index = open.back();
    open.pop_back();
    const Cell& c = nodes_[index].cell;
    out.volume += (c.high[0] - c.low[0]) * (c.high[1] - c.low[1]) * (c.high[2] - c.low[2]);
    for (const std::size_t i : {0U, 1U})
      out.at_a_side = out.at_a_side || c.low[i] <= space.low[i] || c.high[i] >= space.high[i];
    neighbours(index, around);
    for (const std::uint32_t n : around)
      if (!out.seen[n]) out.seen[n] = true, open.push_back(n);
  }
  return out;
}

bool CellSearch::parted() { return !flood(leaf_at(ends_[0])).seen[leaf_at(ends_[1])]; }

CellAnswer CellSearch::no_path() const {
  const Flood start = flood(leaf_at(ends_[0])), goal = flood(leaf_at(ends_[1]));
  const Cell& s = nodes_.front().cell;
  const double all = (s.high[0] - s.low[0]) * (s.high[1] - s.low[1]) * (s.high[2] - s.low[2]);
  const auto pocket = [&](const Flood& f) { return !f.at_a_side || f.volume < kPocket * all; };
  CellAnswer out{CellAnswer::Kind::NoPath, {}, ClosedIn::Neither};
  if (pocket(start) && (!pocket(goal) || start.volume < goal.volume))
    out.closed_in = ClosedIn::Start;
  else if (pocket(goal))
    out.closed_in = ClosedIn::Goal;
  return out;
}

std::vector<Vec3> CellSearch::way(Vec3 from, Vec3 to) const {
  std::vector<Vec3> out;
  for (std::uint32_t i = met_; i != kNone; i = nodes_[i].before[0]) out.push_back(nodes_[i].entry[0]);
  std::reverse(out.begin(), out.end());
  for (std::uint32_t i = met_; i != kNone; i = nodes_[i].before[1]) out.push_back(nodes_[i].entry[1]);
  out.front() = from, out.back() = to;
  return out;
}

CellAnswer CellSearch::search(Vec3 from, Vec3 to, std::size_t most_cuts) {
  ends_ = {from, to};
  std::array<std::uint32_t, 2> leaf{};
  for (const std::size_t side : {0U, 1U})
    if (!free_leaf_around(ends_[side], leaf[side])) return {CellAnswer::Kind::Undecided, {}, ClosedIn::Neither};
  leaf[0] = leaf_at(from);
  for (const std::size_t side : {0U, 1U}) {
    nodes_[leaf[side]].queued[side] = true;
    nodes_[leaf[side]].entry[side] = ends_[side];
    take(leaf[side], side);
  }
  std::size_t look = cuts_ + kFirstLook, empty = 0;
  for (std::size_t turn = 0; met_ == kNone && empty < 2; ++turn) {
    if (cuts_ >= look) {
      if (parted()) return no_path();
      if (cuts_ >= most_cuts) return {CellAnswer::Kind::Undecided, {}, ClosedIn::Neither};
      look = std::min(cuts_ + cuts_ / 2, most_cuts);
    }
    const std::size_t side = turn % 2;
    const bool coarse = turn % 4 >= 2;
    std::uint32_t node = next(side, coarse);
    if (node == kNone) node = next(side, !coarse);
    if (node ==
        kNone) {  // all that was reached from this end is closed by blocked cells, or by some that are too small
      if (++empty == 1) look = cuts_;
      continue;
    }
    empty = 0;
    if (nodes_[node].state == State::Free)
      take(node, side);
    else
      cut_and_offer(node, side, coarse);
  }
  if (met_ != kNone) return {CellAnswer::Kind::Path, way(from, to), ClosedIn::Neither};
  if (parted()) return no_path();
  return {CellAnswer::Kind::Undecided, {}, ClosedIn::Neither};
}

}  // namespace gantry::motion
