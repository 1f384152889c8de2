// Words of a command that a person copies into a shell.
//   "gantry run " + shell_word("my board.yaml")     gantry run 'my board.yaml'
#pragma once
#include <string>
#include <string_view>

namespace gantry {

/// As it is where no shell reads anything into it, else in single quotes (POSIX.1-2017, Shell Command Language, 2.2.2).
inline std::string shell_word(std::string_view word) {
  constexpr std::string_view kPlain = "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_-./:,=@%+";
  if (!word.empty() && word.find_first_not_of(kPlain) == word.npos) return std::string(word);
  std::string quoted = "'";
  for (const char c : word)
    if (c == '\'')
      quoted += "'\\''";
    else
      quoted += c;
  return quoted + "'";
}

}  // namespace gantry
