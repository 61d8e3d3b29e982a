// The numerical outcome of a solve: a value that callers cannot overlook, never an exception and never silence.
#pragma once

#include <limits>
#include <string>
#include <string_view>

namespace lanc {

enum class Status : unsigned char { solved, redundant, singular, inconsistent, not_converged, not_finite, objection };

constexpr std::string_view to_string(Status status) {
  constexpr std::string_view names[] = {"solved",        "redundant",  "singular", "inconsistent",
                                        "not_converged", "not_finite", "objection"};
  return names[static_cast<int>(status)];
}

/// `solved` and `redundant` carry an answer that is right.
constexpr bool usable(Status status) { return status == Status::solved || status == Status::redundant; }

/// With a status that is not usable() the numbers must not be used, unless `conditional`: then they are right under the
/// condition that the message tells.
struct [[nodiscard]] Outcome {
  Status status = Status::solved;
  std::string message;  // why, and what to do; empty when solved
  /// Estimate of the relative error of the answer from the last refinement step; NaN where it was not made
  /// (Formulation::solve).
  double forward_error = std::numeric_limits<double>::quiet_NaN();
  /// `inconsistent` or `singular` because of the closure conditions: the numbers obey them by least squares, or at this
  /// very state only.
  bool conditional = false;
  // Of the closure conditions, where loops are closed (lib/closure/rank.h).
  int rank = 0, redundant = 0;
  double sigma = 0, next_sigma = 0;  // σ_r and σ_{r+1}

  bool usable() const { return lanc::usable(status); }
  /// There are numbers to be told.
  bool has_answer() const { return usable() || conditional; }
};

}  // namespace lanc
