#include "lib/derivatives/closure_outcome.h"

#include <fmt/format.h>

#include <algorithm>

namespace lanc {

Outcome closure_outcome(const ClosureDecision& decision) {
  Outcome outcome;
  outcome.rank = decision.rank, outcome.redundant = decision.redundant;
  outcome.sigma = decision.sigma, outcome.next_sigma = decision.next_sigma;
  const double violation = std::max(decision.position_violation, decision.velocity_violation);
  if (decision.redundant > 0) outcome.status = Status::redundant;
  if (!decision.held && violation > largest_violation)
    outcome.status = Status::inconsistent,
    outcome.message = fmt::format("the state violates the closure conditions by {:.1e}; assemble it first", violation);
  else if (decision.varying_rank || decision.near_singular)
    outcome.status = Status::singular,
    outcome.message = "the rank of the closure conditions changes at or near this state: η̇ has no derivative here";
  return outcome;
}

}  // namespace lanc
