// What is kept of stations and axes between starts: what is written comes back, what is broken takes nothing.
#include <filesystem>
#include <fstream>
#include <gtest/gtest.h>
#include <unistd.h>

#include "app/stations/accepted.hpp"
#include "app/stations/measured.hpp"
#include "core/units.hpp"

namespace gantry::stations {
namespace {

namespace fs = std::filesystem;

struct KeptFiles : testing::Test {
  fs::path folder = fs::path(testing::TempDir()) / ("gantry_kept_" + std::to_string(::getpid()));
  KeptFiles() { fs::create_directories(folder); }
  ~KeptFiles() override { fs::remove_all(folder); }
  KeptFiles(const KeptFiles&) = delete;
  KeptFiles& operator=(const KeptFiles&) = delete;

  [[nodiscard]] std::string state() const { return folder.string(); }
  static void write(const std::string& file, const std::string& text) { std::ofstream(file) << text; }
  static std::string text_of(const std::string& file) {
    std::ifstream in(file);
    return {std::istreambuf_iterator<char>(in), {}};
  }
};

config::Machine machine(std::initializer_list<const char*> names) {
  config::Machine m;
  for (const char* name : names) m.stations.emplace_back().name = name, m.axes.emplace_back().name = name;
  return m;
}

TEST_F(KeptFiles, what_was_accepted_comes_back) {
  auto was = machine({"x", "z", "io"});
  was.stations[0].accepted = config::Accepted{.vendor = 0x4321,
                                              .product = 0x8100'0530,
                                              .revision = 3,
                                              .serial = 0xFFFF'FFFF,
                                              .date = "2026-11-22",
                                              .compared = true,
                                              .walked = "2026-11-23",
                                              .walked_as = "X+ 5 mm",
                                              .object = {.vendor = 7, .product = 8}};
  was.stations[1].restart_pending = true;
  const std::string file = accepted_file(state(), "ethercat:enp3s0");
  ASSERT_TRUE(write_accepted(file, was));
  auto now = machine({"x", "z", "io"});
  now.stations[2].restart_pending = true;  // says the one who asks; the file has no row of it
  ASSERT_TRUE(read_accepted(file, now));
  const config::Accepted &before = *was.stations[0].accepted, &after = now.stations[0].accepted.value();
  EXPECT_EQ(after.vendor, before.vendor);
  EXPECT_EQ(after.product, before.product);
  EXPECT_EQ(after.revision, before.revision);
  EXPECT_EQ(after.serial, before.serial);
  EXPECT_EQ(after.date, before.date);
  EXPECT_EQ(after.compared, before.compared);
  EXPECT_EQ(after.walked, before.walked);
  EXPECT_EQ(after.walked_as, before.walked_as);
  EXPECT_EQ(after.object.vendor, 7u);
  EXPECT_EQ(after.object.product, 8u);
  EXPECT_FALSE(now.stations[0].restart_pending);
  EXPECT_TRUE(now.stations[1].restart_pending);
  EXPECT_FALSE(now.stations[1].accepted) << "that it waits for its supply accepts nothing";
}

TEST_F(KeptFiles, a_station_that_the_machine_has_no_more_goes_with_the_next_writing) {
  auto was = machine({"x", "old"});
  was.stations[0].restart_pending = was.stations[1].restart_pending = true;
  const std::string file = accepted_file(state(), "sim");
  ASSERT_TRUE(write_accepted(file, was));
  auto now = machine({"x"});
  ASSERT_TRUE(read_accepted(file, now));
  ASSERT_TRUE(write_accepted(file, now));
  EXPECT_EQ(text_of(file).find("old"), std::string::npos);
  EXPECT_NE(text_of(file).find("\"x\""), std::string::npos);
}

TEST_F(KeptFiles, what_virtual_drives_are_says_nothing_of_those_of_steel) {
  EXPECT_NE(accepted_file(state(), "sim"), accepted_file(state(), "ethercat:enp3s0"));
  EXPECT_EQ(accepted_file(state(), "ethercat:enp3s0"), accepted_file(state(), "ethercat:eth0"))
      << "the same stations on another port";
  EXPECT_NE(accepted_file(state(), "sim"), measured_file(state(), "sim"));
}

TEST_F(KeptFiles, a_file_that_is_not_there_accepts_and_measures_nothing) {
  auto m = machine({"x"});
  EXPECT_TRUE(read_accepted(accepted_file(state(), "sim"), m));
  EXPECT_TRUE(read_measured(measured_file(state(), "sim"), m));
  EXPECT_FALSE(m.stations[0].accepted);
  EXPECT_FALSE(m.axes[0].measured);
}

// A row that was written before 1018h was kept, and before "compared" was a word of its own.
TEST_F(KeptFiles, an_older_row_is_read) {
  const std::string file = accepted_file(state(), "sim");
  write(file, R"({"format": 1, "stations": {"x": {"vendor": 1, "product": 2, "revision": 3, "serial": 4,
                  "date": "2026-11-01", "restart_pending": false}}})");
  auto m = machine({"x"});
  ASSERT_TRUE(read_accepted(file, m));
  ASSERT_TRUE(m.stations[0].accepted);
  EXPECT_TRUE(m.stations[0].accepted->compared) << "without a walk somebody had compared it";
  EXPECT_EQ(m.stations[0].accepted->object.vendor, 0u);
}

