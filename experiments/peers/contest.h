// One model, all sides: answers compared first, then timed in turns.
#pragma once

#include <string>

#include "lib/report/experiment.h"

namespace lanc::peers {

// Statuses of rows beside those of a solve (lib/formulation/outcome.h).
constexpr const char* missing = "missing";      // the peer is not compiled in
constexpr const char* different = "different";  // its answer is that of another problem: not timed

/// Rows of a cell without repetition: `difference` from our answer and, where there is a closed form, `error` against
/// it, relative to the largest value; of every repetition: `time`. `task=forward` or `task=inverse` in `parameters`.
/// What is noteworthy is said to the experiment's progress. Throws InputError when none of ours solves the model.
void contest(Experiment& experiment, const std::string& argument);

}  // namespace lanc::peers
