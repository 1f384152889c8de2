// A recorded line of stations as a FramePort: what the stations told in a capture, told again to whoever asks. Not by
// time and not by the order of frames: a datagram is answered by what was recorded for the same question, so that a
// master may ask more often, less often, or in other frames.
//   ReplayLine line(exchanges, clock);     EthercatMaster master(machine, line, clock);
// Questions by what they mean: EEPROM words by word address, SDO answers by the request, AL status by the state asked
// for, everything else by command and address. A question that was never recorded gets no answer (working counter 0)
// and is counted, but for registers that were written before: those read back.
#pragma once
#include <algorithm>
#include <cstdint>
#include <deque>
#include <map>
#include <string>
#include <tuple>
#include <vector>

#include "core/clock.hpp"
#include "devices/frame_port.hpp"
#include "devices/wire/coe.hpp"
#include "devices/wire/ethercat.hpp"
#include "tests/interop/capture.hpp"

namespace gantry::interop {

class ReplayLine final : public devices::FramePort {
 public:
  ReplayLine(const std::vector<std::pair<Record, Record>>& turns, VirtualClock& clock) : clock_(clock) {
    for (const auto& [request, reply] : turns) {
      const auto asked = datagrams(request.frame), told = datagrams(reply.frame);
      for (std::size_t i = 0; i < asked.size(); ++i) learn(asked[i], told[i]);
    }
    for (auto& [station, s] : stations_) s.begin();
  }
  std::vector<std::uint32_t> unknown;  ///< addresses of questions that were never recorded
  int answered = 0;

  bool send(devices::PortIndex, std::span<const std::byte> frame) noexcept override {
    Bytes reply(frame.begin(), frame.end());
    reply[6] |= std::byte{wire::kProcessedMacBit};
    std::size_t at = wire::kFrameHeader;
    for (const auto& d : datagrams(frame)) {
      const auto data = std::span(reply).subspan(at + wire::kDatagramHeader, d.header.length);
      const std::uint16_t counter = answer(d, data);
      wire::put_le<std::uint16_t>(reply, at + wire::kDatagramHeader + d.header.length, counter);
      at += wire::kDatagramHeader + d.header.length + wire::kWorkingCounter;
    }
    on_the_way_.push_back(std::move(reply));
    return true;
  }
  devices::Received receive(std::span<std::byte> buffer, Time deadline) noexcept override {
    if (on_the_way_.empty()) {
      clock_.sleep_until(deadline);
      return {};
    }
    const Bytes frame = std::move(on_the_way_.front());
    on_the_way_.pop_front();
    std::copy(frame.begin(), frame.end(), buffer.begin());
    clock_.sleep_until(clock_.now() + microseconds(20));
    return {frame.size(), devices::PortIndex::Primary, clock_.now()};
  }
  [[nodiscard]] bool link_up(devices::PortIndex) const noexcept override { return true; }

 private:
  struct Answer {
    Bytes data;
    std::uint16_t working_counter = 0;
  };
  using Question = std::tuple<wire::Command, std::uint32_t, std::size_t>;

  /// What a station said while it was recorded, and where it stands now.
  struct Station {
    std::map<std::uint16_t, Bytes> eeprom;                ///< 14 bytes from 0502h by word address
    std::map<std::string, std::vector<Bytes>> mailboxes;  ///< answers by request, both without their counters
    std::map<std::uint16_t, Bytes> states;                ///< 0130h to 0135h by what 0120h asked for
    std::map<std::uint16_t, std::byte> written;           ///< registers
    std::uint16_t word = 0, asked = 0x11;                 ///< as a reset leaves it
    std::string request;
    std::deque<Bytes> waiting;
    std::uint16_t box_out = 0, box_in = 0, box_out_bytes = 0;
    void begin() { word = 0, asked = 0x11, request.clear(); }
  };

  static bool reads(wire::Command c) {
    return c == wire::Command::Fprd || c == wire::Command::Aprd || c == wire::Command::Brd;
  }
  static bool writes(wire::Command c) {
    return c == wire::Command::Fpwr || c == wire::Command::Apwr || c == wire::Command::Bwr;
  }

  /// Writes as the station meets them: of one station, or of all.
  void note_write(Station& s, std::uint16_t ado, std::span<const std::byte> data, bool learning) {
    using namespace wire;
    if (ado == reg::kAlControl) s.asked = get_le<std::uint16_t>(data, 0);
    if (ado == reg::kSiiControl && data.size() >= 6) s.word = get_le<std::uint16_t>(data, 2);
    if (ado == reg::kSyncManager0 && data.size() == 8) {
      s.box_out = get_le<std::uint16_t>(data, 0), s.box_out_bytes = get_le<std::uint16_t>(data, 2);
    }
    if (ado == reg::kSyncManager0 + kSyncManagerBytes && data.size() == 8) s.box_in = get_le<std::uint16_t>(data, 0);
    if (s.box_out != 0 && ado == s.box_out && data.size() == s.box_out_bytes) {
      s.request = without_counter(data);
      if (learning) {
        s.mailboxes[s.request].clear();  // asked again: the last answer counts
      } else {
        const auto known = s.mailboxes.find(s.request);
        if (known == s.mailboxes.end())
          unknown.push_back(ado);
        else
          s.waiting.assign(known->second.begin(), known->second.end());
      }
    }
    for (std::size_t i = 0; ado < kMemory && i < data.size(); ++i)
      s.written[static_cast<std::uint16_t>(ado + i)] = data[i];
  }
  static std::string without_counter(std::span<const std::byte> mailbox) {
    const std::size_t size = wire::kMailboxHeader + wire::get_mailbox_header(mailbox).length;
    std::string out;
    for (const std::byte b : mailbox.first(std::min(size, mailbox.size()))) out += static_cast<char>(b);
    out[5] = static_cast<char>(out[5] & 0x0F);
    return out;
  }

