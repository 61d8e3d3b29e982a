// What the fuzzers and the replay of their corpus do with one input.
#pragma once

#include <string>
#include <string_view>

#include "lib/formulation/formulation.h"
#include "lib/io/mechanism.h"
#include "lib/system/evaluator.h"

namespace lanc::fuzz {

using Loader = Mechanism (*)(std::string_view text, const std::string& name);

/// Loads, and when the text is a model evaluates and solves it. An InputError is the right answer to bad text; any
/// other exception, a crash or a hang is a finding. Returns whether the text was a model.
inline bool try_input(Loader load, std::string_view text) {
  try {
    const Mechanism m = load(text, "input");
    Evaluator<double> evaluator(m.model);
    Solution<double> solution(m.model);
    (void)find_formulation("recursive")->create_double(m.model)->solve(evaluator.system(m.state), solution);
    return true;
  } catch (const InputError&) {
    return false;
  }
}

}  // namespace lanc::fuzz
