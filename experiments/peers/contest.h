// All models, all sides: answers compared first, then timed in turns.
#pragma once

#include <string>
#include <vector>

#include "lib/report/experiment.h"

namespace lanc::peers {

// Statuses of rows beside those of a solve (lib/formulation/outcome.h).
constexpr const char* missing = "missing";      // the peer is not compiled in
constexpr const char* different = "different";  // its answer is that of another problem: not timed

/// Rows of a cell without repetition: `difference` from our answer and, where there is a closed form, `error` against
/// it, relative to the largest value; of every repetition: `time`. `task=forward` or `task=inverse` in `parameters`.
/// One repetition goes through all models, then the next one: bounds compare sides on different models, too, and a
/// machine is not as fast now as a minute ago. What is noteworthy is said to the experiment's progress. Throws
/// InputError when none of ours solves a model.
void contest(Experiment& experiment, const std::vector<std::string>& models);

}  // namespace lanc::peers
