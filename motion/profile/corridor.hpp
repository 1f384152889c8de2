// The shortest trajectory of one axis between position limits.
//   Corridor c(from, to, bounds, resolution);
//   Route r = c.shortest();                      // if (r) c.write(r, profile)
//   Route s = c.first(t);                        // shortest of those that take t or longer
// Where the shortest motion would leave the limits, the best one touches: it comes to a limit with speed 0 and an
// acceleration that leads back, and goes on from there. Between touches it is a shortest motion that stays inside by
// itself (a leg). So there is a graph: `from`, `to` and touches with accelerations on a grid are its nodes, legs its
// edges. Its shortest path (Dijkstra) has as many touches as it takes; their accelerations are refined together.
// A motion that has time to spare touches more gently, rests in between, or takes one leg more slowly.
// Numbers of tries are bounded; nothing is kept between calls.
#pragma once
#include <array>
#include <cmath>
#include <limits>

#include "motion/profile/reachable.hpp"
#include "motion/profile/scale.hpp"

namespace gantry::motion {

inline constexpr double kNever = std::numeric_limits<double>::infinity();

/// A state that a route goes through: at a limit with speed 0 and `share` of the largest acceleration that leads back,
/// or at rest between the limits, at `share` of their distance above the lower one.
struct Via {
  enum class Kind : std::uint8_t { Lower, Upper, Rest } kind = Kind::Rest;
  double share = 0;
  [[nodiscard]] bool rests() const noexcept { return kind == Kind::Rest || share == 0; }
};

struct Route {
  static constexpr std::size_t kMostVias = 5;
  double duration_s = kNever;
  rt::FixedVector<Via, kMostVias> vias;
  double spare_s = 0;  ///< rest at via `spare_at`
  std::int8_t spare_at = -1;
  std::array<double, kMostVias + 1> leg_s{};  ///< legs that take longer than they need: how long; 0: the others
  explicit operator bool() const noexcept { return duration_s < kNever; }
};

class Corridor {
 public:
  /// `used`: phases that the profile has already.
  Corridor(const State& from, const State& to, const AxisBounds& bounds, double resolution,
           std::size_t used = 0) noexcept;

  /// Whether phases before the route keep the position limits.
  [[nodiscard]] bool inside(const Profile& profile) const noexcept { return outside_by(profile) == 0; }
  /// Why there is no route: hardest braking does not keep the start inside, or else.
  [[nodiscard]] Reason reason_of_none() const noexcept;

  [[nodiscard]] Route shortest() noexcept;
  [[nodiscard]] Route first(double t) noexcept;
  /// Appends its phases. False: more than a profile holds.
  [[nodiscard]] bool write(const Route& route, Profile& profile) const noexcept;

 private:
  static constexpr int kMostNodes = 280;
  struct Node {
    Via via;
    double since = kNever;  ///< shortest known from the start to here
    double until = kNever;  ///< of the leg from here to the target
    int before = -1, touches = 1;
    bool done = false;
  };
  Node& node(int i) noexcept { return node_[static_cast<std::size_t>(i)]; }

  // What a route consists of (corridor.cpp).
  [[nodiscard]] State at(const Via& via) const noexcept;
  [[nodiscard]] double most(bool upper) const noexcept { return upper ? -b_.a_min : b_.a_max; }
  /// How far it leaves the position limits; 0: it does not.
  [[nodiscard]] double outside_by(const Profile& profile) const noexcept;
  /// The same; kNever: it leaves the speed bounds, or does not end where `target` is.
  [[nodiscard]] double excess(const Profile& profile, const State& target) const noexcept;
  [[nodiscard]] bool exists(bool upper) const noexcept { return std::isfinite(upper ? b_.p_max : b_.p_min); }
  /// Duration of the shortest motion that stays inside by itself; kNever: none does.
  double leg(const State& a, const State& b, Profile& out) const noexcept;
  [[nodiscard]] double leg(const State& a, const State& b) const noexcept;
  /// A motion of exactly t. Returns by how much it misses: the target, or leaves the limits; kNever: nothing takes t.
  double slow_leg(const State& a, const State& b, double t, Profile& out) const noexcept;
  /// The first duration >= t of a motion that stays inside; kNever: none was found.
  [[nodiscard]] double later_leg(const State& a, const State& b, double t) const noexcept;
  [[nodiscard]] double time(const Route& route) const noexcept;
  /// With the leg made longer that gives the shortest of those that take `least` or longer.
  [[nodiscard]] Route timed(Route route, double least) const noexcept;
  [[nodiscard]] bool sound(const Route& route) const noexcept;

  // The graph (corridor_graph.cpp).
  void add(const Via& via) noexcept;
  void add_grid(bool upper) noexcept;
  void add_bounces(bool forward) noexcept;
  void add_contacts() noexcept;
  int explore(double enough) noexcept;
  [[nodiscard]] Route route_to(int last) noexcept;
  /// `least` > 0: the shortest that takes so long or longer.
  void refine(Route& route, double least) const noexcept;

  // Time to spare (corridor_wait.cpp).
  void add_rests() noexcept;
  Route unbent(double& t) const noexcept;
  [[nodiscard]] Route bent(double t) const noexcept;
  [[nodiscard]] double miss(const Route& route) const noexcept;
  [[nodiscard]] Route resting(double t) noexcept;
  [[nodiscard]] Route gentler(double t) noexcept;
  [[nodiscard]] Route slower(double t) noexcept;
  [[nodiscard]] Route later(double t) noexcept;

  State from_, to_;
  AxisBounds b_;
  double resolution_;
  std::size_t used_;
  Scale scale_;
  double rest_low_ = 0, rest_high_ = 0;
  std::array<Node, kMostNodes> node_;
  int nodes_ = 0;
};

}  // namespace gantry::motion
