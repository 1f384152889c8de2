#include "devices/ethercat/identity_object.hpp"

#include <fmt/format.h>

#include "devices/ethercat/sdo.hpp"
#include "devices/wire/coe.hpp"
#include "devices/wire/sii.hpp"

namespace gantry::devices {
namespace {

constexpr std::uint8_t kVendor = 1, kProduct = 2;  // sub-indexes

/// A profile with a mailbox is taken for one with CoE; an EEPROM that lists other protocols alone says that it has
/// none.
bool speaks_coe(const StationRecord& s) {
  return s.has_coe() && (s.sii.protocols == 0 || (s.sii.protocols & wire::sii::kProtocolCoe) != 0);
}

Result<std::uint32_t> said(Link& link, StationRecord& s, std::uint8_t sub) {
  const auto value = read_number(link, s, {wire::object::kIdentity, sub}, config::ObjectType::U32);
  if (value) return static_cast<std::uint32_t>(*value);
  if (value.error().fault == Fault::SdoAbort) return 0u;
  return tl::unexpected(value.error());
}

template <class Identity>
std::string words(const Identity& id) {
  return fmt::format("vendor {:08X}h, product {:08X}h", id.vendor, id.product);
}

}  // namespace

Result<config::ObjectIdentity> read_identity_object(Link& link, StationRecord& s) {
  if (!speaks_coe(s)) return config::ObjectIdentity{};
  const auto vendor = said(link, s, kVendor);
  if (!vendor) return tl::unexpected(vendor.error());
  const auto product = said(link, s, kProduct);
  if (!product) return tl::unexpected(product.error());
  return config::ObjectIdentity{*vendor, *product};
}

Result<void> check_identity_object(Link& link, StationRecord& s) {
  if (s.config == nullptr) return {};
  const auto now = read_identity_object(link, s);
  if (!now) return tl::unexpected(now.error());
  const auto expected = config::expected_object(s.config->accepted, s.sii);
  if (config::agrees(*now, expected)) return {};
  const bool was_accepted = s.config->accepted && config::says_something(s.config->accepted->object);
  if (was_accepted)
    return fail(
        Fault::IdentityMismatch,
        fmt::format("'{}' has changed since {}: its firmware (1018h) was {}, and is {}; if this is right, `gantry "
                    "commission {} --accept`",
                    s.config->name, s.config->accepted->date, words(expected), words(*now), s.config->name),
        s.where);
  return fail(Fault::IdentityMismatch,
              fmt::format("its EEPROM and its firmware are of different devices: the EEPROM says {}, 1018h says {}; "
                          "expected is a {} ({}). Look at the type plate; if it is this drive all the same, `gantry "
                          "commission {} --accept`",
                          words(s.sii), words(*now), s.config->profile.title, words(s.config->profile.identity),
                          s.config->name),
              s.where);
}

}  // namespace gantry::devices
