// The mailbox, SDO and SDO information against a station whose every answer is written down by hand from ETG.1000.6.
#include "devices/ethercat/mailbox.hpp"

#include <algorithm>
#include <deque>
#include <functional>
#include <gtest/gtest.h>
#include <map>

#include "devices/ethercat/sdo.hpp"
#include "devices/ethercat/sdo_info.hpp"

namespace gantry::devices {
namespace {

using namespace wire;

Bytes bytes(std::initializer_list<int> values) {
  Bytes b;
  for (int v : values) b.push_back(static_cast<std::byte>(v));
  return b;
}

/// One station at 1001h with SM0 at 1000h and SM1 behind it: nothing but two mailboxes and a list of what it answers.
class MailboxStation final : public FramePort {
 public:
  explicit MailboxStation(VirtualClock& clock, std::size_t mailbox_bytes) : clock_(clock), size_(mailbox_bytes) {}
  std::function<std::vector<Bytes>(const Bytes& body)> answer;  ///< CoE body in, CoE bodies out
  std::vector<Bytes> requests;
  std::function<std::uint8_t()> next_counter = [this] { return counter_ = wire::next_counter(counter_); };
  int lose_read = -1;  ///< this read of a full mailbox is lost on its way back
  int lose_look = -1;  ///< this one on its way out: the mailbox stays full
  bool knows_repeat = true;
  int repeats = 0;
  std::vector<std::uint8_t> request_counters;
  /// What a station does with counters (ETG.1000.4, 5.6): nothing, or it drops one that comes twice. 0 is no counter;
  /// a station may forget the last one by it, keep it, or (against the standard) drop the request.
  enum class Repeats { Taken, ZeroForgets, ZeroKeeps, ZeroDropped } repeats_are = Repeats::Taken;
  std::uint8_t last_counter = 0;

  void push(const Bytes& coe) {
    Bytes m(size_);
    put_mailbox_header(
        m, {.length = static_cast<std::uint16_t>(coe.size()), .type = MailboxType::Coe, .counter = next_counter()});
    ASSERT_LE(coe.size() + kMailboxHeader, size_);
    std::copy(coe.begin(), coe.end(), m.begin() + kMailboxHeader);
    full_.push_back(std::move(m));
  }

  bool send(PortIndex, std::span<const std::byte> frame) noexcept override {
    Bytes reply(frame.begin(), frame.end());
    reply[6] |= std::byte{kProcessedMacBit};
    bool lost = false;
    for (std::size_t at = kFrameHeader;;) {
      const auto h = get_datagram_header(std::span(reply).subspan(at));
      const auto data = std::span(reply).subspan(at + kDatagramHeader, h.length);
      const bool ok =
          h.adp() == 0x1001 &&
          (h.command == Command::Fprd ? read(h.ado(), data, lost) : h.command == Command::Fpwr && write(h.ado(), data));
      put_le<std::uint16_t>(reply, at + kDatagramHeader + h.length, ok ? 1 : 0);
      if (!h.more) break;
      at += kDatagramHeader + h.length + kWorkingCounter;
    }
    if (!lost) arriving_ = std::move(reply);
    return true;
  }
  Received receive(std::span<std::byte> buffer, Time deadline) noexcept override {
    if (arriving_.empty()) {
      clock_.sleep_until(deadline);
      return {};
    }
    std::copy(arriving_.begin(), arriving_.end(), buffer.begin());
    const std::size_t size = arriving_.size();
    arriving_.clear();
    clock_.sleep_until(clock_.now() + microseconds(20));
    return {size, PortIndex::Primary, clock_.now()};
  }
  [[nodiscard]] bool link_up(PortIndex) const noexcept override { return true; }

  [[nodiscard]] StationRecord record() const {
    StationRecord r;
    static const config::Station known;
    r.config = &known;
    r.where = "station 0 'm'";
    r.address = 0x1001;
    r.sync_managers = {
        {{.start = 0x1000, .length = static_cast<std::uint16_t>(size_)}, 1},
        {{.start = static_cast<std::uint16_t>(0x1000 + size_), .length = static_cast<std::uint16_t>(size_)}, 2}};
    return r;
  }

