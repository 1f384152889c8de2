// Two machines of one name: what each would be believed for the other's. Every publisher says with its writer whose it
// is; who hears two sessions of one name that are both alive says so.
//   Namesakes namesakes;
//   if (auto other = namesakes.heard(sample.session)) log::warn("{}", namesake_words(this_one, *other));
#pragma once
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace gantry::monitor {

/// Who speaks: an owner of a machine, and its computer.
struct Speaker {
  std::string machine;
  std::uint64_t session = 0;
  std::string host;  ///< empty: not known
};

/// This computer's name.
std::string host_name();
/// As text that travels with the writer of the state (its user data), and back; nothing for other text.
std::string announcement(const Speaker& speaker);
std::optional<Speaker> announced(std::string_view text);

/// "two machines are called 'x': session ... on host a and session ... on host b; ..."
std::string namesake_words(const Speaker& one, const Speaker& other);

/// Which sessions of one name are alive, by the order in which their samples come: an owner that was started anew is
/// never heard again under its old session, so a session that speaks after another one began shows that both live.
class Namesakes {
 public:
  /// The other session that this sample shows to be alive too; each pair once. Takes the newest 16 sessions.
  std::optional<std::uint64_t> heard(std::uint64_t session);

 private:
  struct Session {
    std::uint64_t id = 0;
    bool told = false;
  };
  std::vector<Session> sessions_;
  std::uint64_t last_ = 0;
};

}  // namespace gantry::monitor
