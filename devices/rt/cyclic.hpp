// The cyclic exchange. Every station has a region of the logical map, one behind the other; a frame carries LRW over as
// many regions as it holds (LWR and LRD where a station cannot LRW), the first one also FRMW 0910h (the reference
// clock's time goes to all the others), BRD 0130h (AL states of all stations OR-ed), what is looked at of one station a
// cycle in turn (error counters, 092Ch, mailbox; while not all are in OP also its AL status), and whatever rides in the
// AcyclicSlot. A map that needs several
// frames goes out in several, all in one cycle.
//   Cyclic cyclic(layout, outputs, inputs);
//   const Exchange e = cyclic.run(port, acyclic, deadline);   cyclic.fresh(i)
// A datagram's inputs are taken only when its working counter is the expected one. When one is not, the following
// cycles have a datagram for every station, so that it shows who does not take part, and the others go on exchanging.
// Lives in the RT loop.
#pragma once
#include <array>
#include <atomic>
#include <bit>
#include <bitset>
#include <cstdint>
#include <optional>
#include <span>

#include "core/rt/fixed_vector.hpp"
#include "core/rt/latest.hpp"
#include "devices/bus.hpp"
#include "devices/frame_port.hpp"
#include "devices/rt/acyclic.hpp"
#include "devices/rt/cyclic_counts.hpp"
#include "devices/rt/frame.hpp"
#include "devices/rt/sender_watch.hpp"

namespace gantry::devices {

inline constexpr std::size_t kMaxCyclicStations = 128;

/// One station's part of a cycle.
struct CyclicStation {
  StationId id{};
  std::uint16_t address = 0;
  std::uint32_t logical = 0;                  ///< first address of its region
  std::uint16_t region_bytes = 0;             ///< 0: it has no process data
  std::uint16_t output_at = 0, input_at = 0;  ///< in the region
  std::uint16_t output_bytes = 0, input_bytes = 0;
  std::uint32_t output_offset = 0, input_offset = 0;  ///< in the images
  bool lrw = true;
  bool clock = false;                ///< has 092Ch
  std::uint16_t mailbox_status = 0;  ///< register that shows whether its mailbox has something; 0: no mailbox
};

struct CyclicLayout {
  std::span<const CyclicStation> stations;  ///< in the order of the regions; outlives the Cyclic
  std::uint16_t reference_address = 0;      ///< station address of the reference clock; 0: none
  std::size_t reference_station = 0;        ///< its index: while that is stale, its time is not spread
  bool reference_wide = true;               ///< it counts 64 bits; otherwise 32, and dc_time_ns continues `dc_time_ns`
  std::uint64_t dc_time_ns = 0;             ///< of the reference clock, about now
  std::uint16_t stations_on_bus = 0;        ///< expected of the BRD
  bool roll = true;                         ///< look at one station a cycle
  SourceAddress source = kUsualSource;      ///< of its frames
  /// Data bytes of one LRW.
  static constexpr std::size_t kMaxBytes = 1380;
};

/// What was last seen of one station.
struct StationHealth {
  std::uint64_t stale_cycles = 0;  ///< in which it did not take part although the frame came back, since the start
  std::uint64_t looks = 0;         ///< how often the values below were read
  std::uint64_t al_cycle = 0;      ///< cycles() when its AL status was last read, which is while not all are in OP
  std::uint16_t al_status = 0, al_code = 0;                       ///< 0130h, 0134h
  std::array<std::byte, wire::reg::kErrorCounterBytes> errors{};  ///< 0300h..
  std::int32_t dc_difference_ns = 0;
  std::uint32_t dc_difference_max_ns = 0;  ///< largest magnitude since the start
  bool mailbox_waiting = false;
};

class Cyclic {
 public:
  Cyclic() = default;
  Cyclic(const CyclicLayout& layout, std::span<const std::byte> outputs, std::span<std::byte> inputs) noexcept;
  Cyclic(const Cyclic&) = delete;
  Cyclic& operator=(const Cyclic&) = delete;

  /// Makes the frames of the next run() ready, but for what is known only then. Only saves time, between two cycles.
  void prepare() noexcept;
  Exchange run(FramePort& port, AcyclicSlot& acyclic, Time deadline) noexcept;
  /// The frames that carry `outputs`, laid out like the image, and nothing else, for somebody else to send. They count
  /// as late when they come back: their index is half a round away from the loop's own. How many; 0: they do not fit.
  std::size_t spare_frames(std::span<const std::byte> outputs, std::span<FrameBytes> frames) noexcept;

