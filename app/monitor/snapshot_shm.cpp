#include "app/monitor/snapshot_shm.hpp"

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <csignal>
#include <cstring>
#include <ctime>
#include <fcntl.h>
#include <fmt/format.h>
#include <new>
#include <sys/mman.h>
#include <sys/random.h>
#include <sys/stat.h>
#include <unistd.h>
#include <utility>

namespace gantry::monitor {

inline constexpr std::size_t kSnapshots = 256;  // a quarter of a second at 1 ms
inline constexpr std::size_t kEvents = 1024;
inline constexpr std::uint64_t kMagic = 0x314d4853'59544e47u;  // "GNTYSHM1"

struct SharedMemory {
  std::atomic<std::uint64_t> magic{0};  // set last: before it nothing here is true
  std::uint64_t layout = sizeof(SharedMemory);
  std::uint64_t session = 0;
  std::int64_t owner_pid = 0;
  std::atomic<std::int64_t> heartbeat_ns{0};  // CLOCK_MONOTONIC, the same for all processes
  std::atomic<std::uint32_t> closed{0};
  MachineInfo info;
  rt::Latest<SharedJob> job;
  rt::Latest<SharedAlarms> alarms;
  LossyRing<SharedEvent, kEvents> events;
  LossyRing<SharedSnapshot, kSnapshots> snapshots;
};
static_assert(std::atomic<std::uint64_t>::is_always_lock_free, "a lock cannot be shared with a process that may die");

namespace {

std::int64_t now_ns(clockid_t clock) {
  timespec t{};
  clock_gettime(clock, &t);
  return static_cast<std::int64_t>(t.tv_sec) * 1'000'000'000 + t.tv_nsec;
}

std::string why() { return std::strerror(errno); }

}  // namespace

double age_s(const SharedSnapshot& shared) {
  return static_cast<double>(now_ns(CLOCK_MONOTONIC) - shared.monotonic_ns) * 1e-9;
}

MachineInfo machine_info(const config::Machine& machine) {
  MachineInfo info;
  info.name = machine.name;
  for (const auto& axis : machine.axes) {
    if (info.axes == kMaxAxes) break;
    info.axis[info.axes++] = {std::string_view(axis.name), axis.rotary};
  }
  for (std::size_t i = 0; i < config::kOutputs; ++i) info.output[i] = config::name(static_cast<config::Output>(i));
  for (std::size_t i = 0; i < config::kInputs; ++i) info.input[i] = config::name(static_cast<config::Input>(i));
  for (const config::WordBit& free : config::output_bits(machine))
    if (free.bit < info.output.size()) info.output[free.bit] = free.name;
  for (const config::WordBit& free : config::input_bits(machine))
    if (free.bit < info.input.size()) info.input[free.bit] = free.name;
  return info;
}

Result<SnapshotWriter> SnapshotWriter::create(const MachineInfo& info) {
  const int fd = memfd_create("gantry-snapshots", MFD_CLOEXEC | MFD_ALLOW_SEALING);
  if (fd < 0) return fail(Fault::Internal, "no shared memory for the monitor: " + why());
  void* at = MAP_FAILED;
  if (ftruncate(fd, sizeof(SharedMemory)) == 0)
    at = mmap(nullptr, sizeof(SharedMemory), PROT_READ | PROT_WRITE, MAP_SHARED | MAP_POPULATE, fd, 0);
  // Sealed: a reader that shortens the memory would kill the owner with SIGBUS, and one that writes would lie to
  // others. The mapping above stays writable (F_SEAL_FUTURE_WRITE, Linux 5.1).
  constexpr int kSeals = F_SEAL_SHRINK | F_SEAL_GROW | F_SEAL_FUTURE_WRITE | F_SEAL_SEAL;
  if (at != MAP_FAILED && fcntl(fd, F_ADD_SEALS, kSeals) != 0) {
    const int reason = errno;
    munmap(at, sizeof(SharedMemory));
    errno = reason;
    at = MAP_FAILED;
  }
  if (at == MAP_FAILED) {
    const auto reason = why();
    close(fd);
    return fail(Fault::Internal, "no shared memory for the monitor: " + reason);
  }
  auto* memory = new (at) SharedMemory;
  memory->info = info;
  memory->owner_pid = getpid();
  if (getrandom(&memory->session, sizeof memory->session, GRND_NONBLOCK) != sizeof memory->session)
    memory->session = static_cast<std::uint64_t>(now_ns(CLOCK_REALTIME)) ^ static_cast<std::uint64_t>(getpid()) << 48;
  SnapshotWriter writer(fd, memory);
  writer.beat();
  memory->magic.store(kMagic, std::memory_order_release);
  return writer;
}

SnapshotWriter::SnapshotWriter(SnapshotWriter&& other) noexcept
    : fd_(std::exchange(other.fd_, -1)), memory_(std::exchange(other.memory_, nullptr)), alarms_(other.alarms_) {}

SnapshotWriter::~SnapshotWriter() {
  if (memory_ == nullptr) return;
  memory_->closed.store(1, std::memory_order_release);
  munmap(memory_, sizeof(SharedMemory));
  close(fd_);
}

void SnapshotWriter::beat() noexcept {
  memory_->heartbeat_ns.store(now_ns(CLOCK_MONOTONIC), std::memory_order_relaxed);
}

void SnapshotWriter::push(const cycle::Snapshot& snapshot) noexcept {
  const auto now = now_ns(CLOCK_MONOTONIC);
  memory_->snapshots.push({snapshot, now_ns(CLOCK_REALTIME), now});
  memory_->heartbeat_ns.store(now, std::memory_order_relaxed);
}

void SnapshotWriter::push(const cycle::Event& event, std::string_view text, std::uint32_t count) noexcept {
  memory_->events.push({event, now_ns(CLOCK_REALTIME), Told::Machine, count, text});
  beat();
}

void SnapshotWriter::push(Told told, CycleIndex cycle, std::string_view text) noexcept {
  cycle::Event event;
  event.cycle = cycle;
  memory_->events.push({event, now_ns(CLOCK_REALTIME), told, 1, text});
  beat();
}

void SnapshotWriter::push(const SharedJob& job) noexcept {
  memory_->job.store(job);
  beat();
}

void SnapshotWriter::alarms(std::span<const Error> active) noexcept {
  SharedAlarms now;
  const auto of = [](const SharedAlarms& list, Fault fault) -> const SharedAlarm* {
    const auto end = list.alarms.begin() + list.count;
    const auto found = std::find_if(list.alarms.begin(), end, [&](const SharedAlarm& a) { return a.fault == fault; });
    return found == end ? nullptr : &*found;
  };
  for (const Error& e : active) {
    if (now.count == SharedAlarms::kMost) break;
    if (of(now, e.fault) != nullptr) continue;
    const SharedAlarm* before = of(alarms_, e.fault);
    now.alarms[now.count++] = {e.fault, before != nullptr ? before->since_ns : now_ns(CLOCK_REALTIME),
                               std::string_view(e.where), std::string_view(e.message)};
  }
  const auto same = [](const SharedAlarm& a, const SharedAlarm& b) {
    return a.fault == b.fault && a.where.view() == b.where.view() && a.text.view() == b.text.view();
  };
  const bool changed = !std::equal(now.alarms.begin(), now.alarms.begin() + now.count, alarms_.alarms.begin(),
                                   alarms_.alarms.begin() + alarms_.count, same);
  if (!changed && alarms_.version != 0) return;
  now.version = alarms_.version + 1;
  alarms_ = now;
  memory_->alarms.store(now);
  beat();
}

std::uint64_t SnapshotWriter::session() const noexcept { return memory_->session; }

Result<SnapshotReader> SnapshotReader::open(int fd) {
  struct stat status {};
  const bool fits = fstat(fd, &status) == 0 && S_ISREG(status.st_mode) && status.st_size == sizeof(SharedMemory);
  void* at = fits ? mmap(nullptr, sizeof(SharedMemory), PROT_READ, MAP_SHARED, fd, 0) : MAP_FAILED;
  const auto* memory = static_cast<const SharedMemory*>(at);
  if (at != MAP_FAILED && memory->magic.load(std::memory_order_acquire) == kMagic &&
      memory->layout == sizeof(SharedMemory))
    return SnapshotReader(memory);
  if (at != MAP_FAILED) munmap(at, sizeof(SharedMemory));
  return fail(Fault::Inconsistent,
              fmt::format("file descriptor {} is not the memory of a running machine of this version of the program; "
                          "`gantry up` and `gantry run` start the publisher by themselves",
                          fd),
              "--shm");
}

SnapshotReader::SnapshotReader(const SharedMemory* memory)
    : memory_(memory), snapshots_(memory->snapshots.oldest()), events_(memory->events.oldest()) {}

SnapshotReader::SnapshotReader(SnapshotReader&& other) noexcept
    : memory_(std::exchange(other.memory_, nullptr)), snapshots_(other.snapshots_), events_(other.events_) {}

SnapshotReader::~SnapshotReader() {
  if (memory_ != nullptr) munmap(const_cast<SharedMemory*>(memory_), sizeof(SharedMemory));
}

const MachineInfo& SnapshotReader::info() const noexcept { return memory_->info; }
std::uint64_t SnapshotReader::session() const noexcept { return memory_->session; }
bool SnapshotReader::newest(SharedSnapshot& s) const noexcept { return memory_->snapshots.newest(s); }
bool SnapshotReader::next(SharedSnapshot& s) noexcept { return memory_->snapshots.next(snapshots_, s); }
bool SnapshotReader::job(SharedJob& job) const noexcept { return memory_->job.load(job); }
bool SnapshotReader::alarms(SharedAlarms& alarms) const noexcept { return memory_->alarms.load(alarms); }

bool SnapshotReader::next(SharedEvent& event, std::uint64_t& number) noexcept {
  if (!memory_->events.next(events_, event)) return false;
  number = events_.position - 1;
  return true;
}

bool SnapshotReader::writer_gone() const noexcept {
  if (memory_->closed.load(std::memory_order_acquire) != 0) return true;
  return kill(static_cast<pid_t>(memory_->owner_pid), 0) != 0 && errno == ESRCH;
}

double SnapshotReader::silence_s() const noexcept {
  const auto heard = memory_->heartbeat_ns.load(std::memory_order_relaxed);
  return static_cast<double>(now_ns(CLOCK_MONOTONIC) - heard) * 1e-9;
}

}  // namespace gantry::monitor
