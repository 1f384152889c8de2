#include "app/desk/prepare.hpp"

#include "app/job/marks_apart.hpp"
#include "app/job/turned_board.hpp"
#include "app/record/certificate.hpp"

namespace gantry::desk {
namespace {

Checked<void> matches(const std::string& certificate_file, const config::Machine& machine,
                      const recipes::Recipe& recipe, const std::vector<std::size_t>& chosen) {
  if (certificate_file.empty()) return {};
  const auto certificate = record::read_certificate(certificate_file);
  if (!certificate) return tl::unexpected(certificate.error());
  if (auto same = record::demand(*certificate, machine, recipe, chosen); !same)
    return tl::unexpected(std::vector{same.error()});
  return {};
}

}  // namespace

Checked<Prepared> prepare(const config::Machine& machine, const std::string& recipe_file,
                          const recipes::Selection& selection, const Checks& checks) {
  if (checks.folder)
    if (auto usable = record::check_folder(*checks.folder); !usable) return tl::unexpected(std::vector{usable.error()});
  auto compiled = recipes::load_for(recipe_file, machine);
  if (!compiled) return tl::unexpected(compiled.error());
  if (auto apart = job::marks_apart(compiled->recipe, machine); !apart)
    return tl::unexpected(std::vector{apart.error()});
  if (auto one_way = job::fits_one_way(compiled->recipe, machine); !one_way)
    return tl::unexpected(std::vector{one_way.error()});
  const auto chosen = recipes::choose(compiled->recipe, selection);
  if (!chosen) return tl::unexpected(std::vector{chosen.error()});
  if (auto same = matches(checks.certificate, machine, compiled->recipe, *chosen); !same)
    return tl::unexpected(same.error());
  recipes::Job job = recipes::only(std::move(compiled->job), *chosen);
  auto proof = job::prove_nominal(machine, compiled->recipe, job, checks.breath, checks.opinion, checks.progress);
  return Prepared{std::move(compiled->recipe), std::move(job), selection, std::move(proof)};
}

}  // namespace gantry::desk
