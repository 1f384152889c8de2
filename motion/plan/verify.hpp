// The second check: is a motion really free for the reasons that the first check names? Extents, dot products and a
// walk over the tree, none of the first check's code, so that "free" rests on these lines and on no search.
//   holds_all(tree, standing)               // once per scene: what a box of the tree is said to hold is in it
//   is_free(scene, from, to, proof, margins)  // per motion: each body is parted off, alone or with a box that holds it
#pragma once
#include "motion/plan/sweep.hpp"

namespace gantry::motion {

/// Is each box within the one above it, each body within its leaf's, and each body in the tree once?
bool holds_all(const Tree& tree, std::span<const SceneBody> standing);

/// Does the plane of one separation keep the body of the head apart from what it names by more than the margin?
bool holds(const Scene& scene, const AxisVec& from, const AxisVec& to, const Separation& separation, double margin_mm);

/// Do the separations, in the order of the walk, part every body of the head from every one that stands?
bool is_free(const Scene& scene, const AxisVec& from, const AxisVec& to, std::span<const Separation> proof,
             const Margins& margins);

}  // namespace gantry::motion
