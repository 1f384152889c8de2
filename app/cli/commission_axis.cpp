#include "app/cli/commission_axis.hpp"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "app/cli/client.hpp"
#include "app/cli/keys.hpp"
#include "app/cli/signals.hpp"
#include "app/cli/terminal.hpp"
#include "app/cli/today.hpp"
#include "app/desk/state_folder.hpp"
#include "app/run/measure_delay.hpp"
#include "app/stations/measured.hpp"

namespace gantry::cli {
namespace {

Result<config::MeasuredDelay> measure(config::Machine& machine, const run::OwnerOptions& options,
                                      const run::DelayWords& words) {
  hold_machine(Terminal::Matters);
  hold_on_stop_key();
  auto owner = run::Owner::open(machine, options);
  if (!owner) return tl::unexpected(owner.error());
  OwnerOperated operated(**owner);
  Keys keys(operated, Keys::Shows::Nothing);
  (*owner)->on_step([&] { keys.poll(); });
  Result<void> ready = (*owner)->bring_up();
  if (ready) ready = (*owner)->home();
  auto found = ready ? run::measure_delay(**owner, machine, words, [&] { keys.poll(); })
                     : Result<config::MeasuredDelay>(tl::unexpected(ready.error()));
  (*owner)->shut_down();
  if (found) found->date = today();
  return found;
}

}  // namespace

void commission_axis(Context& context, config::Machine machine, const AxisOptions& options) {
  const auto stop_with = [&](const Error& error) { context.exit_code = show(error, context.json); };
  const auto folder = state_of(context, options.state);
  if (!folder) return;
  run::OwnerOptions own;
  own.bus = options.interface.empty() ? "sim" : "ethercat:" + options.interface;
  own.virtual_time = options.interface.empty();  // nobody watches the simulated machine
  own.state = *folder;
  own.interrupted = interrupted;
  const run::DelayWords words{.axis = options.axis, .speed = options.speed};
  if (auto r = run::measuring_speed(machine, words); !r) return stop_with(r.error());
  const std::string file = stations::measured_file(*folder, own.bus);
  if (auto read = stations::read_measured(file, machine); !read) return stop_with(read.error());
  const auto found = measure(machine, own, words);
  if (!found) return stop_with(found.error());
  config::Axis* axis = nullptr;
  for (config::Axis& each : machine.axes)
    if (each.name == options.axis) each.measured = *found, axis = &each;
  if (auto made = desk::open_state_folder(*folder); !made) return stop_with(made.error());
  if (auto kept = stations::write_measured(file, machine); !kept) return stop_with(kept.error());
  if (context.json)
    show_document("done", {{"axis", axis->name},
                           {"stated_s", axis->response_delay_s},
                           {"measured_s", found->delay_s},
                           {"within_s", found->within_s},
                           {"speed", found->speed},
                           {"date", found->date}});
  else
    print_text("{}\n", stations::measured_in_words(*axis));
}

}  // namespace gantry::cli
