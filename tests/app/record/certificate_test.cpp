#include "app/record/certificate.hpp"

#include <fstream>
#include <functional>
#include <gtest/gtest.h>
#include <iterator>

#include "app/job/block_plan.hpp"
#include "app/record/job_folder.hpp"
#include "app/record/motion_file.hpp"
#include "recipes/selection.hpp"
#include "tests/app/record/made_up_job.hpp"
#include "tests/app/record/snapshots.hpp"

namespace gantry::record {
namespace {

using nlohmann::ordered_json;

struct CertificateFile : testing::Test {
  Folder folder;
  config::Machine machine = *config::load_machine("config/machines/dispenser.yaml");
  recipes::Recipe recipe = *recipes::load("recipes/demo-board.yaml");
  recipes::Selection selection{};
  job::NominalProof proof = [] {
    job::NominalProof some;
    some.motions = 77;
    some.only_when_placed.push_back({"near_the_clip", {}});
    return some;
  }();
  std::string path = folder.path + "/certificate.json";

  static JobResult result() { return made_up_job(); }  // a dry run's
  void write() { ASSERT_TRUE(write_certificate(folder.path, result(), {machine, recipe, selection, proof})); }
  ordered_json written() const {
    std::ifstream in(path);
    return ordered_json::parse(in);
  }
  void rewrite(const std::string& text) const { std::ofstream(path) << text; }
  Result<void> demanded(const std::vector<std::size_t>& chosen = {0}) const {
    const auto certificate = read_certificate(path);
    if (!certificate) return tl::unexpected(certificate.error().front());
    return demand(*certificate, machine, recipe, chosen);
  }
};

/// A block of one motion, listed, and what others' programs say of the file.
TEST_F(CertificateFile, names_the_list_of_its_motions_by_count_and_hash) {
  const std::string list = folder.path + "/motions.csv";
  job::BlockPlanner planner(machine, recipe);
  planner.list_motions();
  AxisVec at{};
  for (const auto& [axis, position] : machine.park) at[axis.value] = position;
  const auto block = planner.look_at_mark(1, at, 0);
  ASSERT_TRUE(block);
  MotionFile file(list, machine);
  file.add(*block), file.add(*block);
  const auto listed = file.close();
  ASSERT_TRUE(listed);
  JobResult r = result();
  r.motions_listed = *listed;
  ASSERT_TRUE(write_certificate(folder.path, r, {machine, recipe, selection, proof}));
  const auto motions = written().at("motions");
  EXPECT_EQ(motions.at("file"), "motions.csv");
  EXPECT_EQ(motions.at("count"), 2 * block->motions());
  EXPECT_EQ(std::system(("[ $(tail -n +2 " + list + " | wc -l) = " + motions.at("count").dump() + " ]").c_str()), 0);
  EXPECT_EQ(std::system(
                ("echo " + motions.at("sha256").get<std::string>() + "  " + list + " | sha256sum -c --quiet").c_str()),
            0);
}

TEST_F(CertificateFile, a_list_does_not_stay_where_no_certificate_names_it) {
  const std::string list = folder.path + "/motions.csv";
  const auto lies_there_after = [&](const Certify& certify) {
    std::ofstream(list) << "block,motion\n";
    JobResult r = result();
    EXPECT_TRUE(write_job(r, folder.path, certify));
    return std::ifstream(list).good();
  };
  EXPECT_FALSE(lies_there_after([](const std::string&) -> Result<void> { return {}; })) << "a job that was not done";
  EXPECT_FALSE(lies_there_after({}));
  EXPECT_TRUE(lies_there_after([&](const std::string& into) {
    return write_certificate(into, result(), {machine, recipe, selection, proof});
  }));
}

TEST_F(CertificateFile, tells_what_was_proved_and_what_the_proof_rests_on) {
  write();
  const auto j = written();
  const job::ProofInputs inputs = job::proof_inputs(machine, recipe);
  ASSERT_EQ(j.at("hashes").size(), 5u);
  EXPECT_EQ(j.at("hashes").at("scene"), inputs.scene);
  EXPECT_EQ(j.at("hashes").at("head"), inputs.head);
  EXPECT_EQ(j.at("hashes").at("recipe"), inputs.recipe);
  EXPECT_EQ(j.at("hashes").at("limits"), inputs.limits);
  EXPECT_EQ(j.at("hashes").at("calibration"), inputs.calibration);
  EXPECT_EQ(j.at("motions_certified"), 148);
  EXPECT_TRUE(j.at("minimum_clearance").contains("by_design"));
  EXPECT_TRUE(j.at("minimum_clearance").contains("others"));
  EXPECT_EQ(j.at("scope").at("nominal").at("motions_certified"), 77);
  EXPECT_EQ(j.at("motions"), nullptr) << "the disk was full";
  // demo-board.yaml: max_shift 3 mm, max_rotation 2 deg, window 1.5 mm
  EXPECT_EQ(j.at("scope").at("nominal").at("to_marks"),
            (ordered_json{{"shift_mm", 3.0}, {"rotation_deg", 2.0}, {"upwards_mm", 1.5}}));
  EXPECT_EQ(j.at("scope").at("nominal").at("to_touches"),
            (ordered_json{{"shift_mm", 0.0}, {"rotation_deg", 0.0}, {"upwards_mm", 1.5}}));
  EXPECT_EQ(j.at("scope").at("nominal").at("features"), j.at("scope").at("nominal").at("to_marks"));
  EXPECT_EQ(j.at("scope").at("nominal").at("only_when_placed"),
            (ordered_json{{"count", 1}, {"first", {"near_the_clip"}}}));
  EXPECT_EQ(j.at("scope").at("placed").at("dx_mm"), 1.3);
  EXPECT_EQ(j.at("machine_file"), "config/machines/dispenser.yaml");
  for (const char* key : {"recipe", "recipe_file", "machine", "program", "made", "format"})
    EXPECT_TRUE(j.contains(key)) << key;
  EXPECT_TRUE(j.at("program").contains("commit"));
}

TEST_F(CertificateFile, is_read_back_and_demands_nothing_of_a_job_that_is_the_same) {
  write();
  const auto same = demanded();
  EXPECT_TRUE(same) << to_text(same.error());
}

TEST_F(CertificateFile, another_number_is_refused_by_the_name_of_its_hash_with_what_to_do) {
  write();
  const config::Machine was = machine;
  const struct {
    const char* says;
    std::function<void(config::Machine&)> change;
  } kChanges[] = {{"scene (certified", [](auto& m) { m.scene[0].shape.size.x += 0.01; }},
                  {"head (certified", [](auto& m) { m.head[1].shape.size.x += 0.01; }},
                  {"limits (certified", [](auto& m) { m.axes[0].p_max -= 1; }},
                  {"calibration (certified", [](auto& m) { m.tools[0].tip.z += 0.01; }}};
  for (const auto& [says, change] : kChanges) {
    machine = was;
    change(machine);
    const auto refused = demanded();
    ASSERT_FALSE(refused) << says;
    EXPECT_EQ(refused.error().fault, Fault::Refused);
    EXPECT_EQ(info(refused.error().fault).exit_code, ExitCode::Refused);
    EXPECT_EQ(refused.error().where, path);
    const std::string& message = refused.error().message;
    EXPECT_NE(message.find(says), std::string::npos) << message;
    EXPECT_NE(message.find("dry-run recipes/demo-board.yaml"), std::string::npos) << message;
    for (const auto& [other, unused] : kChanges)
      EXPECT_EQ(message.find(other) != std::string::npos, other == says) << message;
  }
  machine = was;
  recipe.materials[0].gap += 0.01;
  machine.axes[0].v_max += 1;
  const auto refused = demanded();
  ASSERT_FALSE(refused);
  EXPECT_NE(refused.error().message.find("recipe (certified"), std::string::npos) << refused.error().message;
  EXPECT_NE(refused.error().message.find("limits (certified"), std::string::npos) << refused.error().message;
}

TEST_F(CertificateFile, covers_the_features_that_were_dispensed_in_the_dry_run_and_no_others) {
  selection.only = {"spreader"};
  write();
  EXPECT_TRUE(demanded(*recipes::choose(recipe, selection)));
  EXPECT_TRUE(demanded(*recipes::choose(recipe, {.from = "", .only = {"spreader[0][1]"}})));
  const auto refused = demanded(*recipes::choose(recipe, {}));
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().fault, Fault::Refused);
  EXPECT_NE(refused.error().message.find("--only spreader"), std::string::npos) << refused.error().message;
  EXPECT_NE(refused.error().message.find("'anchor_left'"), std::string::npos) << refused.error().message;
  selection = {.from = "transformer_dam", .only = {}};
  write();
  EXPECT_FALSE(demanded({0}));
  EXPECT_TRUE(demanded(*recipes::choose(recipe, selection)));
}

TEST_F(CertificateFile, a_file_that_is_none_is_a_mistake_with_its_place) {
  write();
  const std::string good = written().dump(2);
  const auto with = [&](const std::function<void(ordered_json&)>& change) {
    ordered_json j = ordered_json::parse(good);
    change(j);
    return j.dump(2);
  };
  std::string twice = good;
  twice.replace(twice.find("\"job\""), 5, "\"format\"");
  const struct {
    std::string text;
    Fault fault;
    const char* where;  // behind the file's name
  } kWrong[] = {
      {"", Fault::None, ""},
      {"[]", Fault::BadValue, ":1:1"},
      {"{\"format\": 1,\n \"hashes\": [", Fault::None, ":2:"},
      {with([](auto& j) { j.erase("hashes"); }), Fault::MissingKey, ":1:1"},
      {with([](auto& j) { j["format"] = 2; }), Fault::BadValue, ":2:13"},
      {with([](auto& j) { j["format"] = "1"; }), Fault::BadValue, ":2:13"},
      {with([](auto& j) { j["format"] = true; }), Fault::BadValue, ":2:13"},
      {with([](auto& j) { j["result"] = 1; }), Fault::BadValue, ":4:13"},
      {with([](auto& j) { j["hashes"]["scene"] = 5; }), Fault::BadValue, ":15:"},
      {with([](auto& j) { j["scope"] = "all"; }), Fault::BadValue, ""},
      {with([](auto& j) { j["scope"]["selection"]["from"] = 5; }), Fault::BadValue, ""},
      {with([](auto& j) { j["scope"]["selection"]["from"] = ordered_json::array(); }), Fault::BadValue, ""},
      {with([](auto& j) { j["scope"]["selection"]["only"] = {7}; }), Fault::BadValue, ""},
      {with([](auto& j) { j["hashes"]["scene"] = "abc"; }), Fault::BadValue, ":15:"},
      {with([](auto& j) { j["hashes"].erase("limits"); }), Fault::MissingKey, ":14:"},
      {with([](auto& j) { j["hashes"]["head"] = ordered_json::array(); }), Fault::BadValue, ":16:"},
      {with([](auto& j) { j["scope"].erase("selection"); }), Fault::MissingKey, ""},
      {with([](auto& j) { j["scope"]["selection"]["only"] = {ordered_json::array()}; }), Fault::BadValue, ""},
      {twice, Fault::DuplicateKey, ":3:3"},
      {std::string(2u << 20, ' '), Fault::FileTooLarge, ""},
      {good.substr(0, good.size() / 2), Fault::None, ":"},
      {std::string("\x00\xff\xfe", 3), Fault::None, ":"},
  };
  for (const auto& [text, fault, where] : kWrong) {
    rewrite(text);
    const auto wrong = read_certificate(path);
    ASSERT_FALSE(wrong) << text.substr(0, 200);
    const Error& e = wrong.error().front();
    EXPECT_EQ(info(e.fault).exit_code, ExitCode::InvalidFile) << to_text(e);
    EXPECT_TRUE(fault == Fault::None || e.fault == fault) << to_text(e);
    EXPECT_EQ(e.where.find(path + where), 0u) << to_text(e) << ", not " << where;
  }
  std::filesystem::remove(path);
  const auto gone = read_certificate(path);
  ASSERT_FALSE(gone);
  EXPECT_EQ(gone.error().front().fault, Fault::FileUnreadable);
}

/// Cut anywhere, with any byte changed: it is read, or refused; a hash that was changed is never taken for the same.
TEST_F(CertificateFile, a_damaged_one_is_never_a_match_that_it_was_not) {
  write();
  std::ifstream in(path);
  const std::string good{std::istreambuf_iterator<char>(in), {}};
  const std::size_t hashes = good.find("\"hashes\""), end = good.find('}', hashes);
  for (std::size_t i = hashes; i < end; ++i) {
    std::string bad = good;
    bad[i] = static_cast<char>(bad[i] == '7' ? '8' : '7');
    if (std::isspace(static_cast<unsigned char>(good[i])) != 0) continue;
    rewrite(bad);
    EXPECT_FALSE(demanded()) << "byte " << i;
  }
}

TEST_F(CertificateFile, is_written_of_a_dry_run_that_is_done_alone_and_an_older_one_does_not_survive) {
  write();
  ASSERT_TRUE(std::filesystem::exists(path));
  ASSERT_TRUE(job_folder({.path = folder.path, .overwrite = true}, recipe.file));
  EXPECT_FALSE(std::filesystem::exists(path)) << "it was of another job";
  JobResult failed = made_up_failure();
  failed.dry_run = true;
  JobResult defects = result();
  defects.exit_code = ExitCode::DoneWithDefects;
  JobResult real = result();
  real.dry_run = false;
  for (const JobResult& r : {failed, defects, real}) {
    ASSERT_TRUE(write_certificate(folder.path, r, {machine, recipe, selection, proof}));
    EXPECT_FALSE(std::filesystem::exists(path));
  }
}

}  // namespace
}  // namespace gantry::record
