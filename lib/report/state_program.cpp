#include "lib/report/state_program.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <charconv>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <set>

#include "lib/closure/assembly.h"
#include "lib/closure/assembly_limits.h"
#include "lib/formulation/formulation.h"
#include "lib/io/generators.h"
#include "lib/model/error.h"
#include "lib/report/option_checks.h"

namespace lanc {
namespace {

using Words = std::vector<std::string>;

std::vector<double> joined_numbers(const std::string& who, const Words& words) {
  return read_numbers(who, fmt::format("{}", fmt::join(words, " ")));
}

Loads<double>::Applied applied_wrench(const Model& model, const std::string& who, const std::string& body,
                                      const std::vector<double>& six) {
  const auto index = model.find_body(body);
  if (!index) throw InputError(fmt::format("{}: there is no body '{}'; `inspect` lists them", who, body));
  if (six.size() != 6)
    throw InputError(fmt::format("{}: {} numbers for body '{}', a wrench has six: mx,my,mz,fx,fy,fz in N m and N", who,
                                 six.size(), body));
  for (const double x : six)
    if (!std::isfinite(x)) throw InputError(fmt::format("{}: the wrench on '{}' is not finite", who, body));
  return {*index, {{six[0], six[1], six[2]}, {six[3], six[4], six[5]}}};
}

std::vector<double> checked_tau(const Model& model, std::vector<double> tau) {
  if (static_cast<int>(tau.size()) != model.nv())
    throw InputError(fmt::format("tau has {} numbers, the model needs {}{}", tau.size(), model.nv(),
                                 model.nv() > 12 ? "" : fmt::format(": {}", fmt::join(model.velocity_names(), ", "))));
  for (const double x : tau)
    if (!std::isfinite(x)) throw InputError("tau holds a number that is not finite");
  return tau;
}

/// Of two equal keys the library would keep the last, silently.
nlohmann::json parse_without_duplicates(std::istream& file, const std::string& path) {
  std::vector<std::set<std::string>> keys;  // of the objects around the present place
  using Event = nlohmann::json::parse_event_t;
  return nlohmann::json::parse(file, [&](int, Event event, const nlohmann::json& parsed) {
    if (event == Event::object_start) keys.emplace_back();
    if (event == Event::object_end) keys.pop_back();
    if (event == Event::key && !keys.back().insert(parsed.get<std::string>()).second)
      throw InputError(Place{path}, fmt::format("the key '{}' is there twice; remove one", parsed.get<std::string>()));
    return true;
  });
}

/// {"t": .., "q": [..], "v": [..], "tau": [..], "wrenches": {"body": [6 numbers]}}, each key optional.
void read_state_file(const std::string& path, bool takes_loads, StateInput& input) {
  std::error_code none;
  if (std::filesystem::is_directory(path, none))
    throw InputError(Place{path}, "this is a directory; name a JSON file in it");
  std::ifstream file(path);
  if (!file) throw InputError(Place{path}, "this file cannot be read");
  try {
    const nlohmann::json document = parse_without_duplicates(file, path);
    if (!document.is_object()) throw InputError(Place{path}, "not a JSON object such as {\"q\": [0.1], \"v\": [0]}");
    for (const auto& [key, value] : document.items()) {
      if (key == "t") {
        input.state.t = value.get<double>();
      } else if (key == "q") {
        input.state.q = value.get<std::vector<double>>();
      } else if (key == "v") {
        input.state.v = value.get<std::vector<double>>();
      } else if (key == "tau" && takes_loads) {
        input.loads.tau = value.get<std::vector<double>>();
      } else if (key == "wrenches" && takes_loads) {
        for (const auto& [body, six] : value.items())
          input.loads.wrenches.push_back(applied_wrench(input.model, path, body, six.get<std::vector<double>>()));
      } else {
        throw InputError(Place{path}, fmt::format("unknown key '{}'; there are t, q, v{}", key,
                                                  takes_loads ? ", tau and wrenches" : ""));
      }
    }
  } catch (const nlohmann::json::exception& error) {
    throw InputError(Place{path}, fmt::format("{}; numbers, and arrays of numbers, are expected", error.what()));
  }
}

double read_number(const std::string& who, const std::string& word) {
  const bool plus = word[0] == '+' && word.compare(0, 2, "+-") != 0;  // std::from_chars takes no plus
  double value = 0;
  const auto [last, error] = std::from_chars(word.data() + (plus ? 1 : 0), word.data() + word.size(), value);
  if (error != std::errc() || last != word.data() + word.size())
    throw InputError(fmt::format("{}: '{}' is not a number; write for example 0.5,-1e-3", who, word));
  return value;
}

/// CLI11 takes -1 for a number, and -.5 for options named '.' and '5'; a blank in front makes it a value. Numbers are
/// read without their blanks.
Words with_numbers_protected(int argc, const char* const* argv) {
  Words words(argv, argv + argc);
  for (std::string& word : words)
    if (word.compare(0, 2, "-.") == 0) word.insert(0, 1, ' ');
  return words;
}

void print_models() {
  fmt::print("a model file (*.toml, *.urdf), or a generator:\n");
  for (const GeneratorInfo& g : generators()) fmt::print("  {}\n      {}\n", g.usage, g.description);
}

void print_formulations() {
  for (const FormulationInfo& info : formulations()) fmt::print("{:<20} {}\n", info.name, info.idea);
}

}  // namespace

std::vector<double> read_numbers(const std::string& who, const std::string& text) {
  std::vector<double> numbers;
  constexpr const char* blanks = " \t\n";
  bool after_comma = false;
  for (std::size_t begin = text.find_first_not_of(blanks); begin != text.npos;) {
    const std::size_t end = std::min(text.find_first_of(", \t\n", begin), text.size());
    if (begin == end) throw InputError(fmt::format("{}: a number is missing before a comma in '{}'", who, text));
    numbers.push_back(read_number(who, text.substr(begin, end - begin)));
    begin = text.find_first_not_of(blanks, end);
    after_comma = begin != text.npos && text[begin] == ',';
    if (after_comma) begin = text.find_first_not_of(blanks, begin + 1);
  }
  if (after_comma) throw InputError(fmt::format("{}: a number is missing after the last comma of '{}'", who, text));
  return numbers;
}

std::vector<int> velocities_named(const Model& model, const std::string& who, const std::vector<std::string>& names) {
  const std::vector<std::string> all = model.velocity_names();
  std::vector<int> found;
  for (const std::string& name : names) {
    const auto at = std::find(all.begin(), all.end(), name);
    if (at == all.end())
      throw InputError(fmt::format("{}: there is no velocity '{}'; there are {}", who, name, fmt::join(all, ", ")));
    found.push_back(static_cast<int>(at - all.begin()));
  }
  return found;
}

struct StateProgram::State {
  std::string name;
  bool takes_loads, writes_csv;
  CLI::App app;
  std::string model, state_file, format = "text", out;
  Words time, q, v, tau, wrenches;
  bool assembles = false, within_limits = false;
  struct Numbers {
    std::string name;
    Words words;
    std::optional<std::vector<double>>* value;
  };
  std::vector<std::unique_ptr<Numbers>> own;

