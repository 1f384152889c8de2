// How far long work has come, in pieces of about the same size, to whoever shows it.
//   if (progress) progress(done, total);
#pragma once
#include <cstddef>
#include <functional>

namespace gantry {

/// Called now and then, with `done` rising to `total`. Empty: nobody looks.
using Progress = std::function<void(std::size_t done, std::size_t total)>;

}  // namespace gantry
