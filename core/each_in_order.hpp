// A table with one row for each value of an enumeration, in their order, so that a value is the index of its row.
//   static_assert(each_in_order(kOrders, &Row::kind, OrderKind::Quit));
#pragma once
#include <cstddef>

namespace gantry {

/// `last`: of the values.
template <class Rows, class Row, class Kind>
consteval bool each_in_order(const Rows& rows, Kind Row::*key, Kind last) {
  for (std::size_t i = 0; i < rows.size(); ++i)
    if (static_cast<std::size_t>(rows[i].*key) != i) return false;
  return rows.size() == static_cast<std::size_t>(last) + 1;
}

}  // namespace gantry
