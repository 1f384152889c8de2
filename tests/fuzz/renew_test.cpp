// A line that was renewed is a new line: an input of the fuzz targets means the same whatever ran before it.
#include <bit>
#include <gtest/gtest.h>
#include <random>

#include "sim/drive/drive402.hpp"
#include "sim/esc/esc.hpp"
#include "tests/fuzz/segment_bench.hpp"

namespace gantry::fuzz {
namespace {

using devices::wire::AlState;

/// Everything that can be seen of a line without changing it for good: all bytes of every ESC as the bus reads them,
/// the EEPROM, the objects, motors and counters.
std::vector<std::uint64_t> state_of(SegmentBench& line) {
  std::vector<std::uint64_t> seen;
  const Time now = line.clock.now();
  seen.push_back(static_cast<std::uint64_t>(now.count()));
  seen.insert(seen.end(), {line.segment.cycles(), line.segment.frames(), line.segment.link_up() ? 1u : 0u,
                           static_cast<std::uint64_t>(line.segment.round_trip().count())});
  for (int i = 0; i < line.segment.station_count(); ++i) {
    sim::Station& station = line.segment.station(i);
    sim::Esc& esc = station.esc();
    seen.insert(seen.end(), {station.powered() ? 1u : 0u, static_cast<std::uint64_t>(station.state()),
                             static_cast<std::uint64_t>(station.next_tick().count()), station.io_outputs(),
                             esc.sii_loaded() ? 1u : 0u, esc.dc().local(now), esc.dc().system(now), esc.dc().pulses(),
                             esc.dc().sync0_active() ? 1u : 0u, esc.take_events(), esc.irq()});
    for (std::size_t at = 0; at < sim::Esc::kMemoryBytes; ++at) {
      std::byte b{0xEE};
      const bool answers = esc.read(static_cast<std::uint16_t>(at), {&b, 1}, now);
      seen.push_back(std::to_integer<std::uint64_t>(b) | (answers ? 0x100u : 0u));
    }
    for (const sim::Object& o : station.objects().all()) {
      seen.push_back(std::uint64_t{o.address.index} << 8 | o.address.sub);
      seen.insert(seen.end(), {static_cast<std::uint64_t>(o.value), static_cast<std::uint64_t>(o.facts->initial)});
    }
    if (i == 0) {  // the drive
      const sim::DriveMemory m = station.drive(0)->memory();
      seen.insert(seen.end(), {std::bit_cast<std::uint64_t>(m.position), std::bit_cast<std::uint64_t>(m.count_zero),
                               static_cast<std::uint64_t>(station.drive(0)->state())});
    }
    // The EEPROM, through its registers: 1024 words.
    for (unsigned word = 0; word < 1024; word += 4) {
      std::array<std::byte, 6> order{std::byte{0}, std::byte{1}};
      devices::wire::put_le<std::uint32_t>(order, 2, word);
      esc.write(0x0502, order, now);
      std::array<std::byte, 14> shown{};
      esc.read(0x0502, shown, now + milliseconds(1));
      seen.push_back(devices::wire::get_le<std::uint64_t>(shown, 6));
    }
  }
  return seen;
}

/// Whatever the bus and a script can do to a line.
void treat(SegmentBench& line, std::mt19937_64& random) {
  const auto below = [&](unsigned n) { return static_cast<unsigned>(random() % n); };
  constexpr AlState kStates[] = {AlState::Init, AlState::PreOp, AlState::SafeOp, AlState::Op};
  constexpr unsigned kRegisters[] = {0x010, 0x100, 0x120, 0x200, 0x300,  0x400,  0x420,  0x500, 0x502, 0x600,
                                     0x610, 0x800, 0x808, 0x810, 0x818,  0x900,  0x910,  0x920, 0x928, 0x930,
                                     0x980, 0x990, 0x9A0, 0xF00, 0x1000, 0x1080, 0x1100, 0x1400};
  line.bring_up(kStates[below(4)]);
  for (int i = 0; i < 60; ++i) {
    const StationId id{static_cast<std::uint16_t>(below(3))};
    switch (below(16)) {
      case 0: line.segment.power_off(id); break;
      case 1: line.segment.power_on(id); break;
      case 2: line.segment.power_cycle(id, milliseconds(2)); break;
      case 3: line.segment.cut_link(static_cast<int>(below(3))); break;
      case 4: line.segment.heal_link(static_cast<int>(below(3))); break;
      case 5: line.segment.faults().set_noise({.loss = 0.1, .corrupt = 0.1, .header = 0.1, .seed = random()}); break;
      case 6: line.segment.set_clock_drift(id, 100), line.segment.set_clock_jitter(id, 500); break;
      case 7: line.segment.set_io_inputs(id, static_cast<std::uint16_t>(random())); break;
      case 8: line.segment.ignore_writes(id, config::ObjectAddress{}); break;
      case 9: {
        sim::Drive402& drive = *line.segment.station(0).drive(0);
        drive.restore({.position = 0.1 * below(1000), .count_zero = 0.01 * below(100)});
        drive.stick_statusword(below(2) != 0);
        line.wait(milliseconds(3));
        break;
      }
      case 10: {  // a parameter that the drive keeps
        auto& objects = line.segment.station(0).objects();
        const auto all = objects.all();
        const sim::Object& o = all[below(static_cast<unsigned>(all.size()))];
        const std::array<std::byte, 4> value{static_cast<std::byte>(below(2))};
        if (o.kept) (void)objects.write(o.address, std::span(value).first(sim::size_of(o.type)), true);
        break;
      }
      case 11:  // a word of the EEPROM
        line.poke(id.value, 0x0508, below(256), below(256));
        line.poke(id.value, 0x0502, 0x81, 0x02, below(64), 0, 0, 0);
        line.wait(milliseconds(1));
        break;
      default: {
        std::vector<std::byte> bytes(1 + below(128));
        for (auto& b : bytes) b = static_cast<std::byte>(random());
        line.datagram(1 + below(14),
                      SegmentBench::address(below(2) != 0 ? 0u - below(3) : 0x1001 + below(3),
                                            kRegisters[below(std::size(kRegisters))]),
                      bytes);
      }
    }
  }
}

TEST(Renew, leaves_a_line_as_a_new_one_in_every_register_object_and_word_of_the_eeprom) {
  const auto profiles = {"drives/std402ec.yaml", "drives/amd530b.yaml", "devices/aio4.yaml"};
  const std::vector<std::uint64_t> as_new = [&] {
    SegmentBench line(profiles);
    return state_of(line);
  }();
  SegmentBench line(profiles);
  const unsigned seed = 20260611;
  std::mt19937_64 random(seed);
  for (int round = 0; round < 200; ++round) {
    treat(line, random);
    line.renew();
    const auto seen = state_of(line);
    ASSERT_EQ(seen.size(), as_new.size());
    for (std::size_t i = 0; i < seen.size(); ++i)
      ASSERT_EQ(seen[i], as_new[i]) << "place " << i << ", round " << round << ", seed " << seed;
    line.renew();
  }
}

/// The same treatment of a new line, of one after 1000 others, and of one that was new for each: the same answers.
TEST(Renew, gives_the_same_answers_after_a_thousand_other_inputs) {
  const auto profiles = {"drives/id286.yaml", "devices/dio16.yaml", "devices/aio4.yaml"};
  SegmentBench line(profiles);
  const auto answers = [](SegmentBench& of, std::uint64_t seed) {
    std::mt19937_64 random(seed);
    of.renew();
    said = 0;
    treat(of, random);
    return said;
  };
  std::vector<std::uint64_t> first;
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    SegmentBench fresh(profiles);
    first.push_back(answers(fresh, seed));
  }
  for (std::uint64_t seed = 100; seed < 1100; ++seed) answers(line, seed);
  for (std::uint64_t seed = 0; seed < 20; ++seed) EXPECT_EQ(answers(line, seed), first[seed]) << "seed " << seed;
}

}  // namespace
}  // namespace gantry::fuzz
