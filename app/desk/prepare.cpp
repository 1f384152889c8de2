#include "app/desk/prepare.hpp"

#include "app/job/turned_board.hpp"

namespace gantry::desk {

Checked<Prepared> prepare(const config::Machine& machine, const std::string& recipe_file,
                          const recipes::Selection& selection) {
  auto compiled = recipes::load_for(recipe_file, machine);
  if (!compiled) return tl::unexpected(compiled.error());
  if (auto one_way = job::fits_one_way(compiled->recipe, machine); !one_way)
    return tl::unexpected(std::vector{one_way.error()});
  const auto chosen = recipes::choose(compiled->recipe, selection);
  if (!chosen) return tl::unexpected(std::vector{chosen.error()});
  recipes::Job job = recipes::only(std::move(compiled->job), *chosen);
  auto proof = job::prove_nominal(machine, compiled->recipe, job);
  return Prepared{std::move(compiled->recipe), std::move(job), selection, std::move(proof)};
}

}  // namespace gantry::desk
