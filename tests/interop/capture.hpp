// What a capture of this folder holds: frames, and the datagrams in them.
//   for (const auto& [request, reply] : exchanges(read_pcapng("our_master_and_strange_stations.pcapng"))) ...
#pragma once
#include <cstdint>
#include <fstream>
#include <gtest/gtest.h>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "devices/wire/ethercat.hpp"

namespace gantry::interop {

using Bytes = std::vector<std::byte>;
namespace wire = devices::wire;

struct Record {
  std::uint64_t time_ns = 0;
  Bytes frame;
};

/// Enhanced packets of a little-endian pcapng file.
inline std::vector<Record> read_pcapng(const std::string& name) {
  std::ifstream file(std::string(GANTRY_SOURCE_DIR "/tests/interop/captures/") + name, std::ios::binary);
  const std::vector<char> raw((std::istreambuf_iterator<char>(file)), std::istreambuf_iterator<char>());
  const std::span bytes(reinterpret_cast<const std::byte*>(raw.data()), raw.size());
  std::vector<Record> out;
  for (std::size_t at = 0; at + 12 <= bytes.size();) {
    const auto type = wire::get_le<std::uint32_t>(bytes, at), length = wire::get_le<std::uint32_t>(bytes, at + 4);
    if (length < 12 || at + length > bytes.size()) break;
    if (type == 6) {
      const auto size = wire::get_le<std::uint32_t>(bytes, at + 20);
      const std::uint64_t high = wire::get_le<std::uint32_t>(bytes, at + 12);
      const auto frame = bytes.subspan(at + 28, size);
      out.push_back({high << 32 | wire::get_le<std::uint32_t>(bytes, at + 16), {frame.begin(), frame.end()}});
    }
    at += length;
  }
  return out;
}

struct Datagram {
  wire::DatagramHeader header;
  std::span<const std::byte> data;
  std::uint16_t working_counter = 0;
};
inline std::vector<Datagram> datagrams(std::span<const std::byte> frame) {
  std::vector<Datagram> out;
  for (std::size_t at = wire::kFrameHeader; at + wire::kDatagramHeader <= frame.size();) {
    const auto header = wire::get_datagram_header(frame.subspan(at));
    const std::size_t end = at + wire::kDatagramHeader + header.length;
    if (end + wire::kWorkingCounter > frame.size()) break;
    out.push_back(
        {header, frame.subspan(at + wire::kDatagramHeader, header.length), wire::get_le<std::uint16_t>(frame, end)});
    if (!header.more) break;
    at = end + wire::kWorkingCounter;
  }
  return out;
}

/// Request and reply, paired by order: one is out at a time in these captures. Not by the bit of the source address
/// that stations set, which a stranger's own address may have.
inline std::vector<std::pair<Record, Record>> exchanges(const std::vector<Record>& records) {
  std::vector<std::pair<Record, Record>> out;
  for (std::size_t i = 0; i + 1 < records.size(); i += 2) {
    const auto asked = datagrams(records[i].frame), told = datagrams(records[i + 1].frame);
    EXPECT_TRUE(!asked.empty() && asked.size() == told.size() && asked[0].header.index == told[0].header.index)
        << "packet " << i + 2 << " is no reply to the one before";
    out.emplace_back(records[i], records[i + 1]);
  }
  return out;
}

}  // namespace gantry::interop
