// Two runs have the same hashes when they were told the same, however it was written; one number more or less shows in
// the hash that it belongs to, and in no other.
#include "app/job/proof_inputs.hpp"

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <functional>
#include <gtest/gtest.h>
#include <iterator>
#include <unistd.h>

#include "core/sha256.hpp"
#include "tests/app/job/reference.hpp"

namespace gantry::job {
namespace {

namespace fs = std::filesystem;

constexpr const char* kRecipe = "recipes/demo-board.yaml";
constexpr const char* kMachine = "config/machines/dispenser.yaml";

std::string read_all(const std::string& path) {
  std::ifstream in(path);
  return {std::istreambuf_iterator<char>(in), {}};
}

/// Names of the hashes that differ, "scene,recipe".
std::string differ(const ProofInputs& a, const ProofInputs& b) {
  std::string out;
  for (const ProofInput& input : kProofInputs)
    if (a.*input.hash != b.*input.hash) out += (out.empty() ? "" : ",") + std::string(input.name);
  return out;
}

/// What stands behind each key of the top, in the opposite order.
std::string upside_down(const std::string& yaml) {
  std::vector<std::string> blocks(1);
  for (std::size_t at = 0; at < yaml.size();) {
    const std::size_t end = std::min(yaml.find('\n', at), yaml.size() - 1) + 1;
    const std::string line = yaml.substr(at, end - at);
    if (line[0] != ' ' && line[0] != '#' && line[0] != '\n' && line[0] != '-') blocks.emplace_back();
    if (line[0] != '#') blocks.back() += line;
    at = end;
  }
  std::reverse(blocks.begin(), blocks.end());
  std::string out;
  for (const std::string& block : blocks) out += block;
  return out;
}

std::string replaced(std::string text, const std::string& from, const std::string& to) {
  const std::size_t at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  if (at != std::string::npos) text.replace(at, from.size(), to);
  return text;
}

recipes::Recipe recipe_of(const std::string& yaml) {
  const auto recipe = recipes::parse(yaml, "somewhere/else.yaml");
  if (recipe) return *recipe;
  for (const Error& e : recipe.error()) ADD_FAILURE() << to_text(e);
  return {};
}

struct ProofInputsTest : testing::Test {
  config::Machine machine = test::reference();
  std::string text = read_all(kRecipe), machine_text = read_all(kMachine);
  recipes::Recipe recipe = recipe_of(text);
  ProofInputs before = proof_inputs(machine, recipe);
  fs::path folder = fs::temp_directory_path() / ("gantry-inputs-" + std::to_string(getpid()));

  void SetUp() override {
    fs::create_directories(folder / "machines");
    for (const char* profiles : {"drives", "devices"})
      fs::create_directory_symlink(fs::absolute(fs::path("config") / profiles), folder / profiles);
  }
  void TearDown() override { fs::remove_all(folder); }

