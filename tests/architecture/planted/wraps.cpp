#include <functional>
#include <string>
std::function<std::size_t()> planted(std::string s) {
  return [s] { return s.size(); };
}
