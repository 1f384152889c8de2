// What stands there, and what moves: the head's bodies against the machine's, the board and its parts.
//   Scene scene(machine);
//   scene.add({"part U7", {config::Shape::Kind::Box, {8, 8, 3}}, {120, 80, 21.5}});   // machine coordinates
// A head body stands at its own position plus (X, Y, Z), lower by U when it rides on the lift. C turns the needle about
// its own axis, and with it the bodies that are said to turn. Bodies of the head are not checked against each other:
// how U and C move them among themselves is the machine's design.
#pragma once
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "config/machine.hpp"
#include "core/axis_vec.hpp"
#include "core/fnv.hpp"
#include "motion/plan/solid.hpp"
#include "motion/plan/tree.hpp"
#include "motion/plan/wide_tree.hpp"

namespace gantry::motion {

struct SceneBody {
  std::string name;
  Solid solid;
  bool on_lift = false;
  Vec3 half_box;          ///< half edges of its axis-aligned box, where C is 0
  double turning_mm = 0;  ///< how far its farthest point is from the line about which it turns; 0: it does not turn
  bool keep_out = false;  ///< of what stands: a zone, which is no matter, so that the head may be in it when it begins
};

/// Where a board lies: its own coordinates are turned, shifted to `origin`, and count Z from its top face.
struct BoardFrame {
  Vec3 origin;  ///< of the board's corner on its top face
  double rotation_rad = 0;
  Vec2 slope;  ///< of the top face over the board's coordinates
  [[nodiscard]] Vec3 from_machine(Vec3 p) const;
};

class Scene {
 public:
  explicit Scene(const config::Machine& machine);
  /// Adds bodies that stand, in machine coordinates. Each call makes the tree anew: many bodies are added at once.
  void add(std::span<const config::Body> bodies);
  void add(const config::Body& body) { add({&body, 1}); }
  /// From now on points are told in the coordinates of a board that lies there; in those of the machine before.
  void tell_in(const BoardFrame& board) { board_ = board; }

  [[nodiscard]] const std::vector<SceneBody>& head() const { return head_; }
  [[nodiscard]] const std::vector<SceneBody>& standing() const { return standing_; }
  /// Over standing().
  [[nodiscard]] const Tree& tree() const { return tree_; }
  [[nodiscard]] const WideTree& wide_tree() const { return wide_tree_; }
  /// The second check has looked at the tree (verify.hpp): its boxes hold what is in them, and no body is missing.
  [[nodiscard]] bool tree_holds() const { return tree_holds_; }
  /// By how much the axes carry a body of the head, whether it turns or not.
  [[nodiscard]] Vec3 carried(const SceneBody& body, const AxisVec& q) const {
    return {q[x_], q[y_], q[z_] - (body.on_lift && has_lift_ ? q[u_] : 0.0)};
  }

  /// A body of the head where the axes carry it, turned as C has it.
  [[nodiscard]] Solid placed(const SceneBody& body, const AxisVec& q) const {
    return moved(body.turning_mm > 0 ? turned(body.solid, turn_axis_, q[c_]) : body.solid, carried(body, q));
  }
  /// By how much a motion of the axes turns a body of the head, rad.
  [[nodiscard]] double turn_of(const SceneBody& body, const AxisVec& from, const AxisVec& to) const {
    return body.turning_mm > 0 ? to[c_] - from[c_] : 0.0;
  }
  /// Some body of the head turns, so that C matters.
  [[nodiscard]] bool turns() const { return turns_; }
  [[nodiscard]] std::size_t c() const { return c_; }
  /// In the head's frame.
  [[nodiscard]] Vec2 turn_axis() const { return turn_axis_; }

  struct Axis {
    std::string name;
    double p_min = 0, p_max = 0;
  };
  [[nodiscard]] const std::vector<Axis>& axes() const { return axes_; }
  [[nodiscard]] std::size_t x() const { return x_; }
  [[nodiscard]] std::size_t y() const { return y_; }
  [[nodiscard]] std::size_t z() const { return z_; }
  [[nodiscard]] bool has_lift() const { return has_lift_; }
  [[nodiscard]] std::size_t u() const { return u_; }

  /// A point of the machine frame for people, in the coordinates of the board, the machine's in brackets:
  /// "(12.00, 8.00, 21.50) mm [machine 192.00, 158.00, -88.50]"; "(192.00, 158.00, -88.50) mm" where no board is known.
  [[nodiscard]] std::string told(Vec3 machine) const;
  [[nodiscard]] const std::optional<BoardFrame>& board() const { return board_; }

  /// Changes when any body changes (FNV-1a over names and numbers); stands in certificates.
  [[nodiscard]] std::uint64_t hash() const { return hash_.value(); }
  /// The same whatever the bodies are called and in which order they were added; seeds what chance decides.
  [[nodiscard]] std::uint64_t hash_of_geometry() const { return geometry_; }

 private:
  std::vector<SceneBody> head_, standing_;
  Tree tree_;
  WideTree wide_tree_;
  bool tree_holds_ = true;
  std::vector<Axis> axes_;
  std::size_t x_ = 0, y_ = 0, z_ = 0, u_ = 0, c_ = 0;
  bool has_lift_ = false, turns_ = false;
  Vec2 turn_axis_;
  std::optional<BoardFrame> board_;
  Fnv1a hash_;
  std::uint64_t geometry_ = 0;  ///< sum over all bodies
};

}  // namespace gantry::motion