  config::Machine machine_of(const std::string& yaml) const {
    const fs::path file = folder / "machines" / "another.yaml";
    std::ofstream(file) << yaml;
    const auto read = config::load_machine(file);
    if (read) return *read;
    for (const Error& e : read.error()) ADD_FAILURE() << to_text(e);
    return {};
  }
};

TEST_F(ProofInputsTest, each_is_a_sha256_in_hex_and_they_are_five_different_ones) {
  std::vector<std::string> all;
  for (const ProofInput& input : kProofInputs) {
    const std::string& hash = before.*input.hash;
    EXPECT_EQ(hash.size(), 64u);
    EXPECT_EQ(hash.find_first_not_of("0123456789abcdef"), std::string::npos) << hash;
    all.push_back(hash);
  }
  std::sort(all.begin(), all.end());
  EXPECT_EQ(std::adjacent_find(all.begin(), all.end()), all.end());
}

TEST_F(ProofInputsTest, are_the_hash_of_the_text_that_the_docs_describe) {
  config::Machine m;
  config::Axis x;
  x.name = "X", x.p_min = -0.0, x.p_max = 400.5, x.v_max = 500, x.a_max = 4000, x.j_max = 80000;
  x.response_delay_s = 0.004, x.path_error = 0.25;
  m.axes = {x};
  m.clearance_mm = 2, m.safe_z_mm = -5, m.park = {{AxisId{0}, 20}};
  EXPECT_EQ(proof_inputs(m, {}).limits, sha256_hex("gantry limits 1\n"
                                                   "axis \"X\" streamed false 0 400.5 500 4000 80000 0.004 0.25\n"
                                                   "clearance 2\n"
                                                   "cycle 0.001\n"
                                                   "park \"X\" 20\n"
                                                   "safe_z -5\n"));
  m.tools = {{"needle", {0, 0, -40}, 30}, {"ca\"me\\ra", {60.25, 0, 1e-9}, 0}};
  m.frames = {{"pallet", {180, 150, -122}}};
  EXPECT_EQ(proof_inputs(m, {}).calibration, sha256_hex("gantry calibration 1\n"
                                                        "camera 0 0 0 0\n"
                                                        "frame \"pallet\" 180 150 -122\n"
                                                        "probe \"X\" 0 0 0 0 0 0\n"
                                                        "tool \"ca\\\"me\\\\ra\" 60.25 0 1e-09 0\n"
                                                        "tool \"needle\" 0 0 -40 30\n"));
}

TEST_F(ProofInputsTest, keys_in_another_order_comments_paths_and_units_change_nothing) {
  EXPECT_NE(upside_down(text), text);
  EXPECT_EQ(differ(before, proof_inputs(machine, recipe_of(upside_down(text)))), "");
  EXPECT_EQ(differ(before, proof_inputs(machine_of(upside_down(machine_text)), recipe)), "");
  EXPECT_EQ(differ(before, proof_inputs(machine, recipe_of("# another comment\n" + text))), "");
  const std::string capacitor = "capacitor:   {at: [24 mm, 46 mm], size: [10 mm, 10 mm, 14 mm]}";
  EXPECT_EQ(
      differ(before, proof_inputs(machine, recipe_of(replaced(
                                               text, capacitor,
                                               "capacitor: {size: [10 mm, 10000 um, 0.014 m], at: [24 mm, 46 mm]}")))),
      "");
  // Bodies, materials, axes: maps whose order tells nothing.
  const std::string relay = "  relay:       {at: [64 mm, 24 mm], size: [20 mm, 8 mm, 12 mm]}\n";
  EXPECT_EQ(
      differ(before,
             proof_inputs(machine, recipe_of(replaced(replaced(text, relay, ""), "parts:\n", "parts:\n" + relay)))),
      "");
  const std::string post =
      "  post:         {cylinder: {diameter: 16 mm, height: 60 mm}, centre: [165 mm, 262 mm, -92 mm]}\n";
  EXPECT_EQ(
      differ(before,
             proof_inputs(machine_of(replaced(replaced(machine_text, post, ""), "\nscene:\n", "\nscene:\n" + post)),
                          recipe)),
      "");
}

TEST_F(ProofInputsTest, a_default_that_is_written_out_changes_nothing) {
  EXPECT_EQ(differ(before, proof_inputs(machine, recipe_of(replaced(text, "recipe: demo-board\n",
                                                                    "recipe: demo-board\nplacement: marks\n")))),
            "");
}

TEST_F(ProofInputsTest, one_number_of_the_machine_shows_in_the_hash_it_belongs_to) {
  const struct {
    const char* hash;
    std::function<void(config::Machine&)> change;
  } kChanges[] = {
      {"scene", [](auto& m) { m.scene[0].centre.x += 1e-9; }},
      {"scene", [](auto& m) { m.scene[1].shape.size.z += 0.001; }},
      {"scene", [](auto& m) { m.scene[0].rotation_rad = 0.001; }},
      {"scene", [](auto& m) { m.scene.pop_back(); }},
      {"scene", [](auto& m) { m.scene[0].name += "2"; }},
      {"scene", [](auto& m) { m.scene[2].shape.kind = config::Shape::Kind::Capsule; }},
      {"scene", [](auto& m) { m.keep_out.push_back(m.scene[0]); }},
      {"head", [](auto& m) { m.head[0].centre.z += 0.001; }},
      {"head", [](auto& m) { m.head[3].shape.size.x += 0.001; }},
      {"head", [](auto& m) { m.head[0].on_lift = !m.head[0].on_lift; }},
      {"head", [](auto& m) { m.head[0].on_turn = !m.head[0].on_turn; }},
      {"head", [](auto& m) { m.u.reset(); }},
      {"limits", [](auto& m) { m.axes[0].p_max += 0.001; }},
      {"limits", [](auto& m) { m.axes[2].v_max += 0.001; }},
      {"limits", [](auto& m) { m.axes[3].a_max += 0.001; }},
      {"limits", [](auto& m) { m.axes[1].j_max += 0.001; }},
      {"limits", [](auto& m) { m.clearance_mm += 0.001; }},
      {"limits", [](auto& m) { m.safe_z_mm += 0.001; }},
      {"limits", [](auto& m) { m.park[0].second += 0.001; }},
      {"limits", [](auto& m) { m.bus.cycle = 2 * m.bus.cycle; }},
      {"calibration", [](auto& m) { m.tools[0].tip.x += 0.001; }},
      {"calibration", [](auto& m) { m.tools[0].lift_mm += 0.001; }},
      {"calibration", [](auto& m) { m.camera.mm_per_px += 1e-6; }},
      {"calibration", [](auto& m) { m.probe.travel_mm += 0.001; }},
      {"", [](auto& m) { m.camera.answer_latency_s += 0.1; }},
      {"", [](auto& m) { m.sim.camera_noise += 1; }},
      {"", [](auto& m) { m.file = "elsewhere.yaml", m.sha256 = ""; }},
      // The board lies elsewhere then.
      {"scene,calibration", [](auto& m) { m.frames[0].origin.x += 0.001; }},
  };
  for (const auto& [hash, change] : kChanges) {
    config::Machine changed = machine;
    change(changed);
    EXPECT_EQ(differ(before, proof_inputs(changed, recipe)), hash) << "change " << (&hash - &kChanges[0].hash);
  }
}

TEST_F(ProofInputsTest, one_number_of_the_recipe_shows_in_its_hash) {
  const struct {
    const char *from, *to, *hash;
  } kChanges[] = {
      {"at: [36 mm, 34 mm]", "at: [36.001 mm, 34 mm]", "recipe"},
      {"pitch: [6 mm, 5 mm]", "pitch: [6 mm, 5.001 mm]", "recipe"},
      {"skip: [[1, 3]]", "skip: [[1, 2]]", "recipe"},
      {"gap: 0.2 mm", "gap: 0.201 mm", "recipe"},
      {"speed: 20 mm/s", "speed: 20.1 mm/s", "recipe"},
      {"retract: 4 mm", "retract: 4.1 mm", "recipe"},
      {"max_shift: 3 mm", "max_shift: 3.1 mm", "recipe"},
      {"window: 1.5 mm", "window: 1.6 mm", "recipe"},
      {"front_left:  {at: [12 mm, 12 mm]}", "front_left:  {at: [12 mm, 12.1 mm]}", "recipe"},
      {"diameter: 1.5 mm", "diameter: 1.6 mm", "recipe"},
      {"recipe: demo-board", "recipe: demo-board-2", "recipe"},
      {"transformer: {at: [94 mm, 46 mm]", "transformer: {at: [94 mm, 46.001 mm]", "scene,recipe"},
      {"size: [12 mm, 16 mm, 22 mm]", "size: [12 mm, 16 mm, 22.001 mm]", "scene,recipe"},
      {"thickness: 12 mm", "thickness: 12.001 mm", "scene,recipe"},
      {"\nfixtures:", "\nkeep_out: {hose: {at: [150 mm, 9 mm], size: [9 mm, 9 mm, 9 mm]}}\nfixtures:", "scene,recipe"},
  };
  for (const auto& [from, to, hash] : kChanges)
    EXPECT_EQ(differ(before, proof_inputs(machine, recipe_of(replaced(text, from, to)))), hash) << to;
}

/// What stands is one thing, what must not be entered another, though nothing of their geometry differs.
TEST_F(ProofInputsTest, a_zone_is_no_body) {
  config::Machine m = machine;
  m.scene = {{"post", {config::Shape::Kind::Cylinder, {8, 8, 30.5}}, {50, 60, 25}}};
  m.keep_out = {{"keep-out door", {config::Shape::Kind::Box, {1, 2, 3}}, {4, 5, 6}, 0.5, false, false, true}};
  recipes::Recipe r;
  r.keep_out = {{.name = "hose", .at = {7, 8}, .size = {1, 1, 4}, .location = {}, .underside = 2}};
  EXPECT_EQ(proof_inputs(m, r).scene, sha256_hex("gantry scene 1\n"
                                                 "body \"board\" box 0 0 0 0 0 0 0 false false\n"
                                                 "body \"post\" cylinder 8 8 30.5 50 60 25 0 false false\n"
                                                 "keep_out \"keep-out door\" box 1 2 3 4 5 6 0.5 false false\n"
                                                 "keep_out \"keep-out hose\" box 1 1 4 7 8 4 0 false false\n"));
}

/// Features and marks are gone through in their order.
TEST_F(ProofInputsTest, what_is_done_in_another_order_is_something_else) {
  recipes::Recipe changed = recipe;
  std::swap(changed.features[0], changed.features[1]);
  EXPECT_EQ(differ(before, proof_inputs(machine, changed)), "recipe");
  changed = recipe;
  std::swap(changed.marks[0], changed.marks[1]);
  EXPECT_EQ(differ(before, proof_inputs(machine, changed)), "recipe");
}

}  // namespace
}  // namespace gantry::job
