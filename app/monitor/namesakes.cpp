#include "app/monitor/namesakes.hpp"

#include <algorithm>
#include <charconv>
#include <fmt/format.h>
#include <unistd.h>

namespace gantry::monitor {
namespace {

// gantry;session=0123456789abcdef;host=NAME;machine=NAME     the machine's name comes last: it may hold any character
constexpr std::string_view kBegin = "gantry;session=", kHost = ";host=", kMachine = ";machine=";
constexpr std::size_t kSessionDigits = 16, kLongestHost = 64, kMostSessions = 16;

std::string session_words(const Speaker& s) {
  return fmt::format("session {:016x} on {}", s.session, s.host.empty() ? "an unknown host" : "host " + s.host);
}

}  // namespace

std::string host_name() {
  char name[kLongestHost + 1]{};
  if (gethostname(name, kLongestHost) != 0) return {};
  return name;
}

std::string announcement(const Speaker& speaker) {
  return fmt::format("{}{:016x}{}{}{}{}", kBegin, speaker.session, kHost, speaker.host, kMachine, speaker.machine);
}

std::optional<Speaker> announced(std::string_view text) {
  if (!text.starts_with(kBegin)) return std::nullopt;
  text.remove_prefix(kBegin.size());
  const auto host = text.find(kHost), machine = text.find(kMachine);
  if (host != kSessionDigits || machine == text.npos || machine < host + kHost.size()) return std::nullopt;
  Speaker s;
  const auto [end, error] = std::from_chars(text.data(), text.data() + kSessionDigits, s.session, 16);
  if (error != std::errc() || end != text.data() + kSessionDigits) return std::nullopt;
  s.host = text.substr(host + kHost.size(), machine - host - kHost.size()).substr(0, kLongestHost);
  s.machine = text.substr(machine + kMachine.size());
  return s;
}

std::string namesake_words(const Speaker& one, const Speaker& other) {
  return fmt::format("two machines are called '{}': {} and {}; give one of them another name (--name)", one.machine,
                     session_words(one), session_words(other));
}

std::optional<std::uint64_t> Namesakes::heard(std::uint64_t session) {
  if (session == last_ && !sessions_.empty()) return std::nullopt;
  const auto before = last_;
  last_ = session;
  const auto known =
      std::find_if(sessions_.begin(), sessions_.end(), [&](const Session& s) { return s.id == session; });
  if (known == sessions_.end()) {
    if (sessions_.size() == kMostSessions) sessions_.erase(sessions_.begin());
    sessions_.push_back({session, false});
    return std::nullopt;
  }
  // Of a pair that takes turns, one is marked: the later one, whichever of the two is heard next.
  const auto other = std::find_if(sessions_.begin(), sessions_.end(), [&](const Session& s) { return s.id == before; });
  if (other == sessions_.end()) return std::nullopt;
  Session& later = *std::max(known, other);
  if (later.told) return std::nullopt;
  later.told = true;
  return before;
}

}  // namespace gantry::monitor
