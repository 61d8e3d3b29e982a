#include <fmt/format.h>

#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "experiments/simulate/run.h"
#include "lib/model/error.h"

namespace lanc {

std::string checkpoint_name(const std::string& csv) {
  return std::filesystem::path(csv).replace_extension(".checkpoint.json");
}

/// Decimal numbers with as many digits as it takes to read the same double back.
void write_checkpoint(const std::string& csv, const Checkpoint& c) {
  const nlohmann::ordered_json document = {{"t", c.point.state.t},
                                           {"q", c.point.state.q},
                                           {"v", c.point.state.v},
                                           {"work", c.point.work},
                                           {"next_step", c.next_step},
                                           {"start_energy", c.start_energy},
                                           {"rank", c.rank},
                                           {"independent", c.independent},
                                           {"steps", {c.steps.steps, c.steps.rejected, c.steps.newton_iterations}},
                                           {"evaluations",
                                            {c.evaluations.rates, c.evaluations.jacobians, c.evaluations.kinematics,
                                             c.evaluations.dual_kinematics}}};
  replace_file(checkpoint_name(csv), document.dump(1) + "\n");
}

std::optional<Checkpoint> read_checkpoint(const std::string& csv, const Model& model) {
  const std::string name = checkpoint_name(csv);
  if (!std::filesystem::exists(name)) return std::nullopt;
  try {
    const nlohmann::json document = nlohmann::json::parse(std::ifstream(name));
    Checkpoint c;
    c.point = {{document.at("t"), document.at("q"), document.at("v")}, document.at("work")};
    c.next_step = document.at("next_step"), c.start_energy = document.at("start_energy");
    c.rank = document.at("rank");
    c.independent = document.at("independent").get<std::vector<int>>();
    const std::vector<long> steps = document.at("steps"), evaluations = document.at("evaluations");
    c.steps = {steps.at(0), steps.at(1), steps.at(2)};
    c.evaluations = {evaluations.at(0), evaluations.at(1), evaluations.at(2), evaluations.at(3)};
    if (static_cast<int>(c.point.state.q.size()) != model.nq() || static_cast<int>(c.point.state.v.size()) != model.nv())
      throw InputError(Place{name}, "this checkpoint is of another model; run without --resume");
    return c;
  } catch (const std::exception& error) {
    if (dynamic_cast<const InputError*>(&error)) throw;
    throw InputError(Place{name}, fmt::format("this checkpoint cannot be read ({}); run without --resume", error.what()));
  }
}

}  // namespace lanc
