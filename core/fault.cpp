#include "core/fault.hpp"

#include <algorithm>
#include <array>

namespace gantry {
namespace {

constexpr std::array kTable{
#define GANTRY_FAULT(number, name, threat, severity, reaction, clear, exit_code, detail, text, remedy)                \
  FaultInfo{Fault::name,    #name, threat, Severity::severity, Reaction::reaction, Clear::clear, ExitCode::exit_code, \
            Detail::detail, text,  remedy},
#include "core/fault_table.def"
#undef GANTRY_FAULT
};

static_assert(std::is_sorted(kTable.begin(), kTable.end(),
                             [](const FaultInfo& a, const FaultInfo& b) { return a.fault < b.fault; }),
              "fault_table.def is kept in ascending order");

}  // namespace

const FaultInfo& info(Fault fault) noexcept {
  const auto at = [](Fault f) {
    return std::lower_bound(kTable.begin(), kTable.end(), f,
                            [](const FaultInfo& row, Fault wanted) { return row.fault < wanted; });
  };
  const auto row = at(fault);
  return row != kTable.end() && row->fault == fault ? *row : *at(Fault::Internal);
}

std::span<const FaultInfo> catalogue() noexcept { return kTable; }

FaultCode code(Fault fault) noexcept {
  const auto n = static_cast<unsigned>(fault) % 1000;
  return {{'G', static_cast<char>('0' + n / 100), static_cast<char>('0' + n / 10 % 10), static_cast<char>('0' + n % 10),
           '\0'}};
}

}  // namespace gantry
