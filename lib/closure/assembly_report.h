// What the ways to assemble tell in common. Private to lib/closure.
#pragma once

#include <string>
#include <vector>

#include "lib/closure/assembly.h"
#include "lib/closure/scaling.h"

namespace lanc {

/// Puts numbers of closure rows into words. g: the scaled values of all rows.
class AssemblyReport {
 public:
  AssemblyReport(const Model& model, double tolerance) : model_(model), scaling_(model), tolerance_(tolerance) {}

  std::vector<ClosureGap> gaps(const std::vector<double>& g) const;
  /// "'closure.row' open by 0.1 m", the worst three of some rows.
  std::string open_rows(std::vector<int> rows, const std::vector<double>& g) const;
  /// Sets moved_length and moved_angle.
  void measure_move(const std::vector<double>& from, const std::vector<double>& to, AssemblyResult& result) const;

 private:
  double gap(int row, double scaled) const;

  Model model_;
  ClosureScaling scaling_;
  double tolerance_;
};

}  // namespace lanc
