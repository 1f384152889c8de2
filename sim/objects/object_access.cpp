// ObjectDictionary: complete access, to an index as a whole.
#include <algorithm>

#include "devices/wire/coe.hpp"
#include "sim/objects/object_dictionary.hpp"

namespace gantry::sim {

using config::ObjectAddress;
using config::ObjectType;
namespace abort_code = devices::wire::abort_code;

std::uint32_t ObjectDictionary::read_complete(ObjectAddress from, std::vector<std::byte>& out) const {
  const auto subs = index(from.index);
  if (subs.empty()) return abort_code::kNoObject;
  if (from.sub > 1 || subs.size() == 1) return abort_code::kUnsupportedAccess;
  if (subs.back().type == ObjectType::String) return abort_code::kCompleteAccessUnsupported;
  const bool counted = subs[0].rule != ObjectRule::Plain;
  for (const Object& o : subs) {
    if (o.address.sub == 0 && from.sub > 0) continue;
    if (counted && o.address.sub > subs[0].value) break;
    if (const auto refused = read(o.address, out); refused != 0) return refused;
    if (o.address.sub == 0) out.push_back(std::byte{0});
  }
  return 0;
}

std::uint32_t ObjectDictionary::write_complete(ObjectAddress from, std::span<const std::byte> bytes, bool pre_op) {
  const auto subs = index(from.index);
  if (subs.empty()) return abort_code::kNoObject;
  if (from.sub > 1 || subs.size() == 1) return abort_code::kUnsupportedAccess;
  if (subs.back().type == ObjectType::String) return abort_code::kCompleteAccessUnsupported;
  std::vector<std::int64_t> before;
  for (const Object& o : subs) before.push_back(o.value);
  const bool counted = subs[0].rule != ObjectRule::Plain;
  const auto take = [&]() -> std::uint32_t {
    std::size_t at = 0;
    std::span<const std::byte> count;
    if (from.sub == 0) {
      if (bytes.size() < 2) return abort_code::kSizeTooSmall;
      count = bytes.first(1);
      at = 2;
    }
    // The count of a mapping is 0 while its entries are written, and comes last.
    if (counted && from.sub == 0) {
      const std::byte zero{};
      if (const auto refused = write(subs[0].address, std::span(&zero, 1), pre_op); refused != 0) return refused;
    } else if (from.sub == 0 && std::to_integer<std::int64_t>(count[0]) != subs[0].value) {
      return subs[0].writable ? abort_code::kValueRange : abort_code::kReadOnly;
    }
    for (const Object& o : subs) {
      if (o.address.sub == 0 || at == bytes.size()) continue;
      const std::size_t size = size_of(o.type);
      if (bytes.size() - at < size) return abort_code::kSizeTooSmall;
      // What may only be read must come as it is.
      if (o.writable) {
        if (const auto refused = write(o.address, bytes.subspan(at, size), pre_op); refused != 0) return refused;
      }
      at += size;
    }
    if (at < bytes.size()) return abort_code::kSizeTooLarge;
    if (counted && from.sub == 0) return write(subs[0].address, count, pre_op);
    return std::any_of(subs.begin(), subs.end(), [](const Object& o) { return o.writable; }) ? 0
                                                                                             : abort_code::kReadOnly;
  };
  const std::uint32_t refused = take();
  if (refused != 0)
    for (std::size_t i = 0; i < before.size(); ++i) subs[i].value = before[i];
  return refused;
}

}  // namespace gantry::sim
