// The folder of a job: what --force takes away, and what is left of a job whose disk is full.
#include "app/record/job_folder.hpp"

#include <algorithm>
#include <fcntl.h>
#include <fstream>
#include <gtest/gtest.h>
#include <iterator>
#include <nlohmann/json.hpp>
#include <sys/mount.h>
#include <sys/stat.h>
#include <sys/statvfs.h>
#include <thread>
#include <vector>

#include "app/record/report.hpp"
#include "core/sha256.hpp"
#include "tests/app/record/made_up_job.hpp"
#include "tests/app/record/snapshots.hpp"

namespace gantry::record {
namespace {

namespace fs = std::filesystem;

void put(const fs::path& path, const std::string& text = "mine") {
  fs::create_directories(path.parent_path());
  std::ofstream(path) << text;
}

nlohmann::json summary_of(const std::string& folder) {
  std::ifstream in(folder + "/summary.json");
  return nlohmann::json::parse(in, nullptr, false);
}

std::string path_of(const Result<JobFolder>& made) { return made ? made->path : to_text(made.error()); }

JobResult with_images() {
  JobResult r = made_up_job();
  for (MarkResult& m : r.marks) m.png.resize(100, std::byte{7});
  return r;
}

TEST(JobFolder, gives_its_job_a_name_however_its_path_was_written) {
  for (const char* path :
       {"out/first", "out/first/", "out/first//", "out/first/.", "./out/second/../first", "/tmp/first/"})
    EXPECT_EQ(name_of_job(path), "first") << path;
  EXPECT_EQ(name_of_job("."), fs::current_path().filename().string());
  EXPECT_EQ(name_of_job("/"), "");
}

TEST(JobFolder, force_takes_away_what_the_job_has_left_and_nothing_else) {
  const Folder folder;
  JobResult r = with_images();
  ASSERT_TRUE(write_job(r, folder.path));
  const auto images = image_names(r);
  ASSERT_TRUE(fs::exists(fs::path(folder.path) / images[0]));
  put(folder.path + "/marks/holiday.png");
  put(folder.path + "/notes.txt");
  put(folder.path + "/report.html.bak");
  ASSERT_FALSE(job_folder({.path = folder.path}, "a.yaml")) << "it holds a job";
  ASSERT_TRUE(job_folder({.path = folder.path, .overwrite = true}, "a.yaml"));
  for (const char* kept : {"marks/holiday.png", "notes.txt", "report.html.bak"})
    EXPECT_TRUE(fs::exists(fs::path(folder.path) / kept)) << kept;
  EXPECT_FALSE(fs::exists(fs::path(folder.path) / images[0]));
  EXPECT_FALSE(fs::exists(fs::path(folder.path) / "report.html"));
  // The next job does not take them for its own.
  ASSERT_TRUE(write_job(r, folder.path));
  ASSERT_TRUE(job_folder({.path = folder.path, .overwrite = true}, "a.yaml"));
  EXPECT_TRUE(fs::exists(folder.path + "/marks/holiday.png"));
}

TEST(JobFolder, is_not_cleared_while_its_job_writes) {
  const Folder folder;
  const std::string& path = folder.path;
  {
    const auto ours = job_folder({.path = path, .overwrite = true}, "a.yaml");
    ASSERT_TRUE(ours);
    const auto other = job_folder({.path = path + "/", .overwrite = true}, "b.yaml");
    ASSERT_FALSE(other);
    EXPECT_EQ(other.error().fault, Fault::Usage);
    EXPECT_NE(other.error().message.find("another job writes"), std::string::npos) << other.error().message;
    EXPECT_FALSE(check_folder({.path = path, .overwrite = true}));
  }
  EXPECT_TRUE(job_folder({.path = path, .overwrite = true}, "b.yaml"));
}

TEST(JobFolder, an_emptied_folder_of_images_goes_too) {
  const Folder folder;
  JobResult r = with_images();
  ASSERT_TRUE(write_job(r, folder.path));
  ASSERT_TRUE(job_folder({.path = folder.path, .overwrite = true}, "a.yaml"));
  EXPECT_TRUE(fs::is_empty(folder.path));
}

TEST(JobFolder, a_summary_that_names_files_of_others_is_not_believed) {
  const Folder folder, elsewhere;
  put(elsewhere.path + "/x.png");
  put(folder.path + "/job/deep/x.png");
  put(folder.path + "/outside.txt");
  fs::create_directories(folder.path + "/job/marks/sub");
  put(folder.path + "/job/summary.json", R"({"files": ["../outside.txt", "marks/../../outside.txt", "deep/x.png",
      "/etc/passwd", "marks/..", "marks/.", "marks/", "marks/sub", ")" +
                                             elsewhere.path + R"(/x.png", 7, null, "marks/../deep/x.png"]})");
  ASSERT_TRUE(job_folder({.path = folder.path + "/job", .overwrite = true}, "a.yaml"));
  for (const std::string& kept : {folder.path + "/outside.txt", folder.path + "/job/deep/x.png",
                                  elsewhere.path + "/x.png", folder.path + "/job/marks/sub"})
    EXPECT_TRUE(fs::exists(kept)) << kept;
  // Through a link nothing goes.
  fs::remove_all(folder.path + "/job/marks");
  fs::create_directory_symlink(elsewhere.path, folder.path + "/job/marks");
  put(folder.path + "/job/summary.json", R"({"files": ["marks/x.png"]})");
  ASSERT_TRUE(job_folder({.path = folder.path + "/job", .overwrite = true}, "a.yaml"));
  EXPECT_TRUE(fs::exists(elsewhere.path + "/x.png"));
  EXPECT_TRUE(fs::is_symlink(folder.path + "/job/marks"));
}

