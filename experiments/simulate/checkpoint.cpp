#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <set>

#include "experiments/simulate/run.h"
#include "lib/model/error.h"

namespace lanc {

std::string checkpoint_name(const std::string& csv) {
  return std::filesystem::path(csv).replace_extension(".checkpoint.json");
}

namespace {

nlohmann::ordered_json written(const MotionPoint& point) {
  return {{"t", point.state.t}, {"q", point.state.q}, {"v", point.state.v}, {"work", point.work}};
}

MotionPoint read_motion_point(const nlohmann::json& object, const Model& model) {
  MotionPoint point{{object.at("t"), object.at("q"), object.at("v")}, object.at("work")};
  if (static_cast<int>(point.state.q.size()) != model.nq() || static_cast<int>(point.state.v.size()) != model.nv())
    throw InputError("it is of another model");
  return point;
}

}  // namespace

/// Decimal numbers with as many digits as it takes to read the same double back.
void write_checkpoint(const std::string& csv, const Checkpoint& c) {
  nlohmann::ordered_json document = written(c.point);
  document["next_step"] = c.next_step;
  document["start_energy"] = c.start_energy;
  document["rank"] = c.rank;
  document["independent"] = c.independent;
  document["steps"] = {c.steps.steps, c.steps.rejected, c.steps.newton_iterations};
  const MotionCounts& e = c.evaluations;
  document["evaluations"] = {e.rates, e.jacobians, e.kinematics, e.dual_kinematics};
  document["passed"] = nlohmann::ordered_json::array();
  for (const PassedStep& step : c.passed) {
    document["passed"].push_back(written(step.point));
    document["passed"].back()["sigma"] = step.sigma;
  }
  replace_file(checkpoint_name(csv), document.dump(1) + "\n");
}

std::optional<Checkpoint> read_checkpoint(const std::string& csv, const Model& model) {
  const std::string name = checkpoint_name(csv);
  if (!std::filesystem::exists(name)) return std::nullopt;
  try {
    const nlohmann::json document = nlohmann::json::parse(std::ifstream(name));
    Checkpoint c;
    c.point = read_motion_point(document, model);
    c.next_step = document.at("next_step"), c.start_energy = document.at("start_energy");
    c.rank = document.at("rank");
    c.independent = document.at("independent").get<std::vector<int>>();
    const std::vector<long> steps = document.at("steps"), evaluations = document.at("evaluations");
    c.steps = {steps.at(0), steps.at(1), steps.at(2)};
    c.evaluations = {evaluations.at(0), evaluations.at(1), evaluations.at(2), evaluations.at(3)};
    const int freedoms = model.nv() - std::max(c.rank, 0);
    const std::set<int> different(c.independent.begin(), c.independent.end());
    if (c.rank < -1 || c.rank > std::min(model.nv(), model.closures().rows()) ||
        (!c.independent.empty() && (static_cast<int>(different.size()) != freedoms || *different.begin() < 0 ||
                                    *different.rbegin() >= model.nv() || different.size() != c.independent.size())))
      throw InputError("its rank or its independent velocities cannot be those of this model");
    for (const nlohmann::json& step : document.at("passed"))
      c.passed.push_back({read_motion_point(step, model), step.at("sigma")});
    return c;
  } catch (const std::exception& error) {
    throw InputError(Place{name},
                     fmt::format("this checkpoint cannot be read ({}); run without --resume", error.what()));
  }
}

}  // namespace lanc
