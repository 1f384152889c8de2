#include "devices/rt/cyclic.hpp"

#include <algorithm>

namespace gantry::devices {
namespace {

using namespace wire;

constexpr std::size_t kFramesLookedAt = 64;  // in one cycle: old and foreign frames must not hold the loop
constexpr int kSinglyCycles = 100;           // after the last wrong working counter
constexpr std::size_t kAlStatusBytes = 6;    // 0130h with the code in 0134h

}  // namespace

Cyclic::Cyclic(const CyclicLayout& layout, std::span<const std::byte> outputs, std::span<std::byte> inputs) noexcept
    : layout_(layout), outputs_(outputs), inputs_(inputs), dc_time_(layout.dc_time_ns) {
  layout_.stations = layout_.stations.first(std::min(layout_.stations.size(), kMaxCyclicStations));
  for (Frame& frame : frames_) frame.set_source(layout.source);
  spare_.set_source(layout.source);
  plan(together_, CyclicLayout::kMaxBytes);
  plan(singly_, 0);
  fresh_.set();
}

/// Regions that lie side by side and are reached by the same commands share a datagram of at most this size, or have
/// one each (0).
void Cyclic::plan(Parts& parts, std::size_t most_bytes) noexcept {
  const auto& stations = layout_.stations;
  for (std::size_t first = 0; first < stations.size();) {
    if (stations[first].region_bytes == 0) {
      ++first;
      continue;
    }
    Part lrw{Command::Lrw, static_cast<std::uint16_t>(first), 0, 0, 0};
    Part lwr = lrw, lrd = lrw;
    lwr.command = Command::Lwr, lrd.command = Command::Lrd;
    std::size_t i = first, bytes = 0;
    for (; i < stations.size(); ++i) {
      const CyclicStation& s = stations[i];
      if (i > first && (s.lrw != stations[first].lrw || bytes + s.region_bytes > most_bytes)) break;
      bytes += s.region_bytes;
      if (s.output_bytes > 0) lrw.expected += kWkcReadWriteWrite, ++lwr.expected;
      if (s.input_bytes > 0) lrw.expected += kWkcReadWriteRead, ++lrd.expected;
    }
    for (Part* p : {&lrw, &lwr, &lrd}) {
      p->count = static_cast<std::uint16_t>(i - first);
      p->bytes = static_cast<std::uint16_t>(bytes);
    }
    if (stations[first].lrw) {
      parts.push_back(lrw);
    } else {
      if (lwr.expected > 0) parts.push_back(lwr);
      if (lrd.expected > 0) parts.push_back(lrd);
    }
    first = i;
  }
}

void Cyclic::prepare() noexcept {
  if (prepared_) return;
  prepared_ = true;
  used_ = answers_ = 0;
  rider_frame_ = kMaxFrames;
  answered_.reset();
  untouched_.reset();
  frames_[used_++].start(++sequence_);
  add_common(frames_[0]);
  parts_ = singly_left_ > 0 ? &singly_ : &together_;
  for (std::size_t i = 0; i < parts_->size(); ++i) {
    const Part& part = (*parts_)[i];
    if (part.bytes > frames_[used_ - 1].room() && !open_frame()) {
      placed_[i] = {};
      continue;
    }
    placed_[i] = {used_ - 1, frames_[used_ - 1].add(part.command, layout_.stations[part.first].logical, part.bytes)};
  }
}

/// What is known only when the frames go out: the outputs, and what rides along.
void Cyclic::load(AcyclicSlot& acyclic) noexcept {
  for (std::size_t i = 0; i < parts_->size(); ++i) {
    const Part& part = (*parts_)[i];
    const Placed& placed = placed_[i];
    if (placed.slot != kNoSlot && part.command != Command::Lrd)
      fill(part, outputs_, frames_[placed.frame].data(placed.slot));
  }
  if (!acyclic.waiting()) return;
  if (!acyclic.ride(frames_[used_ - 1])) {  // then in a frame of its own, which takes any
    if (used_ == kMaxFrames) return;
    frames_[used_].start(++sequence_);
    if (!acyclic.ride(frames_[used_])) return;
    frames_[used_++].add_sequence();
  }
  rider_frame_ = used_ - 1;
}

/// What the first frame of a cycle carries beside process data.
void Cyclic::add_common(Frame& frame) noexcept {
  clock_ = errors_ = difference_ = mailbox_ = al_status_ = kNoSlot;
  states_ = frame.add(Command::Brd, physical_address(0, reg::kAlStatus), 2);
  if (layout_.reference_address != 0 && fresh_[layout_.reference_station])
    clock_ = frame.add(Command::Frmw, physical_address(layout_.reference_address, reg::kDcSystemTime),
                       layout_.reference_wide ? 8 : 4);
  if (!layout_.roll || layout_.stations.empty() || clock_ == kNoSlot) frame.add_sequence();
  if (!layout_.roll || layout_.stations.empty()) return;
  rolled_ = rolled_ + 1 < layout_.stations.size() ? rolled_ + 1 : 0;
  const CyclicStation& s = layout_.stations[rolled_];
  errors_ = frame.add(Command::Fprd, physical_address(s.address, reg::kRxErrorCounters), reg::kErrorCounterBytes);
  if (s.clock) difference_ = frame.add(Command::Fprd, physical_address(s.address, reg::kDcSystemTimeDifference), 4);
  if (s.mailbox_status != 0) mailbox_ = frame.add(Command::Fprd, physical_address(s.address, s.mailbox_status), 1);
  if (!all_in_op_) al_status_ = frame.add(Command::Fprd, physical_address(s.address, reg::kAlStatus), kAlStatusBytes);
}

/// The next frame of process data.
bool Cyclic::open_frame() noexcept {
  if (used_ == kMaxFrames) return false;
  frames_[used_].start(++sequence_);
  frames_[used_++].add_sequence();
  return true;
}

void Cyclic::fill(const Part& part, std::span<const std::byte> outputs, std::span<std::byte> data) const noexcept {
  const std::uint32_t base = layout_.stations[part.first].logical;
  for (const CyclicStation& s : layout_.stations.subspan(part.first, part.count))
    std::copy_n(outputs.begin() + s.output_offset, s.output_bytes,
                data.begin() + static_cast<std::ptrdiff_t>(s.logical - base + s.output_at));
}

std::size_t Cyclic::spare_frames(std::span<const std::byte> outputs, std::span<FrameBytes> frames) noexcept {
  constexpr std::uint32_t kHalfRound = 0x8080'8080;  // of each byte that becomes an index
  std::size_t count = 0;
  const auto open = [&] {
    spare_.start((sequence_ + 1 + static_cast<std::uint32_t>(count)) ^ kHalfRound);
    spare_.add_sequence();
  };
  const auto close = [&] {
    if (count == frames.size()) return false;
    const auto bytes = spare_.bytes();
    std::copy(bytes.begin(), bytes.end(), frames[count].bytes.begin());
    frames[count++].size = bytes.size();
    return true;
  };
  bool any = false;
  open();
  for (const Part& part : together_) {
    if (part.command == Command::Lrd) continue;
    if (part.bytes > spare_.room()) {
      if (!close()) return 0;
      open();
    }
    const SlotIndex slot = spare_.add(part.command, layout_.stations[part.first].logical, part.bytes);
    if (slot == kNoSlot) return 0;
    fill(part, outputs, spare_.data(slot));
    any = true;
  }
  return any && close() ? count : 0;
}

/// Sorts in what was received; true when it is the answer to a frame of this cycle.
bool Cyclic::take(std::span<const std::byte> received) noexcept {
  bool late = false, malformed = false, untouched = false, duplicate = false;
  for (std::size_t i = 0; i < used_; ++i) {
    Reply reply;
    switch (match(frames_[i], received, reply)) {
      case Match::Ours:
        if (answered_[i]) {
          duplicate = true;
          break;
        }
        replies_[i] = reply;
        answered_[i] = true;
        return true;
      case Match::Unprocessed:
        untouched = true;
        untouched_[i] = true;
        break;
      case Match::Late: late = true; break;
      case Match::Malformed: malformed = true; break;
      case Match::Foreign: break;
    }
  }
  if (late && !duplicate) duplicate = was_answered(received);
  if (!untouched && !duplicate && !malformed && !late) note_sender(received);
  ++(untouched   ? counts_.untouched
     : duplicate ? counts_.duplicate
     : malformed ? counts_.malformed
     : late      ? counts_.late
                 : counts_.foreign);
  return false;
}

void Cyclic::note_sender(std::span<const std::byte> received) noexcept {
  const auto sender = sender_of(received);
  if (!sender) return;
  senders_.heard(*sender, sequence_);
  if (!senders_.other()) return;
  std::uint64_t address = 0;
  for (const std::byte b : senders_.other()->address) address = address << 8 | std::to_integer<std::uint64_t>(b);
  other_address_.store(address, std::memory_order_relaxed);
  other_frames_.store(senders_.other()->frames, std::memory_order_release);
}

std::optional<OtherMaster> Cyclic::other_master() const noexcept {
  OtherMaster other{.frames = other_frames_.load(std::memory_order_acquire)};
  if (other.frames == 0) return std::nullopt;
  std::uint64_t address = other_address_.load(std::memory_order_relaxed);
  for (std::size_t i = other.address.size(); i-- > 0; address >>= 8)
    other.address[i] = static_cast<std::byte>(address & 0xFF);
  return other;
}

/// Whether it is a copy of a frame of the last cycles whose answer was taken then. The first two index fields of a
/// frame are the low bytes of its sequence (see Frame::start()).
bool Cyclic::was_answered(std::span<const std::byte> received) const noexcept {
  if (received.size() < kFrameHeader + kDatagramHeader) return false;
  const auto first = get_datagram_header(received.subspan(kFrameHeader));
  const std::size_t second_at = kFrameHeader + kDatagramHeader + first.length + kWorkingCounter;
  if (!first.more || received.size() < second_at + kDatagramHeader) return false;
  const auto low =
      static_cast<std::uint16_t>(first.index | get_datagram_header(received.subspan(second_at)).index << 8);
  const auto age = static_cast<std::uint16_t>(sequence_ - low);
  return age >= used_ && age < kRemembered && answered_before_[low % kRemembered];
}

/// Books what has become of this cycle's frames.
void Cyclic::end_cycle() noexcept {
  for (std::size_t i = 0; i < used_; ++i) {
    answered_before_[(sequence_ - used_ + 1 + i) % kRemembered] = answered_[i];
    if (!answered_[i] && !untouched_[i]) ++counts_.lost;
  }
}

CyclicCounts Cyclic::counters() const noexcept {
  CountWords words;
  for (std::size_t i = 0; i < words.size(); ++i) words[i] = published_counts_[i].load(std::memory_order_relaxed);
  return std::bit_cast<CyclicCounts>(words);
}

Exchange Cyclic::run(FramePort& port, AcyclicSlot& acyclic, Time deadline) noexcept {
  prepare();
  prepared_ = false;
  load(acyclic);
  std::size_t sent = 0;
  for (std::size_t i = 0; i < used_; ++i) {
    const bool ok = port.send(PortIndex::Primary, frames_[i].bytes());
    ++(ok ? counts_.sent : counts_.not_sent);
    if (ok) ++sent;
  }
  for (std::size_t looked = 0; answers_ < sent && looked < kFramesLookedAt + used_ - 1; ++looked) {
    const Received got = port.receive(received_[answers_], deadline);
    if (got.size == 0) break;
    if (take(std::span<const std::byte>(received_[answers_]).first(std::min(got.size, kMaxFrameBytes)))) ++answers_;
  }
  if (rider_frame_ < kMaxFrames) {
    if (answered_[rider_frame_])
      acyclic.answer(replies_[rider_frame_]);
    else
      acyclic.lose();
  }
  end_cycle();
  Exchange e = judge();
  if (const std::size_t back = (answered_ | untouched_).count(); back < used_) {
    e.fault = port.link_up(PortIndex::Primary) ? Fault::FrameLost : Fault::BusDown;
    e.inputs_fresh = false;
  }
  const auto words = std::bit_cast<CountWords>(counts_);
  for (std::size_t i = 0; i < words.size(); ++i) published_counts_[i].store(words[i], std::memory_order_relaxed);
  return e;
}

Exchange Cyclic::judge() noexcept {
  Exchange e;
  bool low = false, high = false;
  e.inputs_fresh = true;
  fresh_.set();
  for (std::size_t i = 0; i < parts_->size(); ++i) {
    const Part& part = (*parts_)[i];
    e.ethercat.expected = static_cast<std::uint16_t>(e.ethercat.expected + part.expected);
    const auto [frame, slot] = placed_[i];
    const bool answered = slot != kNoSlot && answered_[frame];
    const bool back = answered || (slot != kNoSlot && untouched_[frame]);
    const std::uint16_t counter = answered ? replies_[frame].working_counter(slot) : std::uint16_t{0};
    e.ethercat.working_counter = static_cast<std::uint16_t>(e.ethercat.working_counter + counter);
    low |= back && counter < part.expected;
    high |= answered && counter > part.expected;
    if (!answered || counter != part.expected) e.inputs_fresh = false;
    for (std::size_t k = 0; k < part.count; ++k) {
      const std::size_t station = part.first + k;
      if (!answered || counter != part.expected) fresh_[station] = false;
      if (back && counter != part.expected && parts_ == &singly_) ++health_[station].stale_cycles;
    }
  }
  publish_fresh();
  // Inputs last: a station without LRW is fresh only when both its datagrams were answered in full.
  for (std::size_t i = 0; i < parts_->size(); ++i) take_inputs((*parts_)[i], placed_[i]);

  if (answered_[0]) {
    const Reply& first = replies_[0];
    const std::uint16_t seen = first.working_counter(states_);
    e.ethercat.al_states = get_le<std::uint16_t>(first.data(states_), 0);
    all_in_op_ = e.operational = all_in_op(e.ethercat.al_states);
    low |= seen < layout_.stations_on_bus;
    high |= seen > layout_.stations_on_bus;
    if (clock_ != kNoSlot && first.working_counter(clock_) != 0) e.reference_ns = read_clock(first.data(clock_));
    look(first, e);
  }
  if ((untouched_ & ~answered_).any()) low = true, e.inputs_fresh = false;  // where nobody has process data, too
  judge_counters(e, low, high);
  e.complete = e.ethercat.working_counter >= e.ethercat.expected;
  e.detail = e.fault == Fault::None ? e.ethercat.al_states : e.ethercat.working_counter;
  return e;
}

void Cyclic::judge_counters(Exchange& e, bool low, bool high) noexcept {
  if (high)
    e.fault = Fault::TooManyTookPart;
  else if (low)
    e.fault = Fault::TooFewTookPart;
  const bool nobody = e.ethercat.working_counter == 0 && e.ethercat.expected != 0;
  if ((low || high) && (answered_ | untouched_).count() == used_)  // where frames are missing, that is what happened
    ++(high ? counts_.wkc_high : nobody ? counts_.wkc_zero : counts_.wkc_low);
  if (low || high)
    singly_left_ = kSinglyCycles;
  else if (singly_left_ > 0 && answers_ == used_)
    --singly_left_;
}

void Cyclic::publish_fresh() noexcept {
  for (std::size_t w = 0; w < published_fresh_.size(); ++w) {
    std::uint64_t word = 0;
    for (std::size_t i = 64 * w; i < std::min(layout_.stations.size(), 64 * (w + 1)); ++i)
      word |= std::uint64_t{fresh_[i]} << (i % 64);
    published_fresh_[w].store(word, std::memory_order_relaxed);
  }
  cycles_.fetch_add(1, std::memory_order_release);
}

void Cyclic::take_inputs(const Part& part, const Placed& placed) noexcept {
  if (part.command == Command::Lwr || placed.slot == kNoSlot || !answered_[placed.frame]) return;
  const auto data = replies_[placed.frame].data(placed.slot);
  const std::uint32_t base = layout_.stations[part.first].logical;
  for (std::size_t k = 0; k < part.count; ++k) {
    const CyclicStation& s = layout_.stations[part.first + k];
    if (!fresh_[part.first + k]) continue;
    std::copy_n(data.begin() + static_cast<std::ptrdiff_t>(s.logical - base + s.input_at), s.input_bytes,
                inputs_.begin() + s.input_offset);
  }
}

/// A clock of 32 bits wraps every 4.3 s; what it says is continued.
std::uint64_t Cyclic::read_clock(std::span<const std::byte> data) noexcept {
  if (layout_.reference_wide) return get_le<std::uint64_t>(data, 0);
  const auto step = static_cast<std::int32_t>(get_le<std::uint32_t>(data, 0) - static_cast<std::uint32_t>(dc_time_));
  dc_time_ += static_cast<std::uint64_t>(std::int64_t{step});
  return dc_time_;
}

/// What this cycle's look at one station has shown. Of one that is silent, that it did not take part.
void Cyclic::look(const Reply& first, Exchange& e) noexcept {
  if (errors_ == kNoSlot) return;
  StationHealth& h = health_[rolled_];
  if (first.working_counter(errors_) != kWkcRead) return published_[rolled_].store(h);
  ++h.looks;
  const auto errors = first.data(errors_);
  std::copy(errors.begin(), errors.end(), h.errors.begin());
  if (difference_ != kNoSlot && first.working_counter(difference_) == kWkcRead) {
    h.dc_difference_ns = dc_difference_ns(get_le<std::uint32_t>(first.data(difference_), 0));
    const auto size = static_cast<std::uint32_t>(h.dc_difference_ns < 0 ? -h.dc_difference_ns : h.dc_difference_ns);
    h.dc_difference_max_ns = std::max(h.dc_difference_max_ns, size);
    e.clock_station = layout_.stations[rolled_].id;
    e.clock_seen = true;
    e.clock_ns = h.dc_difference_ns;
  }
  if (mailbox_ != kNoSlot && first.working_counter(mailbox_) == kWkcRead)
    h.mailbox_waiting = (get_le<std::uint8_t>(first.data(mailbox_), 0) & kSmStatusMailboxFull) != 0;
  if (al_status_ != kNoSlot && first.working_counter(al_status_) == kWkcRead) {
    h.al_status = get_le<std::uint16_t>(first.data(al_status_), 0);
    h.al_code = get_le<std::uint16_t>(first.data(al_status_), 4);
    h.al_cycle = cycles_.load(std::memory_order_relaxed);
  }
  published_[rolled_].store(h);
}

}  // namespace gantry::devices
