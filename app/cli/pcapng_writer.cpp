#include "app/cli/pcapng_writer.hpp"

#include <array>
#include <fstream>
#include <vector>

namespace gantry::cli {
namespace {

template <class T>
void append(std::vector<std::byte>& out, std::type_identity_t<T> value) {
  for (std::size_t i = 0; i < sizeof(T); ++i)
    out.push_back(static_cast<std::byte>(static_cast<std::uint64_t>(value) >> 8 * i & 0xFF));
}

constexpr std::array<char, 4> kCapture{0x0A, 0x0D, 0x0D, 0x0A};  // a file begins with it
constexpr std::uint32_t kSectionHeader = 0x0A0D0D0A, kInterface = 1, kEnhancedPacket = 6;

}  // namespace

Result<std::unique_ptr<PcapngWriter>> PcapngWriter::create(const std::string& path) {
  std::array<char, 4> begins{};
  std::ifstream there(path, std::ios::binary);
  if (there.read(begins.data(), begins.size()); there.gcount() > 0 && begins != kCapture)
    return fail(Fault::FileUnwritable, "there is a file already, which is no capture; choose another name", path);
  auto file = NewFile::create(path);
  if (!file) return tl::unexpected(file.error());
  auto writer = std::unique_ptr<PcapngWriter>(new PcapngWriter(std::move(*file)));
  std::vector<std::byte> section;
  append<std::uint32_t>(section, 0x1A2B3C4D);  // byte order
  append<std::uint16_t>(section, 1), append<std::uint16_t>(section, 0);
  append<std::uint64_t>(section, ~std::uint64_t{0});  // length of the section: not told
  writer->block(kSectionHeader, section);
  std::vector<std::byte> interface;
  append<std::uint16_t>(interface, 1), append<std::uint16_t>(interface, 0);  // Ethernet
  append<std::uint32_t>(interface, 0);                                       // no limit of length
  append<std::uint16_t>(interface, 9), append<std::uint16_t>(interface, 1);  // times are in 10^-9 s
  append<std::uint32_t>(interface, 9);
  append<std::uint32_t>(interface, 0);  // end of options
  writer->block(kInterface, interface);
  return writer;
}

void PcapngWriter::add(std::uint64_t time_ns, std::span<const std::byte> frame) {
  std::vector<std::byte> packet;
  append<std::uint32_t>(packet, 0);
  append<std::uint32_t>(packet, static_cast<std::uint32_t>(time_ns >> 32));
  append<std::uint32_t>(packet, static_cast<std::uint32_t>(time_ns));
  append<std::uint32_t>(packet, static_cast<std::uint32_t>(frame.size()));
  append<std::uint32_t>(packet, static_cast<std::uint32_t>(frame.size()));
  packet.insert(packet.end(), frame.begin(), frame.end());
  block(kEnhancedPacket, packet);
  ++frames_;
}

void PcapngWriter::block(std::uint32_t type, std::span<const std::byte> body) {
  const std::size_t padded = (body.size() + 3) / 4 * 4;
  std::vector<std::byte> out;
  append<std::uint32_t>(out, type);
  append<std::uint32_t>(out, static_cast<std::uint32_t>(padded + 12));
  out.insert(out.end(), body.begin(), body.end());
  out.resize(8 + padded);
  append<std::uint32_t>(out, static_cast<std::uint32_t>(padded + 12));
  file_.write({reinterpret_cast<const char*>(out.data()), out.size()});
}

Result<void> PcapngWriter::close() { return file_.close(); }

}  // namespace gantry::cli
