// An owner parks the head: what must be so before anything moves, and the one block that moves.
#include "app/job/jog.hpp"
#include "app/job/park.hpp"
#include "app/run/owner_parts.hpp"

namespace gantry::run {

Result<void> Owner::park(Begin begin) {
  const Turn turn(*parts_, Undertaking::Park, begin);
  if (!turn.taken()) return turn.refused();
  return parts_->park();
}

Result<void> Owner::Parts::park() {
  if (in_setup()) return fail(Fault::SetupMode, std::string(info(Fault::SetupMode).text));
  const cycle::Snapshot& now = control().latest();
  if (auto r = not_latched(); !r) return r;
  if (auto r = job::know_position(machine, now.referenced, job::park_axes(machine)); !r) return r;
  if (auto r = torque(); !r) return r;
  const auto planned = job::plan_park(machine, *around, now.target);
  if (!planned) return tl::unexpected(planned.error());
  const auto played = control().play(*planned, cycle::Purpose::Park);
  return with_stations(played ? Result<void>{} : Result<void>(tl::unexpected(played.error())));
}

}  // namespace gantry::run