  /// The inputs of a station (index in the layout) are of the last exchange.
  [[nodiscard]] bool fresh(std::size_t station) const noexcept { return fresh_[station]; }
  /// Any thread, without a lock. Each figure is right by itself; while the loop runs, two of them may be of cycles that
  /// follow each other.
  [[nodiscard]] CyclicCounts counters() const noexcept;
  /// Another master whose frames came in. Any thread; its address and its frames may be of cycles that follow each
  /// other.
  [[nodiscard]] std::optional<OtherMaster> other_master() const noexcept;
  /// For the run thread. False when it was not looked at yet.
  bool health(std::size_t station, StationHealth& out) const noexcept { return published_[station].load(out); }
  /// The same as fresh(), for the run thread, with the number of cycles so far.
  [[nodiscard]] bool was_fresh(std::size_t station) const noexcept {
    return (published_fresh_[station / 64].load(std::memory_order_relaxed) >> (station % 64) & 1) != 0;
  }
  [[nodiscard]] std::uint64_t cycles() const noexcept { return cycles_.load(std::memory_order_acquire); }

 private:
  /// One datagram of process data over stations first .. first+count-1.
  struct Part {
    wire::Command command = wire::Command::Lrw;
    std::uint16_t first = 0, count = 0, bytes = 0, expected = 0;
  };
  static constexpr std::uint32_t kRemembered = 256;  ///< frames; a power of two
  static constexpr std::size_t kMaxParts = 2 * kMaxCyclicStations, kMaxFrames = kMaxCyclicFrames;
  using Parts = rt::FixedVector<Part, kMaxParts>;
  struct Placed {
    std::size_t frame = 0;
    SlotIndex slot = kNoSlot;
  };

  void plan(Parts& parts, std::size_t most_bytes) noexcept;
  void load(AcyclicSlot& acyclic) noexcept;
  void add_common(Frame& frame) noexcept;
  [[nodiscard]] bool open_frame() noexcept;
  void fill(const Part& part, std::span<const std::byte> outputs, std::span<std::byte> data) const noexcept;
  [[nodiscard]] bool take(std::span<const std::byte> received) noexcept;
  void note_sender(std::span<const std::byte> received) noexcept;
  [[nodiscard]] bool was_answered(std::span<const std::byte> received) const noexcept;
  void end_cycle() noexcept;
  [[nodiscard]] Exchange judge() noexcept;
  void judge_counters(Exchange& e, bool low, bool high) noexcept;
  void take_inputs(const Part& part, const Placed& placed) noexcept;
  void look(const Reply& first, Exchange& e) noexcept;
  [[nodiscard]] std::uint64_t read_clock(std::span<const std::byte> data) noexcept;
  void publish_fresh() noexcept;

  CyclicLayout layout_;
  std::span<const std::byte> outputs_;
  std::span<std::byte> inputs_;
  std::uint32_t sequence_ = 0;
  bool prepared_ = false;
  std::uint64_t dc_time_ = 0;

  Parts together_, singly_;
  int singly_left_ = 0;  ///< cycles with a datagram for every station
  const Parts* parts_ = &together_;
  std::array<Placed, kMaxParts> placed_{};

  std::array<Frame, kMaxFrames> frames_;
  Frame spare_;
  std::array<Reply, kMaxFrames> replies_;
  std::bitset<kMaxFrames> answered_;
  std::bitset<kMaxFrames> untouched_;         ///< came back as it was sent
  std::bitset<kRemembered> answered_before_;  ///< by the low bits of the sequence: frames of the last cycles
  std::size_t used_ = 0, answers_ = 0;        ///< frames of this cycle, and how many came back
  SlotIndex clock_ = kNoSlot, states_ = kNoSlot, errors_ = kNoSlot, difference_ = kNoSlot, mailbox_ = kNoSlot,
            al_status_ = kNoSlot;
  bool all_in_op_ = true;                 ///< as of the last BRD that came back
  std::size_t rolled_ = 0;                ///< station that is looked at in this cycle
  std::size_t rider_frame_ = kMaxFrames;  ///< frame in which the AcyclicSlot rides
  std::array<std::array<std::byte, kMaxFrameBytes>, kMaxFrames> received_{};

  std::bitset<kMaxCyclicStations> fresh_;
  std::array<StationHealth, kMaxCyclicStations> health_{};
  std::array<rt::Latest<StationHealth>, kMaxCyclicStations> published_;
  std::array<std::atomic<std::uint64_t>, kMaxCyclicStations / 64> published_fresh_{};
  std::atomic<std::uint64_t> cycles_{0};
  CyclicCounts counts_;
  using CountWords = std::array<std::uint64_t, sizeof(CyclicCounts) / sizeof(std::uint64_t)>;
  std::array<std::atomic<std::uint64_t>, std::tuple_size_v<CountWords>> published_counts_{};
  SenderWatch senders_;
  std::atomic<std::uint64_t> other_address_{0}, other_frames_{0};  ///< 0 frames: there is no other master
};

}  // namespace gantry::devices
