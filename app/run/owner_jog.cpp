// An owner's jog: what must be so before anything moves, and the one block that moves.
#include "app/job/jog.hpp"
#include "app/run/owner_parts.hpp"

namespace gantry::run {

Result<Jogged> Owner::jog(const job::JogWords& words, Begin begin, job::JogFor whom) {
  const Turn turn(*parts_, Undertaking::Jog, begin);
  if (!turn.taken()) return tl::unexpected(turn.refused().error());
  return parts_->jog(words, whom);
}

Result<Jogged> Owner::Parts::jog(const job::JogWords& words, job::JogFor whom) {
  auto asked = job::read_jog(machine, words, whom);
  if (!asked) return tl::unexpected(asked.error());
  const bool slow = in_setup();
  if (slow) {  // reduced speed: no faster than a jog is that names none
    const auto reduced = job::read_jog(machine, {.by = words.by, .speed = ""}, whom);
    if (!reduced) return tl::unexpected(reduced.error());
    if (reduced->v_cap < asked->v_cap) {
      asked->v_cap = reduced->v_cap;
      asked->slowed = "at the reduced speed of setup";
    }
  }
  const cycle::Snapshot& now = control().latest();
  if (auto r = not_latched(); !r) return tl::unexpected(r.error());
  if (auto r = job::know_position(machine, now.referenced, asked->axes); !r) return tl::unexpected(r.error());
  if (auto r = torque(); !r) return tl::unexpected(r.error());
  Jogged jogged{.axes = asked->axes, .start = now.target, .slowed = asked->slowed};
  const auto planned = job::plan_jog(machine, *around, jogged.start, *asked);
  if (!planned) return tl::unexpected(planned.error());

  const CycleIndex begin = now.cycle;
  CycleIndex end = begin;
  const auto play = [&]() -> Result<void> {
    const auto played = control().play(*planned, slow ? cycle::Purpose::SlowJog : cycle::Purpose::Jog);
    if (!played) return tl::unexpected(played.error());
    end = played->end;
    return {};
  };
  if (auto r = with_stations(play()); !r) return tl::unexpected(r.error());
  jogged.end = now.target;
  jogged.duration_s = static_cast<double>(end - begin) * seconds(machine.bus.cycle);
  return jogged;
}

}  // namespace gantry::run
