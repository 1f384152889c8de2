// What an operator's keys and his shell act on: the owner in this process, or the one behind a connection (client.cpp).
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

  /// Whether nothing moves, and nothing will before somebody resumes it.
  enum class Stands { NotYet, Yes, Ended };
  /// Ctrl-Z: asks for that, in every step until it is so. What cannot be held is ended instead.
  virtual Stands come_to_stand() = 0;
  /// It stands: the shell gets its terminal.
  virtual void suspend() = 0;
};

/// The machine is held by this process, so that a front stops in its place (front.hpp).
class OwnerOperated final : public Operated {
 public:
  enum class Of {
    Job,     ///< one job or homing of this verb: nothing else is waited for
    Service  ///< an owner that stands idle most of the time
  };
  explicit OwnerOperated(run::Owner& owner, Of of = Of::Job) : owner_(owner), of_(of) {}
  [[nodiscard]] JobSeen seen() const override;
  Result<void> order(const run::Order& order) override { return owner_.order(order); }
  std::optional<Result<void>> reset_answer() override { return owner_.reset_answer(); }
  void interrupt() override;
  Stands come_to_stand() override;
  void suspend() override;

 private:
  Stands end_it(const char* why);

  run::Owner& owner_;
  Of of_;
};

}  // namespace gantry::cli
