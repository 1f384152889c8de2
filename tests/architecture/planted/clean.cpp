#include <cmath>
#include <cstring>
double planted(double* a, const double* b, unsigned n) {
  std::memcpy(a, b, n);
  return std::hypot(std::sin(a[0]), std::atan2(a[1], a[2]));
}
