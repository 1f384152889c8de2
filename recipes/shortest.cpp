#include "recipes/shortest.hpp"

#include <algorithm>
#include <deque>
#include <limits>
#include <random>
#include <utility>

#include "recipes/near_points.hpp"

namespace gantry::recipes {
namespace {

using Index = std::uint32_t;
constexpr Index kNobody = std::numeric_limits<Index>::max();
constexpr std::size_t kNeighbours = 8;
constexpr double kGain_mm = 1e-9;               // less is rounding
constexpr std::uint64_t kMostWork = 300000000;  // looks at features, over the whole search
constexpr std::size_t kKicksEach = 60, kMostKicks = 15000;
constexpr std::uint64_t kMovesOfAKick = 3;
constexpr Index kKickReach = 30;    // features in each of two stretches that a kick swaps
constexpr Index kMendReach = 1000;  // features that a move may carry while a kick is mended
constexpr Index kTurnReach = 1000;  // features that are turned round where that changes what is between them
constexpr std::uint64_t kSeed = 20;

/// Always the nearest of those that may come next.
std::vector<Index> nearest_first(std::span<const Ends> ends, const Precedence& before, Index first) {
  const auto count = static_cast<Index>(ends.size());
  std::vector<Vec3> from;
  for (const Ends& each : ends) from.push_back(each.from);
  NearPoints open(std::move(from));
  MayCome may(before);
  for (Index f = 0; f < count; ++f)
    if (!may.is_free(f)) open.take_out(f);
  std::vector<Index> order, freed, near{first};
  while (!near.empty()) {
    const Index f = near.front();
    order.push_back(f);
    open.take_out(f);
    may.came(f, freed);
    for (const Index later : freed) open.put_in(later);
    open.nearest(ends[f].to, 1, near);
  }
  return order;
}

/// Of each feature those that are near: behind it, by where it ends and they begin; before it, by where they end and it
/// begins.
struct Neighbours {
  std::vector<std::vector<Index>> behind, before;
  explicit Neighbours(std::span<const Ends> ends) : behind(ends.size()), before(ends.size()) {
    std::vector<Vec3> from, to;
    for (const Ends& each : ends) from.push_back(each.from), to.push_back(each.to);
    const NearPoints begin(std::move(from)), end(std::move(to));
    for (Index f = 0; f < ends.size(); ++f) {
      begin.nearest(ends[f].to, kNeighbours + 1, behind[f]);
      end.nearest(ends[f].from, kNeighbours + 1, before[f]);
      std::erase(behind[f], f), std::erase(before[f], f);
    }
  }
};

/// An order that is bettered by moves, each of which can be taken back.
class Search {
 public:
  Search(std::span<const Ends> ends, const Precedence& before, const Neighbours& near, std::uint64_t& work)
      : ends_(ends),
        before_(before),
        near_(near),
        work_(work),
        free_(before.none()),
        directed_(std::any_of(ends.begin(), ends.end(), [](const Ends& e) { return e.from != e.to; })) {}

  void begin(std::vector<Index> order) {
    order_ = std::move(order);
    place_.resize(order_.size()), waiting_.assign(order_.size(), false);
    seen_.assign(before_.rows.size(), 0), asked_.assign(before_.rows.size(), 0);
    renumber(0, size());
  }
  /// Until no move betters it.
  void descend() {
    for (const Index f : order_) look_again(f);
    mend(size());
  }
  /// Up to three times two short neighbouring stretches are swapped somewhere, or one is turned round, and what that
  /// has spoilt is bettered; kept when it helps.
  void kick(std::mt19937_64& random) {
    done_.clear();
    double gained = 0;
    for (auto left = random() % kMovesOfAKick + 1; left > 0; --left) gained += disturb(random);
    if (!done_.empty() && gained + mend(kMendReach) < -kGain_mm) take_back();
  }
  /// Backwards, where that is as short, and this feature comes earlier then.
  void prefer(Index feature) {
    const Index last = size() - 1;
    if (place_[feature] > last / 2 && turn_gain(0, last) >= -kGain_mm && may_turn(0, last)) turn(0, last);
  }
  [[nodiscard]] const std::vector<Index>& order() const { return order_; }
  [[nodiscard]] double length_mm() const {
    double mm = 0;
    for (Index i = 1; i < size(); ++i) mm += travel_mm(order_[i - 1], order_[i]);
    return mm;
  }

 private:
  struct Move {
    bool swapped = false;  ///< false: turned round
    Index first = 0, middle = 0, last = 0;
  };

  [[nodiscard]] Index size() const { return static_cast<Index>(order_.size()); }
  [[nodiscard]] Index at(Index place) const { return place < size() ? order_[place] : kNobody; }
  /// From where `a` ends to where `b` begins. No travel to the first feature counts, and none from the last.
  [[nodiscard]] double travel_mm(Index a, Index b) const {
    return a == kNobody || b == kNobody ? 0 : norm(ends_[b].from - ends_[a].to);
  }
  [[nodiscard]] Index before(Index place) const { return place == 0 ? kNobody : order_[place - 1]; }

