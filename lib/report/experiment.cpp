#include "lib/report/experiment.h"

#include <fmt/format.h>
#include <fnmatch.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <utility>

#include "lib/io/generators.h"
#include "lib/model/error.h"
#include "lib/report/option_checks.h"
#include "lib/report/sidecar.h"

namespace lanc {

namespace {

bool is_glob(const std::string& text) { return text.find_first_of("*?[") != std::string::npos; }

bool matches(const std::string& glob, const std::string& text) {
  return glob == text || ::fnmatch(glob.c_str(), text.c_str(), 0) == 0;
}

std::string text_of(const std::vector<std::string>& list) { return fmt::format("{}", fmt::join(list, " ")); }

}  // namespace

std::vector<std::string> matching(const std::vector<std::string>& all, const std::string& glob) {
  if (!is_glob(glob)) return {glob};
  std::vector<std::string> found;
  std::copy_if(all.begin(), all.end(), std::back_inserter(found),
               [&](const auto& text) { return matches(glob, text); });
  return found;
}

struct Experiment::State {
  Description description;
  CLI::App app;
  CommonOptions options;
  bool list_models = false, list_formulations = false;
  std::vector<std::function<std::pair<std::string, std::string>()>> own_options;
  std::vector<std::string> models;
  std::vector<const FormulationInfo*> formulations;
  std::unique_ptr<Progress> progress;
  std::unique_ptr<Report> report;

  explicit State(Description d) : description(std::move(d)), app(description.question, description.name) {
    options.out = description.name + ".csv";
    options.repetitions = description.repetitions;
    app.add_option("--out", options.out, "CSV to write, its JSON sidecar beside it; - is standard output")
        ->check(given())
        ->capture_default_str();
    app.add_option("--models", options.models, "model arguments, or globs over those of --list-models (default: all)");
    app.add_option("--formulations", options.formulations, "globs over --list-formulations (default: all)");
    app.add_option("--seed", options.seed, "seed of the generators and of resampling")
        ->check(seed())
        ->capture_default_str();
    app.add_option("--repetitions", options.repetitions, "times everything is timed; medians are over them")
        ->check(between(1, 1e6))
        ->capture_default_str();
    app.add_flag("--quick", options.quick, "a small choice of models, done in under 20 s");
    app.add_flag("--quiet", options.quiet, "no progress on stderr");
    app.add_flag("--resume", options.resume, "continue an interrupted CSV");
    app.add_flag("--list-models", list_models, "print the models of this run and the generators, and end");
    app.add_flag("--list-formulations", list_formulations, "print the formulations, and end");
  }

  /// Resolves globs. Throws InputError when one matches nothing.
  void choose() {
    if (options.quick && app.count("--repetitions") == 0) options.repetitions = description.quick_repetitions;
    const std::vector<std::string> all = description.models(options.quick);
    models = options.models.empty() ? all : std::vector<std::string>();
    for (const std::string& glob : options.models) {
      const auto found = matching(all, glob);
      if (found.empty())
        throw InputError(fmt::format("--models '{}' matches nothing; --list-models shows what there is", glob));
      for (const std::string& model : found)
        if (std::find(models.begin(), models.end(), model) == models.end()) models.push_back(model);
    }
    for (const FormulationInfo& info : lanc::formulations()) {
      const std::string name(info.name);
      const bool chosen = options.formulations.empty()
                              ? !description.formulations || description.formulations(info)
                              : std::any_of(options.formulations.begin(), options.formulations.end(),
                                            [&](const auto& glob) { return matches(glob, name); });
      if (chosen) formulations.push_back(&info);
    }
    for (const std::string& glob : options.formulations)
      if (std::none_of(formulations.begin(), formulations.end(),
                       [&](const auto* info) { return matches(glob, std::string(info->name)); }))
        throw InputError(
            fmt::format("--formulations '{}' matches nothing; --list-formulations shows what there is", glob));
  }

  void print_models() const {
    for (const std::string& model : models) fmt::print("{}\n", model);
    fmt::print("\nor any file, or of the generators:\n");
    for (const GeneratorInfo& g : generators()) fmt::print("  {:<44} {}\n", g.usage, g.description);
  }

