// From the machine's coordinates to the board's own, in which the report draws.
#pragma once
#include "app/record/job_result.hpp"

namespace gantry::record {

/// A point relative to the nominal position of the board's origin -> board frame, back through the work offset.
Vec2 to_board(const JobResult& result, Vec2 nominal);
/// A point of the machine frame -> board frame; z over the nominal top face.
Vec3 machine_to_board(const JobResult& result, Vec3 point);
/// Where the tip of the tool that works in the point's block is, machine frame.
Vec3 machine_tip_at(const JobResult& result, const PathPoint& point);
/// The same in the board frame.
Vec3 tip_at(const JobResult& result, const PathPoint& point);

}  // namespace gantry::record