  State(std::string program, const std::string& description, bool loads, bool csv)
      : name(std::move(program)), takes_loads(loads), writes_csv(csv), app(description, name) {
    app.add_option("MODEL", model, "model file (*.toml, *.urdf) or generator such as chain:10; see --list-models")
        ->required();
    app.add_option("--time", time, "time t, s (default: the model's)")->expected(1);
    app.add_option("--q", q, "position coordinates, commas between (default: the model's)");
    app.add_option("--v", v, "velocity coordinates (default: the model's)");
    if (loads) {
      app.add_option("--tau", tau, "applied forces per velocity coordinate, N m or N (default: none)");
      app.add_option("--wrench", wrenches,
                     "BODY=mx,my,mz,fx,fy,fz: applied wrench, world axes, about the body's reference point; repeatable")
          ->allow_extra_args(false);
    }
    app.add_option("--state", state_file,
                   std::string("JSON file with t, q, v") + (loads ? ", tau, wrenches" : "") + ", all optional")
        ->check(given());
    app.add_flag("--assemble", assembles,
                 "move the state to the nearest one in which all loops are closed, and make velocities consistent");
    app.add_flag("--within-limits", within_limits,
                 "the same with every joint within its limits, nearest by least squares of all positions (Ipopt)");
    if (writes_csv) {
      out = name + ".csv";
      app.add_option("--out", out, "CSV to write, its JSON sidecar beside it; - is standard output")
          ->check(given())
          ->capture_default_str();
    } else {
      app.add_option("--format", format, "text or json")->check(CLI::IsMember({"text", "json"}))->capture_default_str();
      app.add_option("--out", out, "file to write to (default: standard output)")->check(given());
    }
    app.add_flag_callback(
        "--list-models", [] { throw(print_models(), CLI::Success()); }, "print the generators, and end");
    app.add_flag_callback(
        "--list-formulations", [] { throw(print_formulations(), CLI::Success()); }, "print the formulations, and end");
  }