  void look_again(Index feature) {
    if (feature == kNobody || waiting_[feature]) return;
    waiting_[feature] = true;
    queue_.push_back(feature);
  }
  void renumber(Index first, Index end) {
    for (Index i = first; i < end; ++i) place_[order_[i]] = i;
    work_ += end - first;
  }

  // ---- may it be done? ----

  /// Something in the second stretch must come behind something in the first.
  [[nodiscard]] bool waits(Index first, Index end, Index then, Index then_end) {
    work_ += (end - first) + (then_end - then);
    ++stamp_;
    for (Index i = first; i < end; ++i) seen_[before_.row[order_[i]]] = stamp_;
    for (Index i = then; i < then_end; ++i) {
      const Index f = order_[i], row = before_.row[f];
      if (asked_[row] != stamp_ && waits_for_seen(before_.rows[row])) return true;
      asked_[row] = stamp_;
      work_ += before_.features[f].size();
      for (const Index earlier : before_.features[f])
        if (place_[earlier] >= first && place_[earlier] < end) return true;
    }
    return false;
  }
  bool waits_for_seen(std::span<const Index> rows) {
    work_ += rows.size();
    return std::any_of(rows.begin(), rows.end(), [&](Index row) { return seen_[row] == stamp_; });
  }
  bool may_turn(Index first, Index last) { return free_ || !waits(first, last + 1, first, last + 1); }
  bool may_swap(Index first, Index middle, Index last) { return free_ || !waits(first, middle, middle, last + 1); }

  /// Gives what it gains, mostly less than 0.
  double disturb(std::mt19937_64& random) {
    const auto up_to = [&](Index most) { return static_cast<Index>(random() % most) + 1; };
    const Index one = up_to(std::min(kKickReach, size() - 1)), other = up_to(std::min(kKickReach, size() - one));
    const Index first = up_to(size() - one - other + 1) - 1, middle = first + one, last = middle + other - 1;
    const bool swaps = random() % 2 == 0;
    if (swaps ? !may_swap(first, middle, last) : !may_turn(first, last)) return 0;
    const double gain = swaps ? swap_gain(first, middle, last) : turn_gain(first, last);
    swaps ? swap(first, middle, last) : turn(first, last);
    return gain;
  }

  // ---- what it gains ----

  /// What is between the features of a stretch when it is gone through backwards, less what is now.
  [[nodiscard]] double turned(Index first, Index last) {
    if (!directed_) return 0;
    work_ += last - first;
    double more = 0;
    for (Index i = first; i < last; ++i)
      more += travel_mm(order_[i + 1], order_[i]) - travel_mm(order_[i], order_[i + 1]);
    return more;
  }
  [[nodiscard]] double swap_gain(Index first, Index middle, Index last) const {
    const Index a = before(first), b = order_[first], c = order_[middle - 1], d = order_[middle], e = order_[last],
                f = at(last + 1);
    return travel_mm(a, b) + travel_mm(c, d) + travel_mm(e, f) - travel_mm(a, d) - travel_mm(e, b) - travel_mm(c, f);
  }

  [[nodiscard]] double turn_gain(Index first, Index last) {
    const Index a = before(first), b = order_[first], c = order_[last], d = at(last + 1);
    return travel_mm(a, b) + travel_mm(c, d) - travel_mm(a, c) - travel_mm(b, d) - turned(first, last);
  }

  // ---- doing it ----

  void turn(Index first, Index last) {
    for (const Index f : {before(first), order_[first], order_[last], at(last + 1)}) look_again(f);
    done_.push_back({false, first, 0, last});
    std::reverse(order_.begin() + first, order_.begin() + last + 1);
    renumber(first, last + 1);
  }
  void swap(Index first, Index middle, Index last) {
    for (const Index f : {before(first), order_[first], order_[middle - 1], order_[middle], order_[last], at(last + 1)})
      look_again(f);
    done_.push_back({true, first, middle, last});
    std::rotate(order_.begin() + first, order_.begin() + middle, order_.begin() + last + 1);
    renumber(first, last + 1);
  }
  void take_back() {
    for (auto move = done_.rbegin(); move != done_.rend(); ++move) {
      const auto begin = order_.begin() + move->first, end = order_.begin() + move->last + 1;
      if (move->swapped)
        std::rotate(begin, end - (move->middle - move->first), end);
      else
        std::reverse(begin, end);
      renumber(move->first, move->last + 1);
    }
  }

  /// Betters what waits to be looked at, with moves of at most so many features; gives what that has gained, mm.
  double mend(Index reach) {
    reach_ = reach;
    double gained = 0;
    while (!queue_.empty()) {
      const Index f = queue_.front();
      queue_.pop_front();
      waiting_[f] = false;
      while (work_ < kMostWork) {
        const double gain = better(f);
        if (gain <= 0) break;
        gained += gain;
      }
    }
    return gained;
  }

