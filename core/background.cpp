#include "core/background.hpp"

#include <unistd.h>

namespace gantry {

void come_behind_others() {
  constexpr int kNicer = 10;
  [[maybe_unused]] const int now = ::nice(kNicer);  // nobody is refused to be nicer
}

}  // namespace gantry