  void learn(const Datagram& asked, const Datagram& told) {
    using namespace wire;
    const auto c = asked.header.command;
    const auto ado = asked.header.ado();
    const Bytes data(told.data.begin(), told.data.end());
    answers_[Question{c, asked.header.address, asked.header.length}].push_back({data, told.working_counter});
    if (c == Command::Bwr)
      for (auto& [address, s] : stations_) note_write(s, ado, asked.data, true);
    if (c == Command::Apwr && ado == reg::kStationAddress) stations_[get_le<std::uint16_t>(asked.data, 0)];
    if (c != Command::Fprd && c != Command::Fpwr) return;
    Station& s = stations_[asked.header.adp()];
    if (c == Command::Fpwr) {
      if (told.working_counter == 1) note_write(s, ado, asked.data, true);
      return;
    }
    if (told.working_counter != 1) return;
    if (ado == reg::kSiiControl && data.size() == 14 && (get_le<std::uint16_t>(data, 0) & kSiiBusy) == 0)
      s.eeprom[s.word] = data;
    if (ado == reg::kAlStatus) {
      Bytes& status = s.states[s.asked];
      status.resize(6);
      std::copy(data.begin(), data.end(), status.begin());
    }
    if (s.box_in != 0 && ado == s.box_in) s.mailboxes[s.request].push_back(data);
  }

  std::uint16_t answer(const Datagram& asked, std::span<std::byte> data) {
    using namespace wire;
    ++answered;
    const auto c = asked.header.command;
    const auto ado = asked.header.ado();
    if (c == Command::Bwr)
      for (auto& [address, s] : stations_) note_write(s, ado, asked.data, false);
    const auto known = stations_.find(asked.header.adp());
    if ((c == Command::Fprd || c == Command::Fpwr) && known != stations_.end()) {
      Station& s = known->second;
      if (c == Command::Fpwr) note_write(s, ado, asked.data, false);
      if (c == Command::Fpwr && s.box_out != 0 && ado == s.box_out) return 1;
      if (c == Command::Fprd) {
        if (ado == reg::kSiiControl)
          return s.eeprom.contains(s.word) ? tell(s.eeprom[s.word], data) : not_recorded(asked);
        if (ado == reg::kAlStatus)
          return s.states.contains(s.asked) ? tell(s.states[s.asked], data) : not_recorded(asked);
        if (ado == reg::kSyncManager0 + kSyncManagerBytes + kSmStatusOffset) {
          data[0] = s.waiting.empty() ? std::byte{0} : std::byte{kSmStatusMailboxFull};
          return 1;
        }
        if (s.box_in != 0 && ado == s.box_in) {
          if (s.waiting.empty()) return 0;
          const Bytes mailbox = s.waiting.front();
          s.waiting.pop_front();
          return tell(mailbox, data);
        }
      }
    }
    const auto recorded = answers_.find(Question{c, asked.header.address, asked.header.length});
    if (recorded != answers_.end() && !recorded->second.empty()) {
      const Answer a = recorded->second.front();
      if (recorded->second.size() > 1) recorded->second.pop_front();
      if (!writes(c)) std::copy(a.data.begin(), a.data.end(), data.begin());
      return a.working_counter;
    }
    if (known != stations_.end() && ado < kMemory && c == Command::Fpwr) return 1;
    if (known != stations_.end() && ado < kMemory && c == Command::Fprd && known->second.written.contains(ado)) {
      for (std::size_t i = 0; i < data.size(); ++i)
        data[i] = known->second.written[static_cast<std::uint16_t>(ado + i)];
      return 1;
    }
    return not_recorded(asked);
  }
  std::uint16_t not_recorded(const Datagram& asked) {
    unknown.push_back(asked.header.address);
    return 0;
  }
  static std::uint16_t tell(std::span<const std::byte> what, std::span<std::byte> data) {
    std::copy_n(what.begin(), std::min(what.size(), data.size()), data.begin());
    return 1;
  }

  static constexpr std::uint16_t kMemory = wire::reg::kProcessRam;
  VirtualClock& clock_;
  std::map<std::uint16_t, Station> stations_;  ///< by configured address
  std::map<Question, std::deque<Answer>> answers_;
  std::deque<Bytes> on_the_way_;
};

}  // namespace gantry::interop