TEST(JobFolder, a_job_that_would_find_no_room_is_refused_before_anything_is_taken_away) {
  const Folder folder;
  put(folder.path + "/job/summary.json", "{}");
  struct statvfs disk {};
  ASSERT_EQ(statvfs(folder.path.c_str(), &disk), 0);
  const Room too_much{.result_bytes = std::uint64_t{disk.f_blocks} * disk.f_frsize, .large_bytes = 1'000'000};
  for (const WantedFolder& wanted :
       {WantedFolder{.path = folder.path + "/job", .overwrite = true}, WantedFolder{.under = folder.path + "/out"}}) {
    const auto refused = job_folder(wanted, "a.yaml", too_much);
    ASSERT_FALSE(refused);
    EXPECT_EQ(refused.error().fault, Fault::FileUnwritable);
    EXPECT_NE(refused.error().message.find("MB free"), std::string::npos) << refused.error().message;
    EXPECT_NE(refused.error().message.find("take old results away"), std::string::npos);
  }
  EXPECT_TRUE(fs::exists(folder.path + "/job/summary.json"));
  EXPECT_FALSE(fs::exists(folder.path + "/out"));
}

TEST(JobFolder, a_report_that_cannot_be_written_costs_neither_the_summary_nor_the_result) {
  const Folder folder;
  fs::create_directories(folder.path + "/report.html");  // no file can take this name
  put(folder.path + "/marks");                           // and no image finds its folder
  JobResult r = with_images();
  r.exit_code = ExitCode::Done;
  r.errors.clear();
  r.sources.clear();
  ASSERT_TRUE(write_job(r, folder.path));
  const auto j = summary_of(folder.path);
  EXPECT_EQ(j.at("result"), "done");
  EXPECT_EQ(j.at("exit_code"), 0);
  EXPECT_EQ(j.at("files"), nlohmann::json::array({"summary.json"}));
  ASSERT_EQ(j.at("not_kept").size(), 1 + image_names(r).size());
  EXPECT_EQ(j.at("not_kept")[0].at("file"), "report.html");
  EXPECT_FALSE(has_report(folder.path));
}

TEST(JobFolder, the_bytes_that_a_job_was_made_of_are_kept_and_those_that_have_changed_since_are_not) {
  const Folder folder, elsewhere;
  put(elsewhere.path + "/board.yaml", "recipe: a\n");
  put(elsewhere.path + "/sub/board.yaml", "machine: b\n");
  put(elsewhere.path + "/points.csv", "1 2 3\n");
  JobResult r = made_up_job();
  r.sources = {{elsewhere.path + "/board.yaml", 10, sha256_of_file(elsewhere.path + "/board.yaml")},
               {elsewhere.path + "/points.csv", 6, sha256_of_file(elsewhere.path + "/points.csv")}};
  r.origin.machine_file = elsewhere.path + "/sub/board.yaml";
  r.origin.machine_sha256 = sha256_of_file(elsewhere.path + "/sub/board.yaml");
  put(elsewhere.path + "/drive.yaml", "title: c\n");
  r.origin.profiles = {{elsewhere.path + "/drive.yaml", 0, sha256_of_file(elsewhere.path + "/drive.yaml")}};
  put(elsewhere.path + "/points.csv", "9 9 9\n");
  ASSERT_TRUE(write_job(r, folder.path));
  EXPECT_EQ(sha256_of_file(folder.path + "/inputs/board.yaml"), r.sources[0].sha256);
  EXPECT_EQ(sha256_of_file(folder.path + "/inputs/2-board.yaml"), r.origin.machine_sha256);
  EXPECT_EQ(sha256_of_file(folder.path + "/inputs/drive.yaml"), r.origin.profiles[0].sha256);
  EXPECT_FALSE(fs::exists(folder.path + "/inputs/points.csv"));
  ASSERT_EQ(r.not_kept.size(), 1u);
  EXPECT_EQ(r.not_kept[0].file, "inputs/points.csv");
  ASSERT_TRUE(job_folder({.path = folder.path, .overwrite = true}, "a.yaml"));
  EXPECT_TRUE(fs::is_empty(folder.path));
}

