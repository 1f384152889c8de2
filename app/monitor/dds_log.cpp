#include "app/monitor/dds_log.hpp"

#include <dds/ddsrt/log.h>
#include <mutex>
#include <string>

#include "app/monitor/line_limit.hpp"
#include "core/log.hpp"

namespace gantry::monitor::dds {
namespace {

/// Threads of DDS call this at any time, also while the program ends: what it uses is never destroyed.
struct Sink {
  std::mutex mutex;
  LineLimit limit;
  MonotonicClock clock;
};

void write(void* to, const dds_log_data_t* line) {
  auto& sink = *static_cast<Sink*>(to);
  std::string left_out;
  {
    const std::lock_guard lock(sink.mutex);
    if (!sink.limit.admit(sink.clock.now())) return;
    left_out = sink.limit.left_out_words();
  }
  const auto text = printable({line->message, line->size});
  const bool grave = (line->priority & (DDS_LC_FATAL | DDS_LC_ERROR)) != 0;
  log::say(grave ? log::Weight::Error : log::Weight::Warning, fmt::format("DDS: {}{}", text, left_out));
}

}  // namespace

void log_in_bounds() {
  static auto* const sink = new Sink;
  dds_set_log_sink(write, sink);
  dds_set_trace_sink(write, sink);
}

}  // namespace gantry::monitor::dds