 private:
  bool read(std::uint16_t at, std::span<std::byte> data, bool& lost) {
    if (at == 0x080D) data[0] = static_cast<std::byte>(full_.empty() ? 0 : kSmStatusMailboxFull);
    if (at == 0x080F) data[0] = static_cast<std::byte>(toggle_ && knows_repeat ? kSmPdiRepeatAck : 0);
    if (at < 0x1000) return true;
    if (at != 0x1000 + size_ || full_.empty()) return false;
    if (looks_++ == lose_look) return lost = true;
    std::copy(full_.front().begin(), full_.front().end(), data.begin());
    last_ = full_.front();
    full_.pop_front();
    lost = reads_++ == lose_read;
    return true;
  }
  bool write(std::uint16_t at, std::span<const std::byte> data) {
    if (at == 0x080E) {
      const bool toggle = (std::to_integer<int>(data[0]) & kSmActivateRepeatRequest) != 0;
      if (toggle != toggle_ && knows_repeat && !last_.empty()) full_.push_front(last_);
      if (toggle != toggle_) ++repeats;
      toggle_ = toggle;
    }
    if (at != 0x1000 || data.size() != size_) return at < 0x1000;
    const auto h = get_mailbox_header(data);
    request_counters.push_back(h.counter);
    if (repeats_are != Repeats::Taken && h.counter != 0 && h.counter == last_counter) return true;
    if (repeats_are == Repeats::ZeroDropped && h.counter == 0) return true;
    if (h.counter != 0 || repeats_are == Repeats::ZeroForgets) last_counter = h.counter;
    requests.emplace_back(data.begin() + kMailboxHeader, data.begin() + kMailboxHeader + h.length);
    for (const Bytes& b : answer(requests.back())) push(b);
    return true;
  }

