#include "sim/segment/datagram.hpp"

#include <array>
#include <cstring>

#include "devices/frame_port.hpp"
#include "sim/esc/esc.hpp"

namespace gantry::sim {

using namespace devices::wire;

const std::size_t Datagram::kMostOfAFrame = devices::kMaxFrameBytes / (kDatagramHeader + kWorkingCounter);

Datagram::Datagram(std::span<std::byte> bytes) noexcept
    : header_(get_datagram_header(bytes)),
      adp_(header_.adp()),
      ado_(header_.ado()),
      working_counter_(get_le<std::uint16_t>(bytes, kDatagramHeader + header_.length)),
      bytes_(bytes.first(kDatagramHeader + header_.length + kWorkingCounter)) {}

void Datagram::put_back() const noexcept {
  DatagramHeader h = header_;
  const bool logical = h.command == Command::Lrd || h.command == Command::Lwr || h.command == Command::Lrw;
  if (!logical) h.address = physical_address(adp_, ado_);
  put_datagram_header(bytes_, h);
  put_le<std::uint16_t>(bytes_, kDatagramHeader + header_.length, working_counter_);
}

void Datagram::pass(Esc& esc, Time at) noexcept {
  const std::span<std::byte> data = bytes_.subspan(kDatagramHeader, header_.length);
  const auto count = [&](std::uint16_t n) { working_counter_ = static_cast<std::uint16_t>(working_counter_ + n); };
  const auto read = [&] { count(esc.read(ado_, data, at) ? kWkcRead : std::uint16_t{0}); };
  const auto write = [&] { count(esc.write(ado_, data, at) ? kWkcWrite : std::uint16_t{0}); };
  const auto write_back = [&](std::span<const std::byte> came) {
    const auto shifted = static_cast<std::uint16_t>(ado_ + esc.read_write_offset());
    if (esc.write(shifted, came, at)) count(kWkcReadWriteWrite);
  };
  const auto kept = [&](auto& copy) {  // what came
    std::memcpy(copy.data(), data.data(), data.size());
    return std::span<const std::byte>(copy).first(data.size());
  };
  const auto exchange = [&] {  // reads what was there and writes what came
    std::array<std::byte, devices::kMaxFrameBytes> copy;
    const auto came = kept(copy);
    if (esc.read(ado_, data, at)) count(kWkcReadWriteRead);
    write_back(came);
  };
  const auto read_or = [&] {
    std::array<std::byte, devices::kMaxFrameBytes> copy;
    const auto mine = std::span(copy).first(data.size());
    std::memset(mine.data(), 0, mine.size());  // what lies under a closed SyncManager adds nothing
    if (!esc.read(ado_, mine, at)) return;
    for (std::size_t i = 0; i < data.size(); ++i) data[i] |= mine[i];
    count(kWkcRead);
  };

  header_.irq |= esc.irq();
  switch (header_.command) {
    case Command::Aprd:
      if (adp_++ == 0) read();
      break;
    case Command::Apwr:
      if (adp_++ == 0) write();
      break;
    case Command::Aprw:
      if (adp_++ == 0) exchange();
      break;
    case Command::Fprd:
      if (esc.answers_to(adp_)) read();
      break;
    case Command::Fpwr:
      if (esc.answers_to(adp_)) write();
      break;
    case Command::Fprw:
      if (esc.answers_to(adp_)) exchange();
      break;
    case Command::Brd:
      ++adp_;
      read_or();
      break;
    case Command::Bwr:
      ++adp_;
      write();
      break;
    case Command::Brw: {
      ++adp_;
      std::array<std::byte, devices::kMaxFrameBytes> copy;
      const auto came = kept(copy);
      read_or();
      write_back(came);
      break;
    }
    case Command::Lrd:
    case Command::Lwr:
    case Command::Lrw: count(esc.logical(header_.command, header_.address, data, at)); break;
    case Command::Armw: adp_++ == 0 ? read() : write(); break;
    case Command::Frmw: esc.answers_to(adp_) ? read() : write(); break;
    case Command::Nop:
    default: break;
  }
}

}  // namespace gantry::sim
