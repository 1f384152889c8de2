#include "app/record/setpoint_file.hpp"

#include <algorithm>
#include <array>
#include <cstring>
#include <fmt/format.h>
#include <fstream>
#include <iterator>
#include <tuple>
#include <vector>

#include "app/record/setpoint_hash.hpp"

namespace gantry::record {
namespace {

constexpr std::array<char, 8> kMagic{'G', 'S', 'E', 'T', 'P', '2', 0, 0};
constexpr std::size_t kHead = kMagic.size() + 8;

void put(std::string& out, std::uint32_t v) {
  for (int shift = 0; shift < 32; shift += 8) out.push_back(static_cast<char>((v >> shift) & 0xFFu));
}

std::uint32_t get(const char* at) {
  std::uint32_t v = 0;
  for (int i = 3; i >= 0; --i) v = (v << 8) | static_cast<unsigned char>(at[i]);
  return v;
}

struct Tick : SetpointTick {
  std::uint32_t attempt = 0;
  [[nodiscard]] auto key() const { return std::tuple(block, attempt, tick); }
};

struct Stream {
  std::uint32_t drives = 0;
  std::vector<Tick> ticks;  // by key
};

Result<Stream> read(const std::string& path) {
  constexpr std::size_t kMostTicks = 100'000'000;  // more than a day; a short file may claim any number
  std::ifstream in(path, std::ios::binary);
  if (!in) return fail(Fault::FileUnreadable, "the setpoint file cannot be opened", path);
  const std::string bytes(std::istreambuf_iterator<char>(in), {});
  if (bytes.size() < kHead || std::memcmp(bytes.data(), kMagic.data(), kMagic.size()) != 0)
    return fail(Fault::Inconsistent, "this is no setpoint file (its first bytes are not \"GSETP2\")", path);
  Stream s;
  s.drives = get(bytes.data() + kMagic.size());
  if (s.drives > cycle::kMaxDrives) return fail(Fault::Inconsistent, "the file names more drives than exist", path);
  // A block that starts again (after an abort) begins at tick 1 once more: number the attempts to keep them apart.
  std::uint32_t block = 0, tick = 0;
  std::vector<std::uint32_t> attempts;
  const char* wrong = nullptr;
  const bool is_stream = decode(std::string_view(bytes).substr(kHead), s.drives, [&](const SetpointTick& each) {
    if (each.block >= 1'000'000) wrong = "the file holds a block number that cannot be";
    if (s.ticks.size() == kMostTicks) wrong = "the file holds more ticks than a job has";
    if (wrong != nullptr) return false;
    if (attempts.size() <= each.block) attempts.resize(each.block + 1, 0);
    if (each.block != block || each.tick <= tick) ++attempts[each.block];
    block = each.block, tick = each.tick;
    s.ticks.push_back({each, attempts[each.block]});
    return true;
  });
  if (!is_stream) wrong = "the file is damaged: it holds a record that cannot be";
  if (wrong != nullptr) return fail(Fault::Inconsistent, wrong, path);
  std::stable_sort(s.ticks.begin(), s.ticks.end(), [](const Tick& a, const Tick& b) { return a.key() < b.key(); });
  return s;
}

std::optional<SetpointDifference> difference(const Tick& a, const Tick& b, std::uint32_t drives) {
  if (a.outputs != b.outputs)
    return SetpointDifference{a.block, a.tick, fmt::format("outputs: {:#x} and {:#x}", a.outputs, b.outputs)};
  for (std::uint32_t i = 0; i < drives; ++i)
    if (a.counts[i] != b.counts[i])
      return SetpointDifference{a.block, a.tick,
                                fmt::format("counts of drive {}: {} and {}", i, a.counts[i], b.counts[i])};
  return std::nullopt;
}

}  // namespace

void SetpointFile::begin(std::uint32_t drives) {
  drives_ = drives;
  encoder_.emplace(drives);
  bytes_.assign(kMagic.begin(), kMagic.end());
  put(bytes_, drives);
  put(bytes_, 0);
}

void SetpointFile::add(const cycle::Snapshot& s) {
  constexpr std::size_t kPiece = 64 * 1024;
  if (s.block == 0) return;
  if (!encoder_) begin(std::min<std::uint32_t>(s.drives, cycle::kMaxDrives));
  SetpointTick tick{.block = s.block, .tick = s.tick, .outputs = s.outputs & kProcessOutputs, .sent = s.sent};
  for (std::uint32_t i = 0; i < drives_; ++i) tick.counts[i] = s.counts[i];
  encoder_->add(tick, bytes_);
  if (bytes_.size() >= kPiece) out_->write(std::exchange(bytes_, {}));
}

Result<void> SetpointFile::close() {
  if (!encoder_) begin(0);
  encoder_->end(bytes_);
  out_->write(std::exchange(bytes_, {}));
  return out_->close();
}

Result<SetpointComparison> compare(const std::string& path_a, const std::string& path_b) {
  auto a = read(path_a);
  if (!a) return tl::unexpected(a.error());
  auto b = read(path_b);
  if (!b) return tl::unexpected(b.error());
  if (a->drives != b->drives && !a->ticks.empty() && !b->ticks.empty())
    return fail(Fault::Inconsistent,
                fmt::format("the runs are of different machines: {} and {} drives", a->drives, b->drives), path_b);

  SetpointComparison c;
  c.ticks_a = a->ticks.size();
  c.ticks_b = b->ticks.size();
  auto i = a->ticks.begin();
  auto j = b->ticks.begin();
  while (i != a->ticks.end() || j != b->ticks.end()) {
    const bool take_a = j == b->ticks.end() || (i != a->ticks.end() && i->key() < j->key());
    const bool take_b = i == a->ticks.end() || (j != b->ticks.end() && j->key() < i->key());
    if (take_a) {
      ++c.only_a, ++i;
    } else if (take_b) {
      ++c.only_b, ++j;
    } else {
      const bool sent_a = i->sent, sent_b = j->sent;
      if (sent_a && sent_b) {
        ++c.common;
        if (!c.first_difference) c.first_difference = difference(*i, *j, a->drives);
      } else if (sent_a) {
        ++c.only_a;
      } else if (sent_b) {
        ++c.only_b;
      }
      ++i, ++j;
    }
  }
  return c;
}

}  // namespace gantry::record
