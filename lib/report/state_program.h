// What the programs about one model at one state have in common: command line, state and loads, output, exit codes.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "lib/io/mechanism.h"
#include "lib/report/experiment.h"

namespace lanc {

enum class Format { text, json };

/// The model a user named, at the state and under the loads the user gave.
struct StateInput {
  std::string argument;  // the model as on the command line
  Model model;
  State<double> state;  // checked
  Loads<double> loads;
  Format format = Format::text;
  std::string out;  // of --out
  std::vector<std::string> command_line;
  GraphRecord graph = {};  // of a model that was given as a graph of joints
};

/// What a program has to say, and the exit code it ends with.
struct StateOutput {
  std::string text;
  int exit_code = 0;
};

/// Program `NAME MODEL [--time T] [--q ...] [--v ...] [--state FILE.json] [--assemble | --within-limits] [--format
/// json|text] [--out FILE]`; with loads also --tau and --wrench. The state is that of the model, then of --state, then
/// of the other options, then assembled. Tested by tests/cli/cli_test.cpp.
class StateProgram {
 public:
  /// `writes_csv`: the program writes results itself, into the file of --out (StateInput::out), and has no --format;
  /// its text goes to standard output.
  StateProgram(std::string name, std::string description, bool takes_loads, bool writes_csv = false);
  ~StateProgram();

  /// Options of this program's own; what they hold now is the default.
  void option(const std::string& name, std::string& value, const std::string& help);
  void option(const std::string& name, double& value, const Range& range, const std::string& help);
  void option(const std::string& name, int& value, const Range& range, const std::string& help);
  void list(const std::string& name, std::vector<std::string>& values, const std::string& help);
  void flag(const std::string& name, bool& value, const std::string& help);
  void numbers(const std::string& name, std::optional<std::vector<double>>& value, const std::string& help);

  /// Exit code of `body`, or 2 for bad input of any kind, told on stderr. --help, --list-models and
  /// --list-formulations print and run nothing.
  int run(int argc, const char* const* argv, const std::function<StateOutput(const StateInput&)>& body);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

/// Velocity coordinates by their names. Throws InputError naming `who` and those there are.
std::vector<int> velocities_named(const Model& model, const std::string& who, const std::vector<std::string>& names);

/// "1,2.5,-3e-2", a comma or spaces between. Throws InputError naming `who` and what is no number, or missing.
std::vector<double> read_numbers(const std::string& who, const std::string& text);

}  // namespace lanc