  StateInput input() {
    Mechanism mechanism = load_mechanism(model);
    StateInput result{model, mechanism.model, std::move(mechanism.state), {}};
    result.format = format == "json" ? Format::json : Format::text;
    result.out = out;
    result.graph = std::move(mechanism.graph);
    if (!state_file.empty()) read_state_file(state_file, takes_loads, result);
    if (!time.empty()) {
      const std::vector<double> t = joined_numbers("--time", time);
      if (t.size() != 1) throw InputError("--time takes one number, in seconds");
      result.state.t = t[0];
    }
    if (app.count("--q") > 0) result.state.q = joined_numbers("--q", q);
    if (app.count("--v") > 0) result.state.v = joined_numbers("--v", v);
    result.state = checked_state(result.model, std::move(result.state));
    if (assembles || within_limits) result.state = assembled(result.model, std::move(result.state));
    if (!tau.empty()) result.loads.tau = joined_numbers("--tau", tau);
    if (!tau.empty() || !result.loads.tau.empty())
      result.loads.tau = checked_tau(result.model, std::move(result.loads.tau));
    for (const std::string& text : wrenches) {
      const std::size_t equals = text.rfind('=');
      if (equals == text.npos)
        throw InputError(fmt::format("--wrench '{}' is not of the form BODY=mx,my,mz,fx,fy,fz", text));
      result.loads.wrenches.push_back(applied_wrench(result.model, "--wrench", text.substr(0, equals),
                                                     read_numbers("--wrench", text.substr(equals + 1))));
    }
    for (const auto& numbers : own)
      if (!numbers->words.empty()) *numbers->value = joined_numbers(numbers->name, numbers->words);
    return result;
  }

  /// Tells on stderr how far it moved, so that stdout stays what --format says.
  lanc::State<double> assembled(const Model& mechanism, lanc::State<double> state) const {
    const char* option = within_limits ? "--within-limits" : "--assemble";
    AssemblyResult positions;
    std::string limits;
    if (within_limits) {
      LimitedAssemblyResult limited = assemble_within_limits(mechanism, std::move(state));
      if (!limited.reached.empty()) limits = "; " + to_text(mechanism, limited.reached);
      positions = std::move(limited);
    } else {
      positions = assemble(mechanism, std::move(state));
      const std::vector<ReachedLimit> violated = violated_limits(mechanism, positions.state.q);
      if (!violated.empty()) limits = fmt::format("; {}: see --within-limits", to_text(mechanism, violated));
    }
    if (!positions.assembled()) throw InputError(fmt::format("{}: {}", option, positions.message));
    const VelocityResult velocities = consistent_velocities(mechanism, positions.state);
    if (!velocities.consistent) throw InputError(fmt::format("{}: {}", option, velocities.message));
    fmt::print(
        stderr,
        "{}: assembled, {}largest change of a position {:.3g} rad, {:.3g} m; of a velocity, in model lengths and "
        "radians, {:.3g}/s{}\n",
        name, positions.starts > 1 ? fmt::format("at start {}, ", positions.starts) : "", positions.moved_angle,
        positions.moved_length, velocities.changed, limits);
    return velocities.state;
  }

