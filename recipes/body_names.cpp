#include "recipes/body_names.hpp"

#include <fmt/format.h>
#include <set>

namespace gantry::recipes {

void check_body_names(const Recipe& recipe, const config::Machine& machine, config::Mistakes& mistakes) {
  std::set<std::string> scene, head, zones;
  for (const config::Body& body : machine.scene) scene.insert(body.name);
  for (const config::Body& body : machine.head) head.insert(body.name);
  for (const config::Body& zone : machine.keep_out) zones.insert(zone.name);
  for (const Part& part : recipe.parts) {
    if (part.name == "board")
      mistakes.add(Fault::DuplicateKey, "'board' is what messages call the board itself; choose another name",
                   part.location);
    const bool of_head = head.contains(part.name);
    if (of_head || scene.contains(part.name))
      mistakes.add(Fault::DuplicateKey,
                   fmt::format("the machine's {} has a body '{}' too; messages name bodies, choose another name",
                               of_head ? "head" : "scene", part.name),
                   part.location);
  }
  for (const Part& zone : recipe.keep_out)
    if (zones.contains(config::zone_name(zone.name)))
      mistakes.add(Fault::DuplicateKey,
                   fmt::format("the machine has a zone '{}' to keep out of too; messages name it, choose another name",
                               zone.name),
                   zone.location);
}

}  // namespace gantry::recipes
