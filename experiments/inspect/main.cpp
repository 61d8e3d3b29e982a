// What a mechanism is: bodies, joints, freedoms, mobility, and what to know before computing with it.
#include "experiments/inspect/mechanism_report.h"

int main(int argc, char** argv) {
  lanc::StateProgram program("inspect",
                             "Bodies, joints, coordinates, drives, mobility and warnings of a mechanism.\nExit code 0, "
                             "or 2 for bad input.",
                             false);
  return program.run(argc, argv, [](const lanc::StateInput& input) -> lanc::StateOutput {
    return {input.format == lanc::Format::json ? lanc::json_text(to_json(input)) : to_text(input), 0};
  });
}