TEST(JobFolder, what_lies_there_and_is_no_jobs_stays_as_it_is) {
  const Folder folder;
  JobResult r = with_images();
  const auto images = image_names(r);
  put(folder.path + "/" + images[0]);
  put(folder.path + "/inputs/board.yaml");
  put(folder.path + "/elsewhere/board.yaml", "recipe: a\n");
  r.sources = {{folder.path + "/elsewhere/board.yaml", 10, sha256_of_file(folder.path + "/elsewhere/board.yaml")}};
  ASSERT_TRUE(job_folder({.path = folder.path}, "a.yaml"));
  ASSERT_TRUE(write_job(r, folder.path));
  const std::string mine = sha256_hex("mine");
  EXPECT_EQ(sha256_of_file(folder.path + "/" + images[0]), mine);
  EXPECT_EQ(sha256_of_file(folder.path + "/inputs/board.yaml"), mine);
  EXPECT_EQ(sha256_of_file(folder.path + "/inputs/2-board.yaml"), r.sources[0].sha256);
  ASSERT_EQ(r.not_kept.size(), 1u);
  EXPECT_EQ(r.not_kept[0].file, images[0]);
  ASSERT_TRUE(job_folder({.path = folder.path, .overwrite = true}, "a.yaml"));
  EXPECT_TRUE(fs::exists(folder.path + "/" + images[0])) << "the summary does not name it";
  EXPECT_TRUE(fs::exists(folder.path + "/inputs/board.yaml"));
  EXPECT_FALSE(fs::exists(folder.path + "/inputs/2-board.yaml"));
}

TEST(JobFolder, without_force_nothing_goes_whatever_it_is_called) {
  const Folder folder;
  put(folder.path + "/inputs");
  fs::create_directories(folder.path + "/marks");
  ASSERT_TRUE(job_folder({.path = folder.path}, "a.yaml"));
  EXPECT_TRUE(fs::exists(folder.path + "/inputs"));
  EXPECT_TRUE(fs::exists(folder.path + "/marks"));
}

TEST(JobFolder, a_job_made_of_what_another_has_kept_takes_that_not_away) {
  const Folder folder;
  put(folder.path + "/elsewhere/board.yaml", "recipe: a\n");
  JobResult r = made_up_job();
  r.sources = {{folder.path + "/elsewhere/board.yaml", 10, sha256_of_file(folder.path + "/elsewhere/board.yaml")}};
  ASSERT_TRUE(write_job(r, folder.path));
  const std::string kept = folder.path + "/inputs/board.yaml";
  r.sources[0].file = kept;
  ASSERT_TRUE(job_folder({.path = folder.path, .overwrite = true, .made_of = {kept}}, kept));
  EXPECT_TRUE(fs::exists(kept));
  ASSERT_TRUE(write_job(r, folder.path));
  EXPECT_TRUE(r.not_kept.empty());
  EXPECT_EQ(sha256_of_file(kept), r.sources[0].sha256);
  EXPECT_FALSE(fs::exists(folder.path + "/inputs/2-board.yaml"));
}

TEST(JobFolder, two_that_begin_at_once_have_two_numbers_and_the_higher_is_kept) {
  const Folder folder;
  const WantedFolder wanted{.under = folder.path};
  std::vector<std::string> made(40);
  std::vector<std::thread> threads;
  for (std::size_t t = 0; t < 4; ++t)
    threads.emplace_back([&, t] {
      for (std::size_t i = t; i < made.size(); i += 4) made[i] = path_of(job_folder(wanted, "a.yaml"));
    });
  for (std::thread& each : threads) each.join();
  std::sort(made.begin(), made.end());
  EXPECT_EQ(std::unique(made.begin(), made.end()), made.end());
  fs::remove_all(made.back());
  EXPECT_EQ(path_of(job_folder(wanted, "a.yaml")), folder.path + "/a-041");
}

TEST(JobFolder, a_folder_that_is_called_by_a_date_numbers_no_jobs) {
  const Folder folder;
  put(folder.path + "/a-20261121/notes.txt");
  fs::create_directories(folder.path + "/a-001");
  put(folder.path + "/a-007/summary.json", "{}");
  EXPECT_EQ(path_of(job_folder({.under = folder.path}, "a.yaml")), folder.path + "/a-008");
}

