#include "motion/plan/cell_tree.hpp"

#include <algorithm>
#include <cmath>

namespace gantry::motion {
namespace {

constexpr std::size_t kFew = 12;         // pairs; above, cells are cut in the middle first
constexpr double kMiddleFirst_mm = 1.0;  // as long as they are longer than this

}  // namespace

CellTree::CellTree(std::vector<CellPair> pairs, const Cell& space) : pairs_(std::move(pairs)) {
  Node& root = nodes_.emplace_back();
  root.cell = space;
  root.pairs.resize(pairs_.size());
  for (std::uint32_t i = 0; i < pairs_.size(); ++i) root.pairs[i] = i;
  judge(0);
}

/// Keeps only the pairs that the cell does not settle.
void CellTree::judge(std::uint32_t index) {
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
std::optional<Cut> CellTree::choose(const Node& node) const {
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
    if (length(axis) > kMiddleFirst_mm) return Cut{axis, best};
  }
  double most = -1;
  std::optional<Cut> best;
  for (const std::uint32_t p : node.pairs) {
    const double share = pairs_[p].share(node.cell);
    if (share <= most) continue;
    if (const auto cut = pairs_[p].cut(node.cell)) most = share, best = cut;
  }
  return best;
}

bool CellTree::cut(std::uint32_t index) {
  const std::optional<Cut> c = choose(nodes_[index]);
  if (!c) {
    nodes_[index].stuck = true;
    return false;
  }
  const std::uint32_t child = size();
  nodes_.resize(nodes_.size() + 2);
  Node& node = nodes_[index];
  node.state = State::Cut;
  node.at = c->at, node.axis = static_cast<std::uint32_t>(c->axis), node.child = child;
  for (const bool upper : {false, true}) {
    Node& half = nodes_[child + upper];
    half.cell = node.cell;
    (upper ? half.cell.low : half.cell.high)[c->axis] = c->at;
    half.pairs = node.pairs;
  }
  node.pairs = {};
  judge(child), judge(child + 1);
  join_halves(index);
  return true;
}

/// The halves take the place of what was cut in its neighbours' lists.
void CellTree::join_halves(std::uint32_t parent) {
  const std::vector<std::uint32_t> around = std::move(nodes_[parent].beside);
  nodes_[parent].beside = {};
  const std::uint32_t child = nodes_[parent].child;
  for (const std::uint32_t n : around) {
    auto& list = nodes_[n].beside;
    list.erase(std::find(list.begin(), list.end(), parent));
  }
  for (const std::uint32_t half : {child, child + 1}) {
    if (nodes_[half].state == State::Blocked) continue;
    for (const std::uint32_t n : around)
      if (share_face(nodes_[half].cell, nodes_[n].cell))
        nodes_[half].beside.push_back(n), nodes_[n].beside.push_back(half);
  }
  if (nodes_[child].state == State::Blocked || nodes_[child + 1].state == State::Blocked) return;
  nodes_[child].beside.push_back(child + 1), nodes_[child + 1].beside.push_back(child);
}

/// A face, not only an edge; an axis along which the whole space is flat does not count.
bool CellTree::share_face(const Cell& a, const Cell& b) const {
  int touching = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    const double width = std::min(a.high[i], b.high[i]) - std::max(a.low[i], b.low[i]);
    if (width < 0) return false;
    if (width == 0 && space().high[i] > space().low[i]) ++touching;
  }
  return touching <= 1;
}

std::vector<Vec2> CellTree::askew() const {
  constexpr double kSame = 1e-9;
  std::vector<std::size_t> leaves(pairs_.size());
  for (const Node& node : nodes_)
    if (node.state == State::Undecided)
      for (const std::uint32_t p : node.pairs) ++leaves[p];
  struct Seen {
    Vec2 along;
    std::size_t leaves = 0;
  };
  std::vector<Seen> all, seen;
  for (std::size_t p = 0; p < pairs_.size(); ++p)
    if (leaves[p] > 0) pairs_[p].tell_askew([&](Vec2 along) { all.push_back({along, leaves[p]}); });
  std::ranges::stable_sort(all, {}, [](const Seen& s) { return s.along.y; });
  for (const Seen& s : all)
    if (!seen.empty() && s.along.y - seen.back().along.y < kSame)
      seen.back().leaves += s.leaves;
    else
      seen.push_back(s);
  std::ranges::stable_sort(seen, std::ranges::greater{}, &Seen::leaves);
  std::vector<Vec2> out;
  for (const Seen& s : seen) out.push_back(s.along);
  return out;
}

std::uint32_t CellTree::leaf_at(Vec3 p) const {
  std::uint32_t i = 0;
  while (nodes_[i].state == State::Cut) i = nodes_[i].child + (component(p, nodes_[i].axis) > nodes_[i].at ? 1 : 0);
  return i;
}

std::vector<std::uint32_t> CellTree::leaves_in(const Cell& region) const {
  std::vector<std::uint32_t> out, open{0};
  while (!open.empty()) {
    const std::uint32_t i = open.back();
    open.pop_back();
    const Node& node = nodes_[i];
    if (node.state == State::Cut) {
      if (region.high[node.axis] >= node.at) open.push_back(node.child + 1);
      if (region.low[node.axis] <= node.at) open.push_back(node.child);
    } else if (node.state != State::Blocked) {
      out.push_back(i);
    }
  }
  return out;
}

}  // namespace gantry::motion
