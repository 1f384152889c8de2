#include "devices/ethercat/lrw_trial.hpp"

#include <span>

namespace gantry::devices {
namespace {

using namespace wire;

/// One datagram over the logical region of each of these stations, with outputs of 0; the working counters.
Result<std::vector<int>> pass_over(Link& link, Command command, std::span<const StationRecord* const> stations) {
  std::vector<std::vector<std::byte>> data;
  std::vector<Datagram> batch;
  for (const auto* s : stations) data.emplace_back(s->region_bytes);
  for (std::size_t i = 0; i < stations.size(); ++i) batch.push_back({command, stations[i]->logical, data[i]});
  if (auto ok = link.transact(batch); !ok) return tl::unexpected(ok.error());
  std::vector<int> counters;
  for (const Datagram& d : batch) counters.push_back(d.working_counter);
  return counters;
}

}  // namespace

Result<int> try_lrw(Link& link, std::vector<StationRecord>& stations, std::vector<std::string>& notes) {
  std::vector<StationRecord*> asked, silent;
  for (auto& s : stations)
    if (s.lrw && s.region_bytes > 0) asked.push_back(&s);
  const auto lrw = pass_over(link, Command::Lrw, asked);
  if (!lrw) return tl::unexpected(lrw.error());
  for (std::size_t i = 0; i < asked.size(); ++i)
    if ((*lrw)[i] == 0) silent.push_back(asked[i]);
  if (silent.empty()) return 0;
  const auto lwr = pass_over(link, Command::Lwr, silent);
  if (!lwr) return tl::unexpected(lwr.error());
  const auto lrd = pass_over(link, Command::Lrd, silent);
  if (!lrd) return tl::unexpected(lrd.error());
  int changed = 0;
  for (std::size_t i = 0; i < silent.size(); ++i) {
    StationRecord& s = *silent[i];
    if ((*lwr)[i] != (s.output_bytes > 0 ? 1 : 0) || (*lrd)[i] != (s.input_bytes > 0 ? 1 : 0)) continue;
    s.lrw = false;
    ++changed;
    notes.push_back(s.where + ": takes no LRW and does not say so; its data go by LWR and LRD");
  }
  return changed;
}

}  // namespace gantry::devices
