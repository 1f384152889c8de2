#include "sim/world/world_log.hpp"

#include <cstring>
#include <filesystem>
#include <fstream>
#include <gtest/gtest.h>

#include "tests/sim/world/sample.hpp"

namespace gantry::sim {
namespace {

std::span<const std::byte> bytes(std::string_view text) { return std::as_bytes(std::span(text)); }
std::string text(std::span<const std::byte> b) { return {reinterpret_cast<const char*>(b.data()), b.size()}; }

class WithLog : public testing::Test {
 protected:
  WithLog() : dir(sample::temporary("gantry-world-log-test")) { std::filesystem::remove_all(dir); }
  ~WithLog() override { std::filesystem::remove_all(dir); }
  std::vector<std::string> read() {
    auto log = WorldLog::open(dir);
    EXPECT_TRUE(log);
    std::vector<std::string> out;
    for (const auto& r : (*log)->records()) out.push_back(text(r.payload));
    return out;
  }
  std::string dir;
};

TEST(Crc32, of_the_check_string_is_the_published_one) {
  EXPECT_EQ(crc32(bytes("123456789")), 0xCBF43926u);  // check value of CRC-32/ISO-HDLC
  EXPECT_EQ(crc32(bytes("6789"), crc32(bytes("12345"))), 0xCBF43926u);
}

TEST_F(WithLog, gives_back_what_was_appended) {
  {
    auto log = WorldLog::open(dir);
    ASSERT_TRUE(log);
    EXPECT_TRUE((*log)->append(WorldLog::Kind::Board, bytes("first")));
    EXPECT_TRUE((*log)->append(WorldLog::Kind::JobBegin, {}));
    EXPECT_TRUE((*log)->append(WorldLog::Kind::Motors, bytes("third record")));
  }
  EXPECT_EQ(read(), (std::vector<std::string>{"first", "", "third record"}));
  EXPECT_LT(std::filesystem::file_size(dir + "/world.log"), 200u) << "the room is given back";
}

TEST_F(WithLog, a_tail_torn_at_any_byte_is_cut_and_the_rest_stays) {
  {
    auto log = WorldLog::open(dir);
    (*log)->append(WorldLog::Kind::Board, bytes("one"));
    (*log)->append(WorldLog::Kind::Motors, bytes("the last record"));
  }
  const auto path = dir + "/world.log";
  const auto whole = std::filesystem::file_size(path);
  std::ifstream in(path, std::ios::binary);
  const std::string good((std::istreambuf_iterator<char>(in)), {});
  for (std::size_t size = 24; size < whole; ++size) {
    std::ofstream(path, std::ios::binary | std::ios::trunc) << good.substr(0, size);
    const auto records = read();
    ASSERT_GE(records.size(), 1u) << size;
    EXPECT_EQ(records[0], "one");
    EXPECT_EQ(records.size(), size < 24 + 16 + 15 ? 1u : 2u) << size;
    auto log = WorldLog::open(dir);
    (*log)->append(WorldLog::Kind::Motors, bytes("new"));
    log->reset();
    EXPECT_EQ(read().back(), "new");
  }
  // A flipped bit in the last record drops that record.
  for (std::size_t at = 24; at < 24 + 16 + 15; ++at) {
    std::string bad = good;
    bad[at] = static_cast<char>(bad[at] ^ 4);
    std::ofstream(path, std::ios::binary | std::ios::trunc) << bad;
    EXPECT_EQ(read().size(), 1u) << at;
  }
}

TEST_F(WithLog, damage_in_the_middle_is_kept_beside_and_a_file_that_is_no_log_is_left_alone) {
  {
    auto log = WorldLog::open(dir);
    for (const char* record : {"one", "two", "three"}) (*log)->append(WorldLog::Kind::Board, bytes(record));
  }
  const auto path = dir + "/world.log";
  const auto content = [](const std::string& file) {
    std::ifstream in(file, std::ios::binary);
    return std::string((std::istreambuf_iterator<char>(in)), {});
  };
  std::string bad = content(path);
  bad[24 + 16] = 'X';  // in the second record
  std::ofstream(path, std::ios::binary | std::ios::trunc) << bad;
  EXPECT_EQ(read(), std::vector<std::string>{"one"});
  EXPECT_NE(content(path + ".cut").find("three"), std::string::npos) << "what could not be read may be looked at";

  const std::string other = "a letter to my aunt";
  std::ofstream(path, std::ios::binary | std::ios::trunc) << other;
  const auto opened = WorldLog::open(dir);
  ASSERT_FALSE(opened);
  EXPECT_EQ(opened.error().fault, Fault::FileUnreadable);
  EXPECT_EQ(content(path).substr(0, other.size()), other);
}

}  // namespace
}  // namespace gantry::sim