TEST_F(KeptFiles, a_broken_file_is_an_error_with_its_name_and_a_remedy_and_takes_nothing) {
  const std::string good = R"({"format": 1, "stations": {"x": {"vendor": 1, "product": 2, "revision": 3, "serial": 4,
      "date": "d", "restart_pending": false}}})";
  const auto changed = [&](const std::string& from, const std::string& to) {
    std::string text = good;
    return text.replace(text.find(from), from.size(), to);
  };
  const std::string file = accepted_file(state(), "sim");
  write(file, good);
  auto whole = machine({"x"});
  ASSERT_TRUE(read_accepted(file, whole)) << "or the rest of this test shows nothing";
  for (const std::string& text :
       {std::string(), good.substr(0, good.size() / 2), std::string("[]"), std::string("\0\0\0\0", 4),
        changed("\"format\": 1", "\"format\": 2"), changed("\"format\": 1", "\"format\": \"1\""),
        changed("\"stations\"", "\"statons\""), changed("\"serial\": 4,", ""),
        changed("\"vendor\": 1", "\"vendor\": {}"), changed("false", "\"no\""), std::string(100'000, '[')}) {
    write(file, text);
    auto m = machine({"x"});
    const auto read = read_accepted(file, m);
    ASSERT_FALSE(read) << text.substr(0, 200);
    EXPECT_EQ(read.error().fault, Fault::BadValue);
    EXPECT_EQ(read.error().where, file);
    EXPECT_NE(read.error().message.find("gantry commission --all --accept"), std::string::npos) << read.error().message;
    EXPECT_LT(read.error().message.size(), 500u);
    EXPECT_FALSE(m.stations[0].accepted) << text.substr(0, 200);
  }
}

TEST_F(KeptFiles, where_nothing_can_be_written_the_error_names_the_file) {
  const std::string file = accepted_file(state() + "/none", "sim");
  const auto wrote = write_accepted(file, machine({"x"}));
  ASSERT_FALSE(wrote);
  EXPECT_EQ(wrote.error().fault, Fault::FileUnwritable);
  EXPECT_NE((wrote.error().where + wrote.error().message).find(file), std::string::npos);
}

TEST_F(KeptFiles, what_was_measured_comes_back) {
  auto was = machine({"X", "Y"});
  was.axes[1].measured = config::MeasuredDelay{.delay_s = 3.02e-3, .within_s = 2e-5, .speed = 50, .date = "2026-11-23"};
  const std::string file = measured_file(state(), "sim");
  ASSERT_TRUE(write_measured(file, was));
  auto now = machine({"X", "Y"});
  ASSERT_TRUE(read_measured(file, now));
  EXPECT_FALSE(now.axes[0].measured);
  ASSERT_TRUE(now.axes[1].measured);
  EXPECT_EQ(now.axes[1].measured->delay_s, 3.02e-3) << "to the last digit";
  EXPECT_EQ(now.axes[1].measured->within_s, 2e-5);
  EXPECT_EQ(now.axes[1].measured->speed, 50);
  EXPECT_EQ(now.axes[1].measured->date, "2026-11-23");
}

TEST(MeasuredInWords, says_what_to_state_where_it_differs) {
  config::Axis axis;
  axis.name = "X", axis.response_delay_s = 3e-3;
  axis.measured = config::MeasuredDelay{.delay_s = 3.02e-3, .within_s = 2e-5, .speed = 50, .date = "2026-11-23"};
  const std::string agrees = measured_in_words(axis);
  EXPECT_NE(agrees.find("3 ms is stated, 3.02 ms were found (within 0.02 ms, at 50 mm/s, 2026-11-23)"),
            std::string::npos)
      << agrees;
  EXPECT_EQ(agrees.find("state `"), std::string::npos) << agrees;
  axis.measured->delay_s = 4.1e-3;
  EXPECT_NE(measured_in_words(axis).find("state `response_delay: 4.10 ms`"), std::string::npos)
      << measured_in_words(axis);
  axis.rotary = true, axis.measured->speed = units::rad(90);
  EXPECT_NE(measured_in_words(axis).find("at 90 deg/s"), std::string::npos) << measured_in_words(axis);
}

}  // namespace
}  // namespace gantry::stations