  VirtualClock& clock_;
  std::size_t size_;
  Bytes arriving_, last_;
  std::deque<Bytes> full_;
  bool toggle_ = false;
  int reads_ = 0, looks_ = 0;
  std::uint8_t counter_ = 0;
};

struct Bench {
  VirtualClock clock;
  MailboxStation port;
  Link link{port, clock};
  StationRecord station;
  explicit Bench(std::size_t mailbox_bytes = 128) : port(clock, mailbox_bytes), station(port.record()) {}
};

TEST(Sdo, an_expedited_upload_has_the_bytes_of_the_standard) {
  Bench b;
  b.port.answer = [](const Bytes&) {
    return std::vector<Bytes>{bytes({0, 0x30, 0x4B, 0x41, 0x60, 0, 0x37, 0x02, 0, 0})};
  };
  const auto value = sdo_upload(b.link, b.station, {0x6041, 0});
  ASSERT_TRUE(value) << to_text(value.error());
  EXPECT_EQ(*value, bytes({0x37, 0x02}));
  EXPECT_EQ(b.port.requests.front(), bytes({0, 0x20, 0x40, 0x41, 0x60, 0, 0, 0, 0, 0}));
}

/// ETG.1000.6, 5.6.2.4.2: an expedited answer may leave out how many of its four bytes count (42h).
TEST(Sdo, an_expedited_answer_without_a_size_is_as_long_as_the_object_is_known_to_be) {
  const struct {
    config::ObjectType type;
    std::array<int, 4> data;
    std::int64_t value;
  } kRows[] = {
      {config::ObjectType::U8, {0x11, 0, 0, 0}, 0x11},
      {config::ObjectType::U8, {0xFE, 0, 0, 0}, 0xFE},
      {config::ObjectType::I8, {0xFE, 0, 0, 0}, -2},
      {config::ObjectType::I8, {0xFE, 0xFF, 0xFF, 0xFF}, -2},
      {config::ObjectType::I16, {0x00, 0x80, 0xFF, 0xFF}, -32768},
      {config::ObjectType::U16, {0x7C, 0x15, 0, 0}, 5500},
      {config::ObjectType::U16, {0x7C, 0x15, 0x01, 0}, 71036},   // it has 32 bits
      {config::ObjectType::I8, {0x7E, 0xFF, 0xFF, 0xFF}, -130},  // the same, and not 126
      {config::ObjectType::I32, {0xFE, 0xFF, 0xFF, 0xFF}, -2},
      {config::ObjectType::U32, {0xFE, 0xFF, 0xFF, 0xFF}, 0xFFFF'FFFE},
  };
  for (const auto& row : kRows) {
    Bench b;
    b.port.answer = [&](const Bytes&) {
      const auto& d = row.data;
      return std::vector<Bytes>{bytes({0, 0x30, 0x42, 0x00, 0x20, 0, d[0], d[1], d[2], d[3]})};
    };
    const auto value = read_number(b.link, b.station, {0x2000, 0}, row.type);
    ASSERT_TRUE(value) << to_text(value.error());
    EXPECT_EQ(*value, row.value);
  }
}

TEST(Sdo, a_download_of_two_bytes_has_the_bytes_of_the_standard) {
  Bench b;
  b.port.answer = [](const Bytes&) { return std::vector<Bytes>{bytes({0, 0x30, 0x60, 0x40, 0x60, 0, 0, 0, 0, 0})}; };
  ASSERT_TRUE(sdo_download(b.link, b.station, {0x6040, 0}, bytes({0x0F, 0x00})));
  EXPECT_EQ(b.port.requests.front(), bytes({0, 0x20, 0x2B, 0x40, 0x60, 0, 0x0F, 0, 0, 0}));
}

/// A station that holds one long object and serves it in segments, whatever its mailbox's size.
struct LongObject {
  Bytes value;
  std::size_t at = 0, room = 0;
  int toggle = 0;
  std::vector<Bytes> operator()(const Bytes& r) {
    const int command = std::to_integer<int>(r[2]);
    if (command == 0x40) {  // initiate upload: complete size, and what fits
      at = std::min(value.size(), room - 16);
      toggle = 0;
      Bytes out = bytes({0, 0x30, 0x41, 0x00, 0x20, 0, 0, 0, 0, 0});
      put_le<std::uint32_t>(out, 6, static_cast<std::uint32_t>(value.size()));
      out.insert(out.end(), value.begin(), value.begin() + static_cast<std::ptrdiff_t>(at));
      return {out};
    }
    if ((command & 0xE0) == 0x60) {  // upload segment
      if ((command & 0x10) != toggle) return {bytes({0, 0x20, 0x80, 0, 0x20, 0, 0, 0, 0x03, 0x05})};
      const std::size_t n = std::min(value.size() - at, room - 9);
      int c = toggle | (at + n == value.size() ? 1 : 0);
      if (n < 7) c |= static_cast<int>(7 - n) << 1;
      Bytes out = bytes({0, 0x30, c});
      out.insert(out.end(), value.begin() + static_cast<std::ptrdiff_t>(at),
                 value.begin() + static_cast<std::ptrdiff_t>(at + n));
      out.resize(std::max<std::size_t>(out.size(), 10));
      at += n;
      toggle ^= 0x10;
      return {out};
    }
    if (command == 0x21) {  // initiate download
      value.assign(r.begin() + 10, r.end());
      at = get_le<std::uint32_t>(r, 6);
      toggle = 0;
      return {bytes({0, 0x30, 0x60, 0x00, 0x20, 0, 0, 0, 0, 0})};
    }
    const std::size_t n = r.size() - 3 > 7 ? r.size() - 3 : 7u - static_cast<unsigned>(command >> 1 & 7);
    value.insert(value.end(), r.begin() + 3, r.begin() + 3 + static_cast<std::ptrdiff_t>(n));
    const Bytes out = bytes({0, 0x30, 0x20 | (command & 0x10), 0, 0, 0, 0, 0, 0, 0});
    return {out};
  }
};

TEST(Sdo, objects_of_any_length_pass_through_mailboxes_of_any_size_both_ways) {
  for (const std::size_t mailbox : {24u, 25u, 32u, 64u, 128u, 512u, 1486u})
    for (const std::size_t size : {5u, 7u, 8u, 13u, 22u, 64u, 100u, 1000u, 5000u}) {
      SCOPED_TRACE(testing::Message() << mailbox << " " << size);
      Bench b(mailbox);
      auto object = std::make_shared<LongObject>();
      object->room = mailbox;
      for (std::size_t i = 0; i < size; ++i) object->value.push_back(static_cast<std::byte>(i * 7));
      const Bytes truth = object->value;
      b.port.answer = [object](const Bytes& r) { return (*object)(r); };
      const auto value = sdo_upload(b.link, b.station, {0x2000, 0});
      ASSERT_TRUE(value) << to_text(value.error());
      EXPECT_EQ(*value, truth);
      Bytes other(size);
      for (std::size_t i = 0; i < size; ++i) other[i] = static_cast<std::byte>(i * 11 + 1);
      const auto done = sdo_download(b.link, b.station, {0x2000, 0}, other);
      ASSERT_TRUE(done) << to_text(done.error());
      EXPECT_EQ(object->value, other);
    }
}

// CiA 301, 7.2.4.3: whoever finds a transfer broken says so; the other side would wait for its next segment.
TEST(Sdo, a_broken_segmented_transfer_is_aborted_with_the_reason) {
  struct Case {
    const char* what;
    std::uint8_t spoil_command;  ///< XORed into the answer to the second segment
    bool upload;
    std::uint32_t code;
  };
  for (const Case& c :
       {Case{"toggle, upload", 0x10, true, 0x05030000}, Case{"command, upload", 0x40, true, 0x05040001},
        Case{"last too early", 0x01, true, 0x06070010}, Case{"toggle, download", 0x10, false, 0x05030000},
        Case{"command, download", 0x40, false, 0x05040001}}) {
    SCOPED_TRACE(c.what);
    Bench b(32);
    auto object = std::make_shared<LongObject>();
    object->room = 32;
    object->value.resize(200);
    auto segments = std::make_shared<int>(0);
    b.port.answer = [=](const Bytes& r) -> std::vector<Bytes> {
      if (r[2] == std::byte{0x80}) return {};  // an abort is not answered
      auto out = (*object)(r);
      const int command = std::to_integer<int>(r[2]) & 0xE0;
      const bool segment = command == 0x60 || command == 0x00;
      if (segment && ++*segments == 2) out.front()[2] ^= std::byte{c.spoil_command};
      return out;
    };
    const Bytes value(200, std::byte{1});
    const auto done = c.upload ? [&]() -> Result<void> {
      auto read = sdo_upload(b.link, b.station, {0x2000, 0});
      if (!read) return tl::unexpected(read.error());
      return {};
    }()
        : sdo_download(b.link, b.station, {0x2000, 0}, value);
    ASSERT_FALSE(done);
    EXPECT_EQ(done.error().fault, Fault::MailboxProtocol) << to_text(done.error());
    Bytes expected = bytes({0, 0x20, 0x80, 0x00, 0x20, 0, 0, 0, 0, 0});
    put_le<std::uint32_t>(expected, 6, c.code);
    EXPECT_EQ(b.port.requests.back(), expected);
  }
}

TEST(Sdo, an_emergency_in_the_middle_is_kept_and_disturbs_nothing) {
  Bench b;
  b.port.answer = [](const Bytes&) {
    return std::vector<Bytes>{bytes({0, 0x10, 0x10, 0x32, 0x04, 1, 2, 3, 4, 5}),  // 3210h, register 04h
                              bytes({0, 0x30, 0x4B, 0x41, 0x60, 0, 0x37, 0x02, 0, 0})};
  };
  const auto value = sdo_upload(b.link, b.station, {0x6041, 0});
  ASSERT_TRUE(value) << to_text(value.error());
  EXPECT_EQ(*value, bytes({0x37, 0x02}));
  ASSERT_EQ(b.station.mailbox.emergencies.size(), 1u);
  EXPECT_EQ(b.station.mailbox.emergencies[0].code, 0x3210);
  EXPECT_EQ(b.station.mailbox.emergencies[0].error_register, 4);
  EXPECT_EQ(b.station.mailbox.emergencies[0].data[4], 5);
}

TEST(Sdo, endless_emergencies_end_in_a_named_error) {
  Bench b;
  const auto emergency = bytes({0, 0x10, 0x10, 0x32, 0x04, 1, 2, 3, 4, 5});
  b.port.answer = [&](const Bytes&) { return std::vector<Bytes>(200'000, emergency); };
  const Time begin = b.clock.now();
  const auto value = sdo_upload(b.link, b.station, {0x6041, 0});
  ASSERT_FALSE(value);
  EXPECT_EQ(value.error().fault, Fault::MailboxTimeout);
  EXPECT_LT(b.clock.now() - begin, milliseconds(1500));
  EXPECT_EQ(b.station.mailbox.emergencies.size(), MailboxState::kMostEmergencies);
}

TEST(Sdo, a_lost_reply_is_asked_for_again_and_the_request_is_not_carried_out_twice) {
  for (int n = 0; n < 6; ++n) {
    Bench b;
    b.port.lose_read = n;
    b.port.answer = [](const Bytes& r) {
      Bytes out = bytes({0, 0x30, 0x43, 0, 0, 0, 0, 0, 0, 0});
      std::copy(r.begin() + 3, r.begin() + 6, out.begin() + 3);
      out[6] = r[3];  // the value tells the index
      return std::vector<Bytes>{out};
    };
    for (int i = 0; i < 6; ++i) {
      const auto value = sdo_upload(b.link, b.station, {static_cast<std::uint16_t>(0x2000 + i), 0});
      ASSERT_TRUE(value) << n << ": " << to_text(value.error());
      EXPECT_EQ((*value)[0], static_cast<std::byte>(i));
    }
    EXPECT_EQ(b.port.repeats, 1);
    EXPECT_EQ(b.port.requests.size(), 6u);
  }
}

// The repeat request is optional. Without it a read that was lost on its way out is done again; a reply that was lost
// on its way back is gone, and that is told.
TEST(Sdo, a_station_without_repeat_is_read_again_while_its_mailbox_is_full) {
  for (const bool knows_repeat : {true, false})
    for (const bool on_the_way_out : {true, false})
      for (int n = 0; n < 6; ++n) {
        SCOPED_TRACE(testing::Message() << knows_repeat << on_the_way_out << n);
        Bench b;
        b.port.knows_repeat = knows_repeat;
        (on_the_way_out ? b.port.lose_look : b.port.lose_read) = n;
        b.port.answer = [](const Bytes& r) {
          Bytes out = bytes({0, 0x30, 0x43, 0, 0, 0, 0, 0, 0, 0});
          std::copy(r.begin() + 3, r.begin() + 6, out.begin() + 3);
          out[6] = r[3];
          return std::vector<Bytes>{bytes({0, 0x10, 0x10, 0x32, 0x04, 1, 2, 3, 4, 5}), out};  // an emergency in front
        };
        const bool gone = !knows_repeat && !on_the_way_out;
        for (int i = 0; i < 3; ++i) {
          const Time begin = b.clock.now();
          const auto value = sdo_upload(b.link, b.station, {static_cast<std::uint16_t>(0x2000 + i), 0});
          EXPECT_LT(b.clock.now() - begin, milliseconds(1200));
          if (!gone) {
            ASSERT_TRUE(value) << to_text(value.error());
          } else if (!value) {
            EXPECT_EQ(value.error().fault, Fault::MailboxTimeout);
          }
          if (value) {
            EXPECT_EQ((*value)[0], static_cast<std::byte>(i));
          }
        }
        if (!gone) {
          EXPECT_EQ(b.port.requests.size(), 3u);
          EXPECT_EQ(b.station.mailbox.emergencies.size(), 3u);
        }
      }
}

TEST(Sdo, request_counters_run_1_to_7_and_reply_counters_are_their_own) {
  for (const int kind : {0, 1, 2}) {
    Bench b;
    if (kind == 1) b.port.next_counter = [] { return std::uint8_t{0}; };  // a station that counts nothing
    if (kind == 2) b.port.next_counter = [] { return std::uint8_t{3}; };  // and one that always says the same
    b.port.answer = [](const Bytes&) { return std::vector<Bytes>{bytes({0, 0x30, 0x4F, 0x61, 0x60, 0, 8, 0, 0, 0})}; };
    for (int i = 0; i < 16; ++i) ASSERT_TRUE(sdo_upload(b.link, b.station, {0x6061, 0})) << kind;
    EXPECT_EQ(b.port.request_counters, (std::vector<std::uint8_t>{1, 2, 3, 4, 5, 6, 7, 1, 2, 3, 4, 5, 6, 7, 1, 2}));
  }
}

TEST(Sdo, answers_to_requests_that_were_given_up_are_passed_over) {
  for (const int strays : {1, 5, 15, 16, 1000}) {
    Bench b;
    b.port.answer = [&](const Bytes&) {
      std::vector<Bytes> all(static_cast<std::size_t>(strays), bytes({0, 0x30, 0x4B, 0x61, 0x60, 0, 8, 0, 0, 0}));
      all.push_back(bytes({0, 0x30, 0x4B, 0x41, 0x60, 0, 0x37, 0x02, 0, 0}));
      return all;
    };
    const auto value = sdo_upload(b.link, b.station, {0x6041, 0});
    ASSERT_EQ(value.has_value(), strays < 16) << strays;
    if (value) {
      EXPECT_EQ(*value, bytes({0x37, 0x02}));
    } else {
      EXPECT_EQ(value.error().fault, Fault::MailboxProtocol);
    }
  }
}

/// A station that gives each answer twice: the second one is never taken for the answer to what is asked next, whether
/// that is another object, or the same one.
TEST(Sdo, an_answer_that_comes_twice_is_not_taken_for_another) {
  Bench b;
  int value = 0;
  b.port.answer = [&](const Bytes& r) {
    Bytes out = bytes({0, 0x30, 0x4B, 0, 0, 0, 0, 0, 0, 0});
    std::copy(r.begin() + 3, r.begin() + 6, out.begin() + 3);
    if ((std::to_integer<int>(r[2]) & 0xE0) == 0x20)
      out[2] = std::byte{0x60}, value = std::to_integer<int>(r[6]);
    else
      out[6] = static_cast<std::byte>(value);
    return std::vector<Bytes>{out, out};
  };
  ASSERT_TRUE(sdo_upload(b.link, b.station, {0x6041, 0}));  // as a master does that has just come: another object first
  for (int i = 1; i < 40; ++i) {
    SCOPED_TRACE(i);
    ASSERT_TRUE(sdo_download(b.link, b.station, {0x2000, 0}, bytes({i, 0})));
    for (int k = 0; k < 3; ++k) {
      const auto read = sdo_upload(b.link, b.station, {0x2000, 0});
      ASSERT_TRUE(read) << to_text(read.error());
      EXPECT_EQ(*read, bytes({i, 0}));
    }
  }
}

// The counter that another master used last is not known; a station drops a request that carries it.
TEST(Sdo, a_mailbox_that_another_master_has_used_answers_whatever_was_counted_last) {
  using Repeats = MailboxStation::Repeats;
  for (const auto habit : {Repeats::Taken, Repeats::ZeroForgets, Repeats::ZeroKeeps, Repeats::ZeroDropped})
    for (std::uint8_t last = 0; last <= 7; ++last) {
      SCOPED_TRACE(testing::Message() << static_cast<int>(habit) << " " << static_cast<int>(last));
      Bench b;
      b.port.repeats_are = habit;
      b.port.last_counter = last;
      b.station.mailbox.count = MailboxState::Count::Foreign;
      b.port.answer = [](const Bytes&) {
        return std::vector<Bytes>{bytes({0, 0x30, 0x4F, 0x61, 0x60, 0, 8, 0, 0, 0})};
      };
      const Time start = b.clock.now();
      for (int i = 0; i < 10; ++i) {
        const auto value = sdo_upload(b.link, b.station, {0x6061, 0});
        ASSERT_TRUE(value) << i << ": " << to_text(value.error());
      }
      EXPECT_EQ(b.station.mailbox.count, MailboxState::Count::Ours);
      EXPECT_LT(b.clock.now() - start, milliseconds(2100));
      // One that does as the standard says is not kept waiting for the first answer.
      if (habit != Repeats::ZeroDropped) {
        EXPECT_EQ(b.port.request_counters.front(), 0);
      }
      // And one that never answers is given up in bounded time.
      b.station.mailbox = {};
      b.station.mailbox.count = MailboxState::Count::Foreign;
      b.port.answer = [](const Bytes&) { return std::vector<Bytes>{}; };
      const Time begin = b.clock.now();
      EXPECT_EQ(sdo_upload(b.link, b.station, {0x6061, 0}).error().fault, Fault::MailboxTimeout);
      EXPECT_LT(b.clock.now() - begin, milliseconds(3100));
    }
}

TEST(Sdo, complete_access_that_is_refused_falls_back_to_single_sub_indices) {
  Bench b;
  std::map<int, Bytes> object{{0, bytes({2})}, {1, bytes({0x11, 0x22})}, {2, bytes({0x33, 0x44, 0x55, 0x66})}};
  b.port.answer = [&](const Bytes& r) -> std::vector<Bytes> {
    const int command = std::to_integer<int>(r[2]), sub = std::to_integer<int>(r[5]);
    if ((command & 0x10) != 0) return {bytes({0, 0x20, 0x80, 0x18, 0x10, sub, 0x04, 0x00, 0x01, 0x06})};
    Bytes out = bytes({0, 0x30, 0x60, 0x18, 0x10, sub, 0, 0, 0, 0});
    if ((command & 0xE0) == 0x40) {
      const Bytes& v = object[sub];
      out[2] = static_cast<std::byte>(0x43 | (4 - v.size()) << 2);
      std::copy(v.begin(), v.end(), out.begin() + 6);
    } else {
      object[sub] = Bytes(r.begin() + 6, r.begin() + 6 + (4 - (command >> 2 & 3)));
    }
    return {out};
  };
  const auto all = sdo_upload(b.link, b.station, {0x1018, 0}, SdoAccess::Complete);
  ASSERT_TRUE(all) << to_text(all.error());
  EXPECT_EQ(*all, bytes({2, 0, 0x11, 0x22, 0x33, 0x44, 0x55, 0x66}));
  const auto done = sdo_download(b.link, b.station, {0x1018, 0}, bytes({2, 0, 9, 8, 7, 6, 5, 4}), SdoAccess::Complete);
  ASSERT_TRUE(done) << to_text(done.error());
  EXPECT_EQ(object[1], bytes({9, 8}));
  EXPECT_EQ(object[2], bytes({7, 6, 5, 4}));
  EXPECT_EQ(object[0], bytes({2}));
}

TEST(Sdo, an_abort_is_told_with_its_code_and_text) {
  Bench b;
  b.port.answer = [](const Bytes&) {
    return std::vector<Bytes>{bytes({0, 0x20, 0x80, 0x41, 0x60, 0, 0x02, 0, 0x01, 0x06})};
  };
  const auto value = sdo_upload(b.link, b.station, {0x6041, 0});
  ASSERT_FALSE(value);
  EXPECT_EQ(value.error().fault, Fault::SdoAbort);
  EXPECT_NE(value.error().message.find("06010002h"), std::string::npos);
  EXPECT_NE(value.error().message.find("read-only"), std::string::npos);
}

TEST(SdoInfo, an_object_list_comes_in_fragments) {
  Bench b(64);
  b.port.answer = [](const Bytes& r) {
    EXPECT_EQ(r, bytes({0, 0x80, 1, 0, 0, 0, 1, 0}));  // OD list request, all objects
    return std::vector<Bytes>{bytes({0, 0x80, 0x82, 0, 1, 0, 1, 0, 0x00, 0x10, 0x18, 0x10}),
                              bytes({0, 0x10, 0x10, 0x32, 0x04, 1, 2, 3, 4, 5}),  // an emergency between them
                              bytes({0, 0x80, 0x02, 0, 0, 0, 0x40, 0x60, 0x41, 0x60})};
  };
  const auto list = read_object_indices(b.link, b.station, sdo_info::kListAll);
  ASSERT_TRUE(list) << to_text(list.error());
  EXPECT_EQ(*list, (std::vector<std::uint16_t>{0x1000, 0x1018, 0x6040, 0x6041}));
  EXPECT_EQ(b.station.mailbox.emergencies.size(), 1u);
}

TEST(SdoInfo, objects_and_entries_are_described) {
  Bench b;
  b.port.answer = [](const Bytes& r) {
    if (r[2] == std::byte{3})
      return std::vector<Bytes>{
          bytes({0, 0x80, 4, 0, 0, 0, 0x18, 0x10, 0x23, 0, 4, 9, 'I', 'd', 'e', 'n', 't', 'i', 't', 'y'})};
    return std::vector<Bytes>{
        bytes({0, 0x80, 6, 0, 0, 0, 0x18, 0x10, 1, 0, 7, 0, 32, 0, 7, 0, 'V', 'e', 'n', 'd', 'o', 'r'})};
  };
  const auto object = describe_object(b.link, b.station, 0x1018);
  ASSERT_TRUE(object) << to_text(object.error());
  EXPECT_EQ(object->name, "Identity");
  EXPECT_EQ(object->max_sub, 4);
  EXPECT_EQ(object->code, sdo_info::kCodeRecord);
  EXPECT_EQ(object->data_type, 0x0023) << "IDENTITY, ETG.1000.6, table 64";
  const auto entry = describe_entry(b.link, b.station, {0x1018, 1});
  ASSERT_TRUE(entry) << to_text(entry.error());
  EXPECT_EQ(entry->name, "Vendor");
  EXPECT_EQ(entry->bit_length, 32);
  EXPECT_EQ(entry->access, sdo_info::kAccessRead);
  EXPECT_EQ(entry->data_type, 0x0007) << "UNSIGNED32";
}

TEST(SdoInfo, an_object_that_is_listed_and_not_described_does_not_hide_the_others) {
  Bench b;
  b.port.answer = [](const Bytes& r) {
    if (r[2] == std::byte{1})
      return std::vector<Bytes>{bytes({0, 0x80, 2, 0, 0, 0, 1, 0, 0x00, 0x10, 0x01, 0x20, 0x18, 0x10})};
    if (r[2] == std::byte{3} && r[6] == std::byte{0x01})  // 2001h: there is none, says the station now
      return std::vector<Bytes>{bytes({0, 0x80, 7, 0, 0, 0, 0x00, 0x00, 0x02, 0x06})};
    if (r[2] == std::byte{3})
      return std::vector<Bytes>{
          bytes({0, 0x80, 4, 0, 0, 0, std::to_integer<int>(r[6]), std::to_integer<int>(r[7]), 7, 0, 0, 7, 'o', 'k'})};
    return std::vector<Bytes>{bytes(
        {0, 0x80, 6, 0, 0, 0, std::to_integer<int>(r[6]), std::to_integer<int>(r[7]), 0, 0, 7, 0, 32, 0, 7, 0, 'v'})};
  };
  const auto list = read_object_list(b.link, b.station, true);
  ASSERT_TRUE(list) << to_text(list.error());
  ASSERT_EQ(list->size(), 3u);
  EXPECT_EQ((*list)[0].name, "ok");
  EXPECT_EQ((*list)[1].index, 0x2001);
  EXPECT_NE((*list)[1].refused.find("06020000h"), std::string::npos) << (*list)[1].refused;
  EXPECT_EQ((*list)[2].index, 0x1018);
  EXPECT_EQ((*list)[2].entries.size(), 1u);
  EXPECT_EQ((*list)[2].refused, "");
}

TEST(SdoInfo, an_error_answer_is_told) {
  Bench b;
  b.port.answer = [](const Bytes&) { return std::vector<Bytes>{bytes({0, 0x80, 7, 0, 0, 0, 0x00, 0x00, 0x02, 0x06})}; };
  const auto object = describe_object(b.link, b.station, 0x5FFF);
  ASSERT_FALSE(object);
  EXPECT_EQ(object.error().fault, Fault::SdoAbort);
  EXPECT_NE(object.error().message.find("does not exist"), std::string::npos);
}

}  // namespace
}  // namespace gantry::devices
