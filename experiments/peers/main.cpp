// Our formulations beside other libraries on the same models, in turns, in one process.
#include <cstdio>

#include "experiments/peers/contest.h"
#include "experiments/peers/peer.h"
#include "experiments/peers/plan.h"
#include "experiments/peers/tables.h"
#include "lib/report/experiment.h"

int main(int argc, char** argv) {
  using namespace lanc;
  std::vector<std::pair<std::string, std::string>> libraries;
  for (const peers::PeerInfo& peer : peers::registered_peers()) libraries.emplace_back(peer.name, peer.version);
  Experiment experiment(
      {.name = "peers",
       .question = "What do our formulations take, relative to other libraries?",
       .repetitions = 31,
       .quick_repetitions = 5,
       .models = peers::default_models,
       .formulations = [](const FormulationInfo& info) { return info.recursive || peers::has_bound(info.name); },
       .libraries = libraries});
  return experiment.run(argc, argv, [](Experiment& e) {
    peers::contest(e, e.models());
    std::FILE* out = e.options().out == "-" ? stderr : stdout;
    peers::print_times(out, e.report().rows());
    peers::print_bounds(out, e.report().rows());
    peers::print_builds(out);
  });
}
