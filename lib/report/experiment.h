// What all experiments have in common: command line, choice of models and formulations, report, progress, exit codes.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "lib/formulation/formulation.h"
#include "lib/io/mechanism.h"
#include "lib/report/progress.h"
#include "lib/report/report.h"

namespace lanc {

/// Options every experiment takes.
struct CommonOptions {
  std::string out;                                // CSV; "-" is standard output
  std::vector<std::string> models, formulations;  // globs; empty means all
  std::uint64_t seed = 1;                         // the generators' own default
  int repetitions = 0;
  bool quick = false, quiet = false, resume = false;
};

/// Values an option takes, both ends included.
struct Range {
  double lowest, highest;
};

/// The texts that match the glob; the text itself, matched or not, when it holds no * ? [.
std::vector<std::string> matching(const std::vector<std::string>& all, const std::string& glob);

/// One run of an experiment's program. Tested by tests/report/experiment_test.cpp.
class Experiment {
 public:
  struct Description {
    std::string name, question;
    int repetitions = 5, quick_repetitions = 2;
    /// Model arguments of the default run, and of the quick one.
    std::function<std::vector<std::string>(bool quick)> models;
    /// The formulations of the default run; all of the register where it is null.
    std::function<bool(const FormulationInfo&)> formulations = nullptr;
    /// Name and version of libraries beside the project's own, for the sidecar.
    std::vector<std::pair<std::string, std::string>> libraries = {};
  };

  explicit Experiment(Description description);
  ~Experiment();

  /// Options of this experiment's own; the value they have now is the default. They decide what --resume compares.
  void option(const std::string& name, int& value, const std::string& help);
  void option(const std::string& name, double& value, const Range& range, const std::string& help);
  void option(const std::string& name, std::string& value, const std::string& help);

  /// Reads the command line, runs `body`, and returns the exit code: 0; 1 when something in it could not be used later
  /// on; 2 for bad options, told on stderr. --help, --list-models and --list-formulations print and run nothing.
  int run(int argc, const char* const* argv, const std::function<void(Experiment&)>& body);

  // What `body` asks:
  const CommonOptions& options() const;
  /// The chosen model arguments and formulations.
  const std::vector<std::string>& models() const;
  const std::vector<const FormulationInfo*>& formulations() const;
  /// The mechanism of a model argument, generators with the seed of the command line.
  Mechanism load(const std::string& model) const;
  /// A cell about the model, its sizes filled in.
  Cell cell(const std::string& name, const Model& model, const std::string& formulation = {},
            const std::string& parameters = {}, std::optional<int> repetition = std::nullopt) const;
  Report& report();
  Progress& progress();

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace lanc
