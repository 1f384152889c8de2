// What an operator's keys act on: the owner in this process, or the one behind a connection.
#pragma once
#include <optional>
#include <string>

#include "app/run/owner.hpp"

namespace gantry::cli {

/// What is shown of a job while it runs.
struct JobSeen {
  std::string state;     ///< of the machine, "running"
  bool held = false;     ///< or on the way to it
  CycleIndex cycle = 0;  ///< at which this was so
  double override_factor = 1;
  run::Progress progress{};
};

class Operated {
 public:
  virtual ~Operated() = default;
  [[nodiscard]] virtual JobSeen seen() const = 0;
  /// Hold, resume, abort, override, reset.
  virtual Result<void> order(const run::Order& order) = 0;
  /// What the last reset came to, once; nothing as long as it is under way.
  virtual std::optional<Result<void>> reset_answer() { return std::nullopt; }
  /// Ctrl-C.
  virtual void interrupt() = 0;
};

class OwnerOperated final : public Operated {
 public:
  explicit OwnerOperated(run::Owner& owner) : owner_(owner) {}
  [[nodiscard]] JobSeen seen() const override {
    const cycle::Snapshot& s = owner_.latest();
    return {.state = std::string(cycle::name(owner_.state())),
            .held = owner_.held(),
            .cycle = s.cycle,
            .override_factor = s.override_factor,
            .progress = owner_.progress()};
  }
  Result<void> order(const run::Order& order) override { return owner_.order(order); }
  std::optional<Result<void>> reset_answer() override { return owner_.reset_answer(); }
  void interrupt() override {
    owner_.interrupt(
        Error{Fault::Interrupted, "interrupted; the machine has come to rest and the valve is closed", ""});
  }

 private:
  run::Owner& owner_;
};

}  // namespace gantry::cli