  bool try_turn(Index first, Index last, double gain) {
    if (gain <= kGain_mm || last - first >= (directed_ ? std::min(reach_, kTurnReach) : reach_)) return false;
    gain_ = gain - turned(first, last);
    if (gain_ <= kGain_mm || !may_turn(first, last)) return false;
    turn(first, last);
    return true;
  }
  bool try_swap(Index first, Index middle, Index last) {
    ++work_;
    if (last - first >= reach_) return false;
    gain_ = swap_gain(first, middle, last);
    if (gain_ <= kGain_mm || !may_swap(first, middle, last)) return false;
    swap(first, middle, last);
    return true;
  }

  /// Does the first move about a feature that gains; gives the gain, or 0.
  double better(Index f) { return leave_shorter(f) || arrive_shorter(f) || begin_elsewhere(f) ? gain_ : 0; }

  /// Another one comes behind it, which is nearer.
  bool leave_shorter(Index a) {
    const Index next = at(place_[a] + 1);
    const double now = travel_mm(a, next);
    for (const Index b : near_.behind[a]) {
      const double then = travel_mm(a, b);
      if (then >= now - kGain_mm) return false;
      const Index i = place_[a], k = place_[b];
      ++work_;
      if (k > i) {
        const Index behind = at(k + 1);
        if (try_turn(i + 1, k, now + travel_mm(b, behind) - then - travel_mm(next, behind))) return true;
        if (try_swap(i + 1, k, size() - 1)) return true;
        for (const Index c : near_.before[next])
          if (place_[c] >= k && try_swap(i + 1, k, place_[c])) return true;
      } else {
        for (const Index c : near_.before[next])
          if (place_[c] >= k && place_[c] < i && try_swap(k, place_[c] + 1, i)) return true;
      }
    }
    return false;
  }

  /// Another one comes before it, which is nearer.
  bool arrive_shorter(Index b) {
    const Index k = place_[b];
    const double now = travel_mm(before(k), b);
    for (const Index a : near_.before[b]) {
      const double then = travel_mm(a, b);
      if (then >= now - kGain_mm) return false;
      const Index i = place_[a];
      ++work_;
      if (i < k) {
        const Index ahead = before(i);
        if (try_turn(i, k - 1, now + travel_mm(ahead, a) - then - travel_mm(ahead, before(k)))) return true;
      }
    }
    return false;
  }

  /// It is the first, and something else could be.
  bool begin_elsewhere(Index f) {
    if (place_[f] != 0) return false;
    for (const Index c : near_.before[f]) {
      const Index last = place_[c], behind = at(last + 1);
      if (behind == kNobody) {
        for (Index middle = 1; middle <= last; ++middle)
          if (try_swap(0, middle, last)) return true;
        continue;
      }
      for (const Index e : near_.before[behind])
        if (place_[e] < last && try_swap(0, place_[e] + 1, last)) return true;
    }
    return false;
  }

  std::span<const Ends> ends_;
  const Precedence& before_;
  const Neighbours& near_;
  std::uint64_t& work_;
  bool free_;
  bool directed_;  ///< a feature begins elsewhere than it ends, so that travel has another length backwards
  std::vector<Index> order_, place_;
  std::vector<bool> waiting_;
  std::deque<Index> queue_;
  std::vector<Move> done_;
  std::vector<std::uint32_t> seen_, asked_;  ///< of each row: the stamp of the question in which it was met, or asked
  std::uint32_t stamp_ = 0;
  Index reach_ = 0;
  double gain_ = 0;  ///< of the last move
};

}  // namespace

std::vector<std::size_t> shortest_order(std::span<const Ends> ends, const Precedence& before) {
  const std::vector<std::size_t> in_file = in_rows(before);
  if (in_file.size() < 2) return in_file;
  const Neighbours near(ends);
  std::uint64_t work = 0;
  Search from_file(ends, before, near, work), from_nearest(ends, before, near, work);
  from_file.begin({in_file.begin(), in_file.end()});
  const double file_mm = from_file.length_mm();
  from_file.descend();
  from_nearest.begin(nearest_first(ends, before, static_cast<Index>(in_file.front())));
  from_nearest.descend();
  Search& best = from_nearest.length_mm() < from_file.length_mm() - kGain_mm ? from_nearest : from_file;
  std::mt19937_64 random(kSeed);
  const std::size_t kicks = std::min(kMostKicks, kKicksEach * in_file.size());
  for (std::size_t i = 0; i < kicks && work < kMostWork; ++i) best.kick(random);
  best.prefer(static_cast<Index>(in_file.front()));
  if (best.length_mm() > file_mm - kGain_mm) return in_file;
  return {best.order().begin(), best.order().end()};
}

}  // namespace gantry::recipes
