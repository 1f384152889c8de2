#include <gtest/gtest.h>

#include "config/drive.hpp"

namespace gantry::config {
namespace {

StationProfile profile(const std::string& name) {
  auto p = load_profile("config/" + name);
  if (!p)
    for (const Error& e : p.error()) ADD_FAILURE() << to_text(e);
  return p ? *p : StationProfile{};
}

TEST(Profile, shipped_profiles_read_without_a_mistake) {
  for (const char* name :
       {"drives/id286.yaml", "drives/amd530b.yaml", "drives/std402ec.yaml", "drives/iss57.yaml", "devices/dio16.yaml"})
    EXPECT_FALSE(profile(name).objects.empty()) << name;
}

}  // namespace
}  // namespace gantry::config
