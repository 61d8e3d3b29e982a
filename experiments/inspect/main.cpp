// What a mechanism is: bodies, joints, freedoms, mobility, and what to know before computing with it.
#include "experiments/inspect/mechanism_report.h"

int main(int argc, char** argv) {
  lanc::StateProgram program("inspect",
                             "Bodies, joints, coordinates, drives, mobility and warnings of a mechanism.\nExit code 0, "
                             "or 2 for bad input.",
                             false);
  bool absolute = false;
  program.flag("--absolute", absolute,
               "also tell the ranks in absolute coordinates, six a body, of all joints' conditions");
  return program.run(argc, argv, [&](const lanc::StateInput& input) -> lanc::StateOutput {
    const lanc::MechanismReport report{input, lanc::analyse_mobility(input.model, input.state), absolute};
    return {input.format == lanc::Format::json ? lanc::json_text(to_json(report)) : to_text(report), 0};
  });
}
