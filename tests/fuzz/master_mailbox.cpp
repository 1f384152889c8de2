// The master's mailbox and SDO client against a station that answers what it likes. Every call must end.
// Input: what to ask (two of four bits), then the replies: length, flags, bytes. Flag bit 0: the header is put right
// (length, CoE, counter), so that the input's bytes reach what lies behind it.
#include "devices/ethercat/sdo.hpp"
#include "devices/ethercat/sdo_info.hpp"
#include "devices/wire/coe.hpp"
#include "tests/fuzz/input.hpp"
#include "tests/fuzz/liar_port.hpp"

using namespace gantry;
using namespace gantry::devices;

namespace {

constexpr std::uint16_t kOut = 0x1000, kIn = 0x1080, kBytes = 128;

class MailboxLiar final : public fuzz::LiarPort {
 public:
  MailboxLiar(VirtualClock& clock, fuzz::Input& input) : LiarPort(clock), input_(input) {}

  bool answer(const wire::DatagramHeader& asked, std::span<std::byte> data) override {
    const auto reg = static_cast<std::uint16_t>(asked.address >> 16);
    if (input_.empty()) return false;  // the station is gone: the call ends soon
    if (reg == kIn && asked.command == wire::Command::Fprd) {
      std::fill(data.begin(), data.end(), std::byte{0});
      const std::size_t size = input_.u8();
      const std::uint8_t flags = input_.u8();
      const auto bytes = input_.take(size);
      std::copy_n(bytes.begin(), std::min(bytes.size(), data.size()), data.begin());
      if ((flags & 1) != 0 && data.size() >= 6) {
        counter_ = static_cast<std::uint8_t>(counter_ % 7 + 1);
        wire::put_le<std::uint16_t>(
            data, 0, static_cast<std::uint16_t>(size < 6 ? 0 : std::min<std::size_t>(size - 6, kBytes - 6)));
        data[5] = static_cast<std::byte>(3 | counter_ << 4);
      }
      full_ = (flags & 4) != 0;
      return (flags & 2) == 0;
    }
    if (reg == kOut) full_ = true, looks_ = 0;
    if (!full_ && ++looks_ > kPatience) return false;
    for (std::size_t i = 0; i < data.size(); ++i) {
      if (reg + i == wire::reg::kSyncManager0 + wire::kSmStatusOffset) data[i] = std::byte{0};
      if (reg + i == wire::reg::kSyncManager0 + wire::kSyncManagerBytes + wire::kSmStatusOffset)
        data[i] = full_ ? std::byte{wire::kSmStatusMailboxFull} : std::byte{0};
    }
    return true;
  }

 private:
  fuzz::Input& input_;
  std::uint8_t counter_ = 0;
  bool full_ = false;
  int looks_ = 0;  ///< since the last request, at a mailbox that stays empty
  static constexpr int kPatience = 40;
};

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  fuzz::Input in(data, size);
  const std::uint8_t what = in.u8();
  VirtualClock clock;
  MailboxLiar port(clock, in);
  Link link(port, clock);
  StationRecord station;
  station.address = 0x1001;
  station.where = "station";
  station.sync_managers = {{{.start = kOut, .length = kBytes, .control = wire::kSmControlMailboxOut, .activate = 1}, 1},
                           {{.start = kIn, .length = kBytes, .control = wire::kSmControlMailboxIn, .activate = 1}, 2}};
  const std::vector<std::byte> long_value(300, std::byte{0x5A});
  for (int i = 0; i < 2 && !in.empty(); ++i) switch ((what >> 4 * i) & 15) {
      case 0: (void)sdo_upload(link, station, {0x1018, 1}); break;
      case 1: (void)sdo_download(link, station, {0x607A, 0}, std::span(long_value).first(4)); break;
      case 2: (void)sdo_download(link, station, {0x2000, 0}, long_value); break;
      case 3: (void)sdo_upload(link, station, {0x1C12, 0}, SdoAccess::Complete); break;
      case 4:
        (void)sdo_download(link, station, {0x1C12, 0}, std::span(long_value).first(6), SdoAccess::Complete);
        break;
      case 5: (void)read_object_indices(link, station, wire::sdo_info::kListAll); break;
      case 6: (void)describe_object(link, station, 0x6040); break;
      case 7: (void)describe_entry(link, station, {0x6040, 0}); break;
      case 8: (void)read_object_list(link, station, true); break;
      default: (void)read_number(link, station, {0x1018, 1}, config::ObjectType::U32); break;
    }
  return 0;
}