  /// Refuses to write over the model or the state; a CSV has other files beside it.
  void protect_inputs() const {
    for (const char* beside : {"", ".json", ".checkpoint.json", ".state.json"}) {
      if (out.empty() || (*beside != 0 && !writes_csv)) continue;
      std::filesystem::path written = out;
      if (*beside != 0) written.replace_extension(beside);
      for (const std::string& input : {model, state_file}) {
        std::error_code none;  // a generator, or a file that is not there yet, is no input to lose
        if (std::filesystem::equivalent(written, input, none))
          throw InputError(Place{written}, "this is an input, and would be written over; choose another --out");
      }
    }
  }

  void write(const std::string& text) const {
    if (writes_csv) {
      fmt::print("{}", text);
      return;
    }
    std::FILE* file = out.empty() || out == "-" ? stdout : std::fopen(out.c_str(), "w");
    if (file == nullptr) throw InputError(Place{out}, "this file cannot be written");
    const bool written = std::fwrite(text.data(), 1, text.size(), file) == text.size();
    const bool flushed = (file == stdout ? std::fflush(file) : std::fclose(file)) == 0;
    if (!written || !flushed) throw InputError(Place{out.empty() ? "standard output" : out}, "writing failed");
  }
};

StateProgram::StateProgram(std::string name, std::string description, bool takes_loads, bool writes_csv)
    : state_(std::make_unique<State>(std::move(name), description, takes_loads, writes_csv)) {}
StateProgram::~StateProgram() = default;

void StateProgram::option(const std::string& name, std::string& value, const std::string& help) {
  state_->app.add_option(name, value, help)->check(given())->capture_default_str();
}

void StateProgram::option(const std::string& name, double& value, const Range& range, const std::string& help) {
  state_->app.add_option(name, value, help)->check(between(range.lowest, range.highest))->capture_default_str();
}

void StateProgram::option(const std::string& name, int& value, const Range& range, const std::string& help) {
  state_->app.add_option(name, value, help)->check(between(range.lowest, range.highest))->capture_default_str();
}

void StateProgram::list(const std::string& name, std::vector<std::string>& values, const std::string& help) {
  state_->app.add_option(name, values, help)->allow_extra_args(false);
}

void StateProgram::flag(const std::string& name, bool& value, const std::string& help) {
  state_->app.add_flag(name, value, help);
}

void StateProgram::numbers(const std::string& name, std::optional<std::vector<double>>& value,
                           const std::string& help) {
  state_->own.push_back(std::make_unique<State::Numbers>(State::Numbers{name, {}, &value}));
  state_->app.add_option(name, state_->own.back()->words, help);
}

int StateProgram::run(int argc, const char* const* argv, const std::function<StateOutput(const StateInput&)>& body) {
  constexpr int bad_input = 2;
  const Words words = with_numbers_protected(argc, argv);
  try {
    state_->app.parse(
        Words(words.rbegin(), words.rend() - 1));  // CLI11 takes a vector from its end, without the program
  } catch (const CLI::ParseError& error) {
    return state_->app.exit(error) == 0 ? 0 : bad_input;
  }
  try {
    StateInput input = state_->input();
    input.command_line.assign(argv, argv + argc);
    state_->protect_inputs();
    const StateOutput output = body(input);
    state_->write(output.text);
    return output.exit_code;
  } catch (const std::exception& error) {
    fmt::print(stderr, "{}: {}\n", state_->name, error.what());
    return bad_input;
  }
}

}  // namespace lanc
