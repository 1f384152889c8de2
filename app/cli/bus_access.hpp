// What `gantry bus` works on: the segment behind a network interface, or the virtual one of the machine file in this
// process.
//   auto bus = BusAccess::open(context, options);      // errors are shown, context.exit_code is set
//   devices::Survey survey(bus->port(), bus->clock());
//   auto position = bus->find(stations, "y1");          // by position, alias:NNN or the machine file's name
#pragma once
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "app/cli/verbs.hpp"
#include "devices/ethercat/survey.hpp"
#include "devices/frame_port.hpp"

namespace gantry::cli {

struct BusOptions {
  std::string interface;  ///< empty: the virtual segment in this process
};

class BusAccess {
 public:
  virtual ~BusAccess() = default;
  static std::unique_ptr<BusAccess> open(Context& context, const BusOptions& options);

  [[nodiscard]] virtual devices::FramePort& port() = 0;
  [[nodiscard]] virtual Clock& clock() = 0;
  /// Brings the machine file's stations up to SAFE_OP and leaves them there, in order to have something to look at.
  virtual Result<void> bring_up() = 0;

  [[nodiscard]] bool is_virtual() { return clock().is_virtual(); }
  /// The machine file; in front of an interface it serves for names only, and may be one of another machine.
  [[nodiscard]] const config::Machine& machine() const { return machine_; }
  /// What the machine file calls the station at a position, if it is the one that it names.
  [[nodiscard]] const config::Station* configured(const devices::FoundStation& found) const;
  /// Position of the station that a user names. Fault::Usage with what there is.
  Result<int> find(std::span<const devices::FoundStation> stations, const std::string& wanted) const;

 protected:
  explicit BusAccess(config::Machine machine) : machine_(std::move(machine)) {}
  config::Machine machine_;
};

/// "0 'x'" or "0 iD286-ECFA".
std::string title(const BusAccess& bus, const devices::FoundStation& found);

void add_bus_interface(CLI::App& verb, BusOptions& options);
/// The verbs below `bus`.
void add_bus_scan(CLI::App& bus, Context& context);
void add_bus_sdo(CLI::App& bus, Context& context);
void add_bus_errors(CLI::App& bus, Context& context);
void add_bus_dc(CLI::App& bus, Context& context);
void add_bus_capture(CLI::App& bus, Context& context);

}  // namespace gantry::cli
