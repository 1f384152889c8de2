#include "app/record/bead_speed_file.hpp"

#include <cmath>
#include <fmt/format.h>
#include <variant>

#include "config/inputs.hpp"

namespace gantry::record {
namespace {

constexpr std::size_t kAtOnce = 4096;  // bytes

}  // namespace

void BeadSpeedFile::add(const cycle::Snapshot& s) {
  const bool on_feature = s.block != 0 && s.feature < recipe_->features.size();
  const auto* bead = on_feature ? std::get_if<recipes::Bead>(&recipe_->features[s.feature]) : nullptr;
  Row now;
  if (bead != nullptr)
    now = {s.block, s.feature, static_cast<double>(s.time_ns - start_ns_) * 1e-9, s.path_speed,
           (s.outputs & config::bit(config::Output::Valve)) != 0};
  const bool same = now.feature == seen_.feature && now.block == seen_.block;
  if (!same && seen_.feature != motion::kTravel && seen_.t_s > written_.t_s) write(seen_);
  if (bead != nullptr) {
    if (!same) {
      const recipes::Material* m = recipes::find_material(*recipe_, bead->material);
      change_mm_s_ = m != nullptr ? kChange * m->speed : 0;
    }
    if (!same || now.valve != written_.valve || std::abs(now.speed_mm_s - written_.speed_mm_s) > change_mm_s_)
      write(now);
  }
  seen_ = now;
}

void BeadSpeedFile::write(const Row& row) {
  rows_ += fmt::format("{},{:.3f},{:.4f},{}\n", recipes::id_of(recipe_->features[row.feature]), row.t_s, row.speed_mm_s,
                       row.valve ? 1 : 0);
  written_ = row;
  if (rows_.size() >= kAtOnce) out_->write(std::exchange(rows_, {}));
}

Result<void> BeadSpeedFile::close() {
  if (seen_.feature != motion::kTravel && seen_.t_s > written_.t_s) write(seen_);
  seen_ = {};
  out_->write(std::exchange(rows_, {}));
  return out_->close();
}

}  // namespace gantry::record