TEST(JobFolder, numbers_go_on_beyond_a_hundred_thousand) {
  const Folder folder;
  put(folder.path + "/.a.last-number", "100000\n");
  EXPECT_EQ(path_of(job_folder({.under = folder.path}, "a.yaml")), folder.path + "/a-100001");
}

TEST(JobFolder, a_number_is_not_used_twice) {
  const Folder folder;
  const WantedFolder wanted{.under = folder.path};
  for (const char* name : {"a-001", "a-002"})
    EXPECT_EQ(path_of(job_folder(wanted, "a.yaml")), folder.path + "/" + name);
  fs::remove_all(folder.path + "/a-002");
  EXPECT_EQ(path_of(job_folder(wanted, "a.yaml")), folder.path + "/a-003");
  EXPECT_EQ(path_of(job_folder(wanted, "b.yaml")), folder.path + "/b-001");
  put(folder.path + "/.a.last-number", "no number");
  EXPECT_EQ(path_of(job_folder(wanted, "a.yaml")), folder.path + "/a-004");
}

// Anybody may make one in a folder that all may write to.
TEST(JobFolder, a_pipe_in_place_of_the_number_holds_nobody_up_and_is_replaced) {
  const Folder folder;
  const std::string number = folder.path + "/.a.last-number";
  ASSERT_EQ(::mkfifo(number.c_str(), 0600), 0);
  EXPECT_EQ(path_of(job_folder({.under = folder.path}, "a.yaml")), folder.path + "/a-001");
  EXPECT_EQ(path_of(job_folder({.under = folder.path}, "a.yaml")), folder.path + "/a-002");
}

TEST(KeptRoom, becomes_a_file_of_its_own_whatever_else_fills_the_disk) {
  const Folder folder;
  const bool small = ::mount("none", folder.path.c_str(), "tmpfs", 0, "size=2m") == 0;
  if (!small && ::geteuid() != 0) GTEST_SKIP() << "a small disk needs root";
  ASSERT_TRUE(small);
  const std::string path = folder.path + "/summary.json", text(900'000, 'x');
  for (const std::size_t kept_bytes : {1'000'000, 800'000}) {
    auto kept = KeptRoom::keep(folder.path, kept_bytes);
    EXPECT_TRUE(kept);
    std::ofstream(folder.path + "/full") << std::string(4'000'000, '.');
    EXPECT_EQ(kept && kept->become(path, text).has_value(), kept_bytes >= text.size());
    std::ifstream file(path);
    const std::string found(std::istreambuf_iterator<char>(file), {});
    EXPECT_EQ(found, kept_bytes >= text.size() ? text : "") << "whole or not at all";
    EXPECT_FALSE(fs::exists(path + ".part"));
    fs::remove(folder.path + "/full");
    fs::remove(path);
  }
  EXPECT_TRUE(KeptRoom().become(path, text));
  EXPECT_EQ(fs::file_size(path), text.size());
  ::umount(folder.path.c_str());
}

TEST(KeptRoom, takes_the_place_of_a_file_and_of_nothing_else) {
  const Folder folder;
  const std::string path = folder.path + "/summary.json";
  const auto become = [&] {
    auto kept = KeptRoom::keep(folder.path, 1000);
    return kept && kept->become(path, "new").has_value();
  };
  put(path, "old");
  EXPECT_TRUE(become());
  EXPECT_EQ(fs::file_size(path), 3u);
  fs::remove(path);
  ASSERT_EQ(::mkfifo(path.c_str(), 0600), 0);
  EXPECT_FALSE(become());
  EXPECT_TRUE(fs::is_fifo(path)) << "it is somebody's on purpose";
}

TEST(KeptRoom, is_taken_from_the_disk_until_it_is_given_back) {
  const Folder folder;
  const auto free = [&] {
    struct statvfs disk {};
    statvfs(folder.path.c_str(), &disk);
    return static_cast<double>(disk.f_bfree) * static_cast<double>(disk.f_frsize);
  };
  const double before = free();
  auto kept = KeptRoom::keep(folder.path, 64'000'000);
  ASSERT_TRUE(kept) << to_text(kept.error());
  EXPECT_NEAR(before - free(), 64e6, 20e6) << "other programs use this disk, too";
  EXPECT_TRUE(fs::is_empty(folder.path)) << "it has no name";
  kept->give();
  EXPECT_NEAR(before - free(), 0, 20e6);
}

}  // namespace
}  // namespace gantry::record
