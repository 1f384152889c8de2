// The master's mailbox and SDO client against a station that answers what it likes. Every call must end.
// Input: what kind of station, what to ask (two of four bits), then the replies: length, flags, bytes.
// Station: bit 0: a reply waits before anything is asked; bit 1: its mailbox is short; bit 2: it has no CoE; bit 3:
// when the input ends it keeps silent instead of going away; bit 4: it never repeats; bits 5-6: so many requests it
// does not take at first. Flags: bit 0: the header is put right (length, CoE, counter), so that the input's bytes reach
// what lies behind it; bit 1: the mailbox turns out empty; bit 2: another reply waits behind it; bit 3: the reply is
// lost on the way.
#include "devices/ethercat/sdo.hpp"
#include "devices/ethercat/sdo_info.hpp"
#include "devices/wire/coe.hpp"
#include "devices/wire/sii.hpp"
#include "tests/fuzz/input.hpp"
#include "tests/fuzz/liar_port.hpp"

using namespace gantry;
using namespace gantry::devices;

namespace {

constexpr std::uint16_t kOut = 0x1000, kIn = 0x1080, kBytes = 128, kShort = 24;
enum Kind : unsigned { kFullAtStart = 1, kShortMailbox = 2, kNoCoe = 4, kSilent = 8, kNeverRepeats = 16 };

class MailboxLiar final : public fuzz::LiarPort {
 public:
  MailboxLiar(VirtualClock& clock, fuzz::Input& input, unsigned kind)
      : LiarPort(clock), input_(input), kind_(kind), full_((kind & kFullAtStart) != 0), refusals_(kind >> 5 & 3) {}

  Answer answer(const wire::DatagramHeader& asked, std::span<std::byte> data) override {
    const auto reg = static_cast<std::uint16_t>(asked.address >> 16);
    if (input_.empty()) {
      if ((kind_ & kSilent) == 0) return Answer::TakesNot;  // the station is gone: the call ends soon
      full_ = false;
      clock_.sleep_until(clock_.now() + milliseconds(100));
    }
    if (reg == kIn && asked.command == wire::Command::Fprd) return reply(data);
    if (reg == kOut) {
      if (refusals_ > 0) return --refusals_, Answer::TakesNot;
      full_ = true, looks_ = 0;
    }
    if (reg == kActivate && asked.command == wire::Command::Fpwr) {
      activate_ = data[0];
      full_ = true;
    }
    if (!full_ && ++looks_ > kPatience) return Answer::TakesNot;
    for (std::size_t i = 0; i < data.size(); ++i) {
      if (reg + i == wire::reg::kSyncManager0 + wire::kSmStatusOffset) data[i] = std::byte{0};
      if (reg + i == kInStatus) data[i] = full_ ? std::byte{wire::kSmStatusMailboxFull} : std::byte{0};
      if (reg + i != kActivate + 1) continue;
      const bool repeats = (kind_ & kNeverRepeats) == 0;
      data[i] = repeats ? activate_ & std::byte{wire::kSmActivateRepeatRequest} : std::byte{0};
      if (!repeats) clock_.sleep_until(clock_.now() + milliseconds(30));  // few looks until the end of the wait
    }
    return Answer::Takes;
  }

 private:
  Answer reply(std::span<std::byte> data) {
    std::fill(data.begin(), data.end(), std::byte{0});
    const std::size_t size = input_.u8();
    const std::uint8_t flags = input_.u8();
    const auto bytes = input_.take(size);
    std::copy_n(bytes.begin(), std::min(bytes.size(), data.size()), data.begin());
    if ((flags & 1) != 0 && data.size() >= 6) {
      counter_ = static_cast<std::uint8_t>(counter_ % 7 + 1);
      wire::put_le<std::uint16_t>(
          data, 0, static_cast<std::uint16_t>(size < 6 ? 0 : std::min<std::size_t>(size - 6, data.size() - 6)));
      data[5] = static_cast<std::byte>(3 | counter_ << 4);
    }
    full_ = (flags & 4) != 0;
    if ((flags & 8) != 0) return Answer::Lost;
    return (flags & 2) == 0 ? Answer::Takes : Answer::TakesNot;
  }

  static constexpr std::size_t kInRegisters = wire::reg::kSyncManager0 + wire::kSyncManagerBytes,
                               kInStatus = kInRegisters + wire::kSmStatusOffset, kActivate = kInRegisters + 6;
  static constexpr int kPatience = 8;
  fuzz::Input& input_;
  unsigned kind_;
  std::uint8_t counter_ = 0;
  bool full_;
  unsigned refusals_;
  std::byte activate_{};
  int looks_ = 0;  ///< since the last request, at a mailbox that stays empty
};

StationRecord record_of(unsigned kind) {
  const std::uint16_t bytes = (kind & kShortMailbox) != 0 ? kShort : kBytes;
  StationRecord station;
  station.address = 0x1001;
  station.where = "station";
  station.sync_managers = {{{.start = kOut, .length = bytes, .control = wire::kSmControlMailboxOut, .activate = 1}, 1},
                           {{.start = kIn, .length = bytes, .control = wire::kSmControlMailboxIn, .activate = 1}, 2}};
  station.sii.mailbox = {kOut, bytes, kIn, bytes};
  station.sii.protocols = (kind & kNoCoe) != 0 ? 0 : wire::sii::kProtocolCoe;
  return station;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  fuzz::Input in(data, size);
  const unsigned kind = in.u8();
  const std::uint8_t what = in.u8();
  VirtualClock clock;
  MailboxLiar port(clock, in, kind);
  Link link(port, clock);
  StationRecord station = record_of(kind);
  static const std::vector<std::byte> long_value(300, std::byte{0x5A}), one(1),
      two_pdos{std::byte{2}, std::byte{0}, std::byte{0}, std::byte{0x16}, std::byte{1}, std::byte{0x16}};
  for (int i = 0; i < 2 && !in.empty(); ++i) switch ((what >> 4 * i) & 15) {
      case 0: (void)sdo_upload(link, station, {0x1018, 1}); break;
      case 1: (void)sdo_download(link, station, {0x607A, 0}, std::span(long_value).first(4)); break;
      case 2: (void)sdo_download(link, station, {0x2000, 0}, long_value); break;
      case 3: (void)sdo_upload(link, station, {0x1C12, 0}, SdoAccess::Complete); break;
      case 4: (void)sdo_download(link, station, {0x1C12, 0}, two_pdos, SdoAccess::Complete); break;
      case 5: (void)read_object_indices(link, station, wire::sdo_info::kListAll); break;
      case 6: (void)describe_object(link, station, 0x6040); break;
      case 7: (void)describe_entry(link, station, {0x6040, 0}); break;
      case 8: (void)read_object_list(link, station, true); break;
      case 9: (void)sdo_download(link, station, {0x1C12, 0}, one, SdoAccess::Complete); break;
      default: (void)read_number(link, station, {0x1018, 1}, config::ObjectType::U32); break;
    }
  return 0;
}
