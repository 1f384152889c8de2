// The publisher as a program of its own, for tests: publish --shm PATH --domain N.
#include <cstdlib>
#include <cstring>
#include <iostream>

#include "app/monitor/publish.hpp"

int main(int argc, char** argv) {
  std::string shm;
  gantry::monitor::PublishOptions options;
  for (int i = 1; i + 1 < argc; ++i) {
    if (std::strcmp(argv[i], "--shm") == 0) shm = argv[i + 1];
    if (std::strcmp(argv[i], "--domain") == 0) options.network.domain = std::atoi(argv[i + 1]);
  }
  const std::atomic<bool> stop{false};
  const auto done = gantry::monitor::publish(shm, options, stop);
  if (!done) std::cerr << to_text(done.error()) << '\n';
  return done ? 0 : 1;
}
