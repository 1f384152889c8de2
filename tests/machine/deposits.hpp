// What the world's log must say of a job that went well.
//   expect_done(result);   expect_deposits(recipe, result);
#pragma once
#include <map>
#include <string>

#include "tests/machine/rig.hpp"

namespace gantry::test {

inline void expect_done(const record::JobResult& result) {
  for (const Error& e : result.errors) ADD_FAILURE() << to_text(e);
  for (const record::Defect& d : result.defects) ADD_FAILURE() << d.feature << ": " << d.message;
  EXPECT_EQ(result.exit_code, ExitCode::Done);
}

/// Every feature of the recipe lies on the board, once, within 20 um (and its corner tolerance) of where the recipe
/// wants it, its gap within 30 um. A tilted board's gaps are only right when three touches have told its plane.
inline void expect_deposits(const recipes::Recipe& recipe, const record::JobResult& result) {
  std::map<std::string, const record::Deposit*> by_id;
  for (const record::Deposit& d : result.deposits) {
    if (d.kind == sim::kPurgeKind) continue;
    EXPECT_TRUE(by_id.emplace(d.id, &d).second) << "twice: '" << d.id << "'";
  }
  EXPECT_EQ(by_id.size(), recipe.features.size());
  for (const recipes::Feature& feature : recipe.features) {
    const auto* bead = std::get_if<recipes::Bead>(&feature);
    const std::string& id = bead != nullptr ? bead->id : std::get<recipes::Dot>(feature).id;
    const std::string& material = bead != nullptr ? bead->material : std::get<recipes::Dot>(feature).material;
    const auto found = by_id.find(id);
    if (found == by_id.end()) {
      ADD_FAILURE() << "not dispensed: " << id;
      continue;
    }
    EXPECT_LE(found->second->error_mm, 0.020 + (bead != nullptr ? bead->corner_tolerance : 0)) << id;
    if (recipe.touches.size() >= 3) {
      EXPECT_NEAR(found->second->gap_mm, recipes::find_material(recipe, material)->gap, 0.030) << id;
    }
  }
}

}  // namespace gantry::test
