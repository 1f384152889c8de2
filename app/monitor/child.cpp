#include "app/monitor/child.hpp"

#include <algorithm>
#include <array>
#include <cerrno>
#include <csignal>
#include <cstring>
#include <fcntl.h>
#include <sched.h>
#include <spawn.h>
#include <sys/wait.h>
#include <thread>
#include <unistd.h>

#include "core/log.hpp"

extern char** environ;

namespace gantry::monitor {
namespace {

constexpr int kChildFd = 3;
constexpr auto kStable = std::chrono::seconds(30);  // a child that lived this long has earned a quick restart

/// What posix_spawn needs, freed with it.
struct Spawn {
  posix_spawn_file_actions_t files{};
  posix_spawnattr_t attributes{};
  Spawn() {
    posix_spawn_file_actions_init(&files);
    posix_spawnattr_init(&attributes);
  }
  Spawn(const Spawn&) = delete;
  Spawn& operator=(const Spawn&) = delete;
  ~Spawn() {
    posix_spawn_file_actions_destroy(&files);
    posix_spawnattr_destroy(&attributes);
  }
};

/// Of the owner's environment the child gets what DDS, the loader and sanitizers read, and nothing else.
std::vector<char*> its_environment() {
  constexpr std::array kPassed{
      "CYCLONEDDS_URI=", "CYCLONEDDS_HOME=", "LD_LIBRARY_PATH=", "PATH=", "LANG=", "LC_ALL=", "TZ=",
      "ASAN_OPTIONS=",   "UBSAN_OPTIONS=",   "TSAN_OPTIONS="};
  std::vector<char*> kept;
  for (char** each = environ; *each != nullptr; ++each)
    if (std::any_of(kPassed.begin(), kPassed.end(),
                    [&](const char* name) { return std::string_view(*each).starts_with(name); }))
      kept.push_back(*each);
  kept.push_back(nullptr);
  return kept;
}

/// The child has the shared memory and stderr, and neither the owner's bus nor its stdout, which may carry JSON.
void give_files(Spawn& spawn, int shm_fd) {
  posix_spawn_file_actions_adddup2(&spawn.files, shm_fd, kChildFd);  // also takes its close-on-exec away
  posix_spawn_file_actions_addopen(&spawn.files, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
  posix_spawn_file_actions_addopen(&spawn.files, STDOUT_FILENO, "/dev/null", O_WRONLY, 0);
  posix_spawn_file_actions_addclosefrom_np(&spawn.files, kChildFd + 1);
}

/// A group of its own (Ctrl-C is the owner's, who ends the child when it has told the end), plain scheduling whatever
/// the thread that starts it has, and no signal blocked or ignored.
void give_manners(Spawn& spawn) {
  sigset_t none, all;
  sigemptyset(&none);
  sigfillset(&all);
  const sched_param plain{};
  posix_spawnattr_setpgroup(&spawn.attributes, 0);
  posix_spawnattr_setsigmask(&spawn.attributes, &none);
  posix_spawnattr_setsigdefault(&spawn.attributes, &all);
  posix_spawnattr_setschedpolicy(&spawn.attributes, SCHED_OTHER);
  posix_spawnattr_setschedparam(&spawn.attributes, &plain);
  posix_spawnattr_setflags(&spawn.attributes, POSIX_SPAWN_SETPGROUP | POSIX_SPAWN_SETSIGMASK | POSIX_SPAWN_SETSIGDEF |
                                                  POSIX_SPAWN_SETSCHEDULER);
}

}  // namespace

PublishChild::PublishChild(int shm_fd, ChildOptions options)
    : shm_fd_(shm_fd), options_(std::move(options)), back_off_(options_.back_off_first) {}

PublishChild::~PublishChild() {
  if (pid_ <= 0 || reap()) return;
  kill(pid_, SIGTERM);
  for (int i = 0; i < 50; ++i) {
    if (waitpid(pid_, nullptr, WNOHANG) != 0) return;
    std::this_thread::sleep_for(milliseconds(10));
  }
  kill(pid_, SIGKILL);
  waitpid(pid_, nullptr, 0);
}

void PublishChild::poll(Time now) {
  if (pid_ > 0 && reap()) {
    if (now - started_ >= kStable) back_off_ = options_.back_off_first;
    next_start_ = now + back_off_;
    back_off_ = std::min(2 * back_off_, options_.back_off_most);
  }
  if (pid_ > 0 || now < next_start_) return;
  started_ = now;
  start();
  if (pid_ <= 0) {
    next_start_ = now + back_off_;
    back_off_ = std::min(2 * back_off_, options_.back_off_most);
  }
}

bool PublishChild::reap() {
  int status = 0;
  const pid_t ended = waitpid(pid_, &status, WNOHANG);
  if (ended == 0 || (ended < 0 && errno == EINTR)) return false;
  if (ended == pid_ && WIFSIGNALED(status))
    log::warn("the publisher (process {}) was ended by signal {}; the machine runs on", pid_, WTERMSIG(status));
  else if (ended == pid_ && WEXITSTATUS(status) != 0)
    log::warn("the publisher (process {}) ended with code {}; the machine runs on", pid_, WEXITSTATUS(status));
  pid_ = -1;
  return true;
}

void PublishChild::start() {
  std::vector<std::string> words{"gantry", "publish", "--shm", std::to_string(kChildFd)};
  words.insert(words.end(), options_.arguments.begin(), options_.arguments.end());
  std::vector<char*> argv;
  for (auto& w : words) argv.push_back(w.data());
  argv.push_back(nullptr);

  Spawn spawn;
  give_files(spawn, shm_fd_);
  give_manners(spawn);
  pid_t pid = -1;
  std::vector<char*> env = its_environment();
  const int code =
      posix_spawn(&pid, options_.program.c_str(), &spawn.files, &spawn.attributes, argv.data(), env.data());
  ++starts_;
  if (code == 0)
    pid_ = pid;
  else if (starts_ == 1)
    log::warn("the publisher cannot be started ({}); nothing is told over DDS", std::strerror(code));
}

}  // namespace gantry::monitor
