// A world that listens and says nothing: nobody waits for it for longer than he wants.
#include <chrono>
#include <filesystem>
#include <gtest/gtest.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <thread>
#include <unistd.h>

#include "sim/machine/world_client.hpp"

namespace gantry::sim {
namespace {

using Clock = std::chrono::steady_clock;
using std::chrono::milliseconds;

/// Takes connections into its queue, reads nothing and answers nothing.
class SilentWorld {
 public:
  explicit SilentWorld(int queue)
      : path_(std::filesystem::temp_directory_path() / ("silent-" + std::to_string(getpid()))) {
    std::filesystem::remove(path_);
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    path_.string().copy(address.sun_path, sizeof address.sun_path - 1);
    EXPECT_EQ(::bind(fd_, reinterpret_cast<const sockaddr*>(&address), sizeof address), 0);
    EXPECT_EQ(::listen(fd_, queue), 0);
  }
  ~SilentWorld() {
    ::close(fd_);
    std::filesystem::remove(path_);
  }
  [[nodiscard]] std::string path() const { return path_.string(); }

 private:
  std::filesystem::path path_;
  int fd_ = ::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0);
};

template <class Ask>
void expect_given_up(WorldAccess& world, const char* what, Ask ask) {
  const auto begin = Clock::now();
  std::thread gives_up([&] {
    std::this_thread::sleep_for(milliseconds(200));
    world.give_up();
  });
  const auto answer = ask();
  const auto took = Clock::now() - begin;
  gives_up.join();
  ASSERT_FALSE(answer) << what;
  EXPECT_EQ(answer.error().fault, Fault::WorldUnreachable) << what;
  EXPECT_GE(took, milliseconds(200)) << what;
  EXPECT_LT(took, milliseconds(5000)) << what << ": its patience is 10 s";
}

TEST(ASilentWorld, is_given_up_when_somebody_says_so_and_looked_for_again_by_the_next_job) {
  const SilentWorld silent(8);
  auto client = WorldClient::connect(silent.path());
  ASSERT_TRUE(client);
  WorldAccess& world = **client;
  expect_given_up(world, "a frame", [&] { return world.camera().fetch(0, {}); });
  const auto begin = Clock::now();
  EXPECT_FALSE(world.deposits()) << "until the next job";
  EXPECT_FALSE(world.begin_job());
  EXPECT_LT(Clock::now() - begin, milliseconds(1000));
  expect_given_up(world, "the next job", [&] { return world.holds_board({}); });
}

/// What is asked may be larger than what a socket takes that nobody reads.
TEST(ASilentWorld, is_given_up_in_the_middle_of_a_long_question) {
  const SilentWorld silent(8);
  auto client = WorldClient::connect(silent.path());
  ASSERT_TRUE(client);
  recipes::Recipe recipe;
  for (int i = 0; i < 50'000; ++i) {
    recipes::Dot dot;
    dot.id = "dots[" + std::to_string(i) + "]";
    recipe.features.emplace_back(dot);
  }
  expect_given_up(**client, "a board of 50000 dots", [&] { return (*client)->load_board(recipe); });
}

TEST(ASilentWorld, whose_queue_is_full_is_told_at_once) {
  const SilentWorld silent(0);
  std::vector<std::unique_ptr<WorldClient>> clients;
  const auto begin = Clock::now();
  for (int i = 0; i < 4; ++i)
    if (auto client = WorldClient::connect(silent.path())) clients.push_back(std::move(*client));
  EXPECT_LT(Clock::now() - begin, milliseconds(2000));
  EXPECT_LT(clients.size(), 4u);
  const auto none = WorldClient::connect(silent.path());
  ASSERT_FALSE(none);
  EXPECT_EQ(none.error().fault, Fault::WorldUnreachable);
}

}  // namespace
}  // namespace gantry::sim
