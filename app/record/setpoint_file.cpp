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

constexpr std::array<char, 8> kMagic{'G', 'S', 'E', 'T', 'P', '1', 0, 0};
constexpr std::size_t kHead = kMagic.size() + 8;
constexpr std::uint32_t kSent = 1;

void put(std::string& out, std::uint32_t v) {
  for (int shift = 0; shift < 32; shift += 8) out.push_back(static_cast<char>((v >> shift) & 0xFFu));
}

std::uint32_t get(const char* at) {
  std::uint32_t v = 0;
  for (int i = 3; i >= 0; --i) v = (v << 8) | static_cast<unsigned char>(at[i]);
  return v;
}

struct Tick {
  std::uint32_t block = 0, attempt = 0, tick = 0, flags = 0, outputs = 0;
  const char* counts = nullptr;
  [[nodiscard]] auto key() const { return std::tuple(block, attempt, tick); }
};

struct Stream {
  std::string bytes;
  std::uint32_t drives = 0;
  std::vector<Tick> ticks;  // by key
};

Result<Stream> read(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  if (!in) return fail(Fault::FileUnreadable, "the setpoint file cannot be opened", path);
  Stream s;
  s.bytes.assign(std::istreambuf_iterator<char>(in), {});
  if (s.bytes.size() < kHead || std::memcmp(s.bytes.data(), kMagic.data(), kMagic.size()) != 0)
    return fail(Fault::Inconsistent, "this is no setpoint file (its first bytes are not \"GSETP1\")", path);
  s.drives = get(s.bytes.data() + kMagic.size());
  if (s.drives > cycle::kMaxDrives) return fail(Fault::Inconsistent, "the file names more drives than exist", path);
  const std::size_t record = 16 + 4 * std::size_t{s.drives};
  // A block that starts again (after an abort) begins at tick 1 once more: number the attempts to keep them apart.
  std::uint32_t block = 0, tick = 0;
  std::vector<std::uint32_t> attempts;
  for (std::size_t at = kHead; at + record <= s.bytes.size(); at += record) {
    const char* p = s.bytes.data() + at;
    Tick t{get(p), 0, get(p + 4), get(p + 8), get(p + 12), p + 16};
    if (t.block >= 1'000'000) return fail(Fault::Inconsistent, "the file holds a block number that cannot be", path);
    if (attempts.size() <= t.block) attempts.resize(t.block + 1, 0);
    if (t.block != block || t.tick <= tick) ++attempts[t.block];
    block = t.block, tick = t.tick;
    t.attempt = attempts[t.block];
    s.ticks.push_back(t);
  }
  std::stable_sort(s.ticks.begin(), s.ticks.end(), [](const Tick& a, const Tick& b) { return a.key() < b.key(); });
  return s;
}

std::optional<SetpointDifference> difference(const Tick& a, const Tick& b, std::uint32_t drives) {
  if (a.outputs != b.outputs)
    return SetpointDifference{a.block, a.tick, fmt::format("outputs: {:#x} and {:#x}", a.outputs, b.outputs)};
  for (std::uint32_t i = 0; i < drives; ++i) {
    const auto ca = static_cast<std::int32_t>(get(a.counts + 4 * i)),
               cb = static_cast<std::int32_t>(get(b.counts + 4 * i));
    if (ca != cb) return SetpointDifference{a.block, a.tick, fmt::format("counts of drive {}: {} and {}", i, ca, cb)};
  }
  return std::nullopt;
}

}  // namespace

Result<SetpointFile> SetpointFile::create(const std::string& path) {
  auto out = NewFile::create(path);
  if (!out) return tl::unexpected(out.error());
  return SetpointFile(std::move(*out));
}

void SetpointFile::add(const cycle::Snapshot& s) {
  if (s.block == 0) return;
  std::string bytes;
  if (!has_head_) {
    drives_ = std::min<std::uint32_t>(s.drives, cycle::kMaxDrives);
    bytes.assign(kMagic.begin(), kMagic.end());
    put(bytes, drives_);
    put(bytes, 0);
    has_head_ = true;
  }
  put(bytes, s.block);
  put(bytes, s.tick);
  put(bytes, s.sent ? kSent : 0);
  put(bytes, s.outputs & kProcessOutputs);
  for (std::uint32_t i = 0; i < drives_; ++i) put(bytes, static_cast<std::uint32_t>(s.counts[i]));
  out_.write(bytes);
}

Result<void> SetpointFile::close() {
  if (!has_head_) {
    std::string bytes(kMagic.begin(), kMagic.end());
    put(bytes, 0);
    put(bytes, 0);
    out_.write(bytes);
  }
  return out_.close();
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
      const bool sent_a = i->flags & kSent, sent_b = j->flags & kSent;
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
