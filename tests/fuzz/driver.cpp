// Runs a fuzz target without libFuzzer: every file of its corpus, then N inputs made from them by mutation.
//   fuzz_NAME CORPUS_DIR [RUNS] [SEED]
// At the end the corpus runs again, backwards: what the subject says to an input must not depend on those before it.
// The seed is printed; on a crash the input stands in the file that is named before.
#include <algorithm>
#include <chrono>
#include <csignal>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <random>
#include <unistd.h>
#include <vector>

#include "tests/fuzz/input.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size);

namespace {

using Bytes = std::vector<std::uint8_t>;
const Bytes* running = nullptr;
char crash_file[] = "fuzz-crash-XXXXXX";

/// Leaves the input behind. Only write(): it runs in a signal handler.
void leave_input(int signal) {
  if (running != nullptr)
    if (const int fd = ::mkstemp(crash_file); fd >= 0) {
      [[maybe_unused]] const auto written = ::write(fd, running->data(), running->size());
      constexpr char kNote[] = "\ncrashed; the input stands in ";
      [[maybe_unused]] const auto noted = ::write(2, kNote, sizeof kNote - 1);
      [[maybe_unused]] const auto named = ::write(2, crash_file, sizeof crash_file - 1);
    }
  std::signal(signal, SIG_DFL);
  std::raise(signal);
}

Bytes mutated(const std::vector<Bytes>& corpus, std::mt19937_64& random) {
  const auto below = [&](std::size_t n) { return static_cast<std::size_t>(random() % std::max<std::size_t>(n, 1)); };
  constexpr std::uint8_t kTelling[] = {0, 1, 2, 3, 6, 7, 8, 0x10, 0x40, 0x7F, 0x80, 0xFE, 0xFF};
  Bytes b = corpus.empty() ? Bytes{} : corpus[below(corpus.size())];
  for (std::size_t n = 1 + below(8); n > 0; --n) switch (b.empty() ? 3 : below(7)) {
      case 0: b[below(b.size())] ^= static_cast<std::uint8_t>(1u << below(8)); break;
      case 1: b[below(b.size())] = static_cast<std::uint8_t>(random()); break;
      case 2: b[below(b.size())] = kTelling[below(std::size(kTelling))]; break;
      case 3:
        b.insert(b.begin() + static_cast<std::ptrdiff_t>(below(b.size() + 1)), 1 + below(16),
                 static_cast<std::uint8_t>(random()));
        break;
      case 4: {
        const auto from = static_cast<std::ptrdiff_t>(below(b.size()));
        b.erase(b.begin() + from,
                b.begin() + from +
                    static_cast<std::ptrdiff_t>(
                        1 + below(std::min<std::size_t>(b.size() - static_cast<std::size_t>(from), 16) - 1)));
        break;
      }
      case 5: b.resize(below(b.size()) + 1); break;
      default: {
        const Bytes& other = corpus[below(corpus.size())];
        b.resize(below(b.size() + 1));
        if (!other.empty())
          b.insert(b.end(), other.begin() + static_cast<std::ptrdiff_t>(below(other.size())), other.end());
      }
    }
  if (b.size() > 4096) b.resize(4096);
  return b;
}

/// A hash of what the subject said.
std::uint64_t run(const Bytes& input) {
  running = &input;
  gantry::fuzz::said = 0;
  LLVMFuzzerTestOneInput(input.data(), input.size());
  running = nullptr;
  return gantry::fuzz::said;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 2) {
    std::fprintf(stderr, "usage: %s CORPUS_DIR [RUNS] [SEED]\n", argv[0]);
    return 2;
  }
  const unsigned long long runs = argc > 2 ? std::strtoull(argv[2], nullptr, 10) : 1000;
  const unsigned long long seed = argc > 3 ? std::strtoull(argv[3], nullptr, 10) : 20260101;
  for (const int signal : {SIGSEGV, SIGABRT, SIGBUS, SIGILL, SIGFPE}) std::signal(signal, leave_input);

  std::vector<std::filesystem::path> files;
  for (const auto& file : std::filesystem::directory_iterator(argv[1])) files.push_back(file.path());
  std::sort(files.begin(), files.end());  // the order of a folder is no order
  std::vector<Bytes> corpus;
  for (const auto& path : files) {
    std::ifstream file(path, std::ios::binary);
    corpus.emplace_back(std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>());
  }
  if (corpus.empty()) {
    std::fprintf(stderr, "%s: no corpus\n", argv[1]);
    return 2;
  }
  const auto begin = std::chrono::steady_clock::now();
  std::vector<std::uint64_t> said;
  for (const auto& input : corpus) said.push_back(run(input));
  std::mt19937_64 random(seed);
  for (unsigned long long i = 0; i < runs; ++i) run(mutated(corpus, random));
  for (std::size_t i = corpus.size(); i-- > 0;)
    if (run(corpus[i]) != said[i]) {
      std::fprintf(stderr, "%s: does not do the same again after other inputs\n", files[i].c_str());
      return 1;
    }
  const double took_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  std::printf("%zu inputs of the corpus, %llu mutated (seed %llu), %.1f s\n", corpus.size(), runs, seed, took_s);
}
