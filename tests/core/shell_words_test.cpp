// Words for a shell, judged by a shell.
#include "core/shell_words.hpp"

#include <array>
#include <cstdio>
#include <gtest/gtest.h>
#include <memory>

namespace gantry {
namespace {

std::string said_by_a_shell(const std::string& word) {
  const std::string command = "printf %s " + shell_word(word);
  const std::unique_ptr<FILE, int (*)(FILE*)> pipe(popen(command.c_str(), "r"), pclose);
  std::string said;
  std::array<char, 256> chunk{};
  for (std::size_t n = 0; pipe && (n = fread(chunk.data(), 1, chunk.size(), pipe.get())) > 0;)
    said.append(chunk.data(), n);
  return said;
}

TEST(ShellWord, comes_out_of_a_shell_as_it_went_in) {
  for (const char* word : {"board.yaml", "my board.yaml", "a'b", "'", "$HOME", "`id`", "spreader[1][2],dam", "a\\b",
                           "*", "\"", "~", "-x", "#1", "a;b", "", "\xC3\xA4"})
    EXPECT_EQ(said_by_a_shell(word), word) << shell_word(word);
}

TEST(ShellWord, is_left_as_it_is_where_it_may) { EXPECT_EQ(shell_word("out/job-1.yaml,a=b"), "out/job-1.yaml,a=b"); }

}  // namespace
}  // namespace gantry