  std::vector<std::pair<std::string, std::string>> resume_options() const {
    std::vector<std::pair<std::string, std::string>> list = {{"models", text_of(options.models)},
                                                             {"formulations", text_of(options.formulations)},
                                                             {"seed", std::to_string(options.seed)},
                                                             {"repetitions", std::to_string(options.repetitions)},
                                                             {"quick", options.quick ? "yes" : "no"}};
    for (const auto& own : own_options) list.push_back(own());
    return list;
  }
};

Experiment::Experiment(Description description) : state_(std::make_unique<State>(std::move(description))) {}
Experiment::~Experiment() = default;

void Experiment::option(const std::string& name, int& value, const std::string& help) {
  state_->app.add_option(name, value, help)->capture_default_str();
  state_->own_options.push_back([name, &value] { return std::pair(name.substr(2), std::to_string(value)); });
}

void Experiment::option(const std::string& name, double& value, const Range& range, const std::string& help) {
  state_->app.add_option(name, value, help)->check(between(range.lowest, range.highest))->capture_default_str();
  state_->own_options.push_back([name, &value] { return std::pair(name.substr(2), fmt::format("{}", value)); });
}

void Experiment::option(const std::string& name, std::string& value, const std::string& help) {
  state_->app.add_option(name, value, help)->check(given())->capture_default_str();
  state_->own_options.push_back([name, &value] { return std::pair(name.substr(2), value); });
}

int Experiment::run(int argc, const char* const* argv, const std::function<void(Experiment&)>& body) {
  constexpr int bad_options = 2;
  State& s = *state_;
  try {
    s.app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return s.app.exit(error) == 0 ? 0 : bad_options;
  }
  const auto fail = [&](const std::exception& error, int code) {
    if (s.progress) s.progress->clear();
    fmt::print(stderr, "{}: {}\n", s.description.name, error.what());
    return code;
  };
  try {
    s.choose();
    if (s.list_models) return s.print_models(), 0;
    if (s.list_formulations) {
      for (const auto* info : s.formulations) fmt::print("{:<20} {}\n", info->name, info->idea);
      return 0;
    }
    for (const std::string& model : s.models)
      if (!s.options.models.empty()) load(model);  // a model that cannot be read is better told now than in an hour
    if (const auto warning = build_warning(build_info())) fmt::print(stderr, "{}\n", *warning);
    const std::vector<std::string> command_line(argv, argv + argc);
    s.progress = std::make_unique<Progress>(s.description.name, s.options.quiet);
    s.report = std::make_unique<Report>(Report::Description{
        s.description.name, s.options.out,
        sidecar(s.description.name, command_line, s.resume_options(), s.options.seed, s.description.libraries),
        s.options.resume});
  } catch (const InputError& error) {
    return fail(error, bad_options);
  }
  try {
    body(*this);
    s.progress->clear();
    s.report->finish();
  } catch (const InputError& error) {
    return fail(error, bad_options);
  } catch (const std::exception& error) {
    return fail(error, 1);
  }
  return 0;
}

const CommonOptions& Experiment::options() const { return state_->options; }
const std::vector<std::string>& Experiment::models() const { return state_->models; }
const std::vector<const FormulationInfo*>& Experiment::formulations() const { return state_->formulations; }
Report& Experiment::report() { return *state_->report; }
Progress& Experiment::progress() { return *state_->progress; }

Mechanism Experiment::load(const std::string& model) const {
  const bool generated = std::any_of(lanc::generators().begin(), lanc::generators().end(),
                                     [&](const auto& g) { return model.compare(0, model.find(':'), g.name) == 0; });
  if (state_->options.seed != CommonOptions().seed && generated && model.find(":seed=") == std::string::npos)
    return load_mechanism(fmt::format("{}:seed={}", model, state_->options.seed));
  return load_mechanism(model);
}

Cell Experiment::cell(const std::string& name, const Model& model, const std::string& formulation,
                      const std::string& parameters, std::optional<int> repetition) const {
  Cell cell;
  cell.model = name;
  cell.bodies = model.bodies();
  cell.velocities = model.nv();
  cell.closure_rows = model.closures().rows();
  cell.formulation = formulation;
  cell.parameters = parameters;
  cell.seed = state_->options.seed;
  cell.repetition = repetition;
  return cell;
}

}  // namespace lanc
