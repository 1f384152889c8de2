#include "app/record/setpoint_code.hpp"

#include <optional>

namespace gantry::record {
namespace {

constexpr unsigned char kRunOfTicks = 0x80, kSent = 0x01, kBlock = 0x02, kTick = 0x04, kOutputs = 0x08;

void put_varint(std::string& out, std::uint64_t v) {
  for (; v >= 0x80; v >>= 7) out.push_back(static_cast<char>((v & 0x7F) | 0x80));
  out.push_back(static_cast<char>(v));
}

std::optional<std::uint64_t> get_varint(std::string_view& bytes) {
  std::uint64_t v = 0;
  for (unsigned shift = 0, i = 0; i < bytes.size() && shift < 64; ++i, shift += 7) {
    const auto byte = static_cast<unsigned char>(bytes[i]);
    v |= std::uint64_t{byte & 0x7Fu} << shift;
    if ((byte & 0x80) != 0) continue;
    bytes.remove_prefix(i + 1);
    return v;
  }
  return std::nullopt;
}

// Counts wrap: differences are taken and added without a sign.
std::uint32_t zigzag(std::uint32_t v) { return (v << 1) ^ (0u - (v >> 31)); }
std::uint32_t from_zigzag(std::uint32_t v) { return (v >> 1) ^ (0u - (v & 1)); }

std::uint32_t foreseen(const SetpointTick& last, const SetpointTick& before, std::size_t drive) {
  return 2 * static_cast<std::uint32_t>(last.counts[drive]) - static_cast<std::uint32_t>(before.counts[drive]);
}

/// The tick behind `last`, if nothing changes.
SetpointTick next(const SetpointTick& last, const SetpointTick& before, std::uint32_t drives) {
  SetpointTick t = last;
  ++t.tick;
  for (std::uint32_t i = 0; i < drives; ++i) t.counts[i] = static_cast<std::int32_t>(foreseen(last, before, i));
  return t;
}

/// One tick behind its first byte.
bool read_record(std::string_view& bytes, unsigned char first, std::uint32_t drives, SetpointTick& t) {
  t.sent = (first & kSent) != 0;
  const auto field = [&](unsigned char bit, std::uint32_t& value) {
    if ((first & bit) == 0) return true;
    const auto v = get_varint(bytes);
    if (v) value = static_cast<std::uint32_t>(*v);
    return v.has_value();
  };
  if (!field(kBlock, t.block) || !field(kTick, t.tick) || !field(kOutputs, t.outputs)) return false;
  const auto other = get_varint(bytes);
  if (!other) return false;
  for (std::uint32_t i = 0; i < drives; ++i) {
    if ((*other >> i & 1) == 0) continue;
    const auto by = get_varint(bytes);
    if (!by) return false;
    t.counts[i] = static_cast<std::int32_t>(static_cast<std::uint32_t>(t.counts[i]) +
                                            from_zigzag(static_cast<std::uint32_t>(*by)));
  }
  return true;
}

}  // namespace

void SetpointEncoder::add(const SetpointTick& tick, std::string& bytes) {
  const SetpointTick expected = next(last_, before_, drives_);
  std::uint64_t other = 0;
  for (std::uint32_t i = 0; i < drives_; ++i) other |= std::uint64_t{tick.counts[i] != expected.counts[i]} << i;
  unsigned char first = tick.sent ? kSent : 0;
  if (tick.block != expected.block) first |= kBlock;
  if (tick.tick != expected.tick) first |= kTick;
  if (tick.outputs != expected.outputs) first |= kOutputs;
  if (other == 0 && tick.sent == expected.sent && (first & ~kSent) == 0) {
    ++run_;
  } else {
    end(bytes);
    bytes.push_back(static_cast<char>(first));
    if ((first & kBlock) != 0) put_varint(bytes, tick.block);
    if ((first & kTick) != 0) put_varint(bytes, tick.tick);
    if ((first & kOutputs) != 0) put_varint(bytes, tick.outputs);
    put_varint(bytes, other);
    for (std::uint32_t i = 0; i < drives_; ++i)
      if ((other >> i & 1) != 0)
        put_varint(bytes,
                   zigzag(static_cast<std::uint32_t>(tick.counts[i]) - static_cast<std::uint32_t>(expected.counts[i])));
  }
  before_ = last_;
  last_ = tick;
}

void SetpointEncoder::end(std::string& bytes) {
  if (run_ == 0) return;
  bytes.push_back(static_cast<char>(kRunOfTicks));
  put_varint(bytes, run_);
  run_ = 0;
}

bool decode(std::string_view bytes, std::uint32_t drives, const std::function<bool(const SetpointTick&)>& take) {
  SetpointTick last, before;
  const auto give = [&](const SetpointTick& t) {
    before = last;
    last = t;
    return take(t);
  };
  while (!bytes.empty()) {
    const auto first = static_cast<unsigned char>(bytes.front());
    bytes.remove_prefix(1);
    if (first == kRunOfTicks) {
      const auto n = get_varint(bytes);
      if (!n) return true;
      for (std::uint64_t i = 0; i < *n; ++i)
        if (!give(next(last, before, drives))) return true;
      continue;
    }
    if ((first & ~(kSent | kBlock | kTick | kOutputs)) != 0) return false;
    SetpointTick t = next(last, before, drives);
    if (!read_record(bytes, first, drives, t)) return true;
    if (!give(t)) return true;
  }
  return true;
}

}  // namespace gantry::record
