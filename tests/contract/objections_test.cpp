// The matrix formulation × kind of model. Every answer that is not `solved`, allowed or expected, is a line of
// objections.csv; a new one fails, and so does a line that is no longer true.
//
// LANC_PRINT_OBJECTIONS=1 prints the lines as they are now.
#include <gtest/gtest.h>

#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <map>
#include <sstream>

#include "lib/formulation/formulation.h"
#include "lib/system/equations.h"
#include "lib/system/evaluator.h"
#include "tests/support/naive.h"
#include "tests/support/tolerance.h"
#include "tests/support/zoo.h"

namespace lanc::test {
namespace {

struct Line {
  std::string status, reason;
};
using Matrix = std::map<std::pair<std::string, std::string>, Line>;  // (formulation, kind of model)

/// formulation;kind;status;reason, with # for comments. Semicolons, since names and reasons contain commas.
Matrix read_matrix(const std::string& path) {
  Matrix matrix;
  std::ifstream file(path);
  EXPECT_TRUE(file) << path;
  for (std::string line; std::getline(file, line);) {
    if (line.empty() || line[0] == '#') continue;
    std::vector<std::string> cells;
    std::istringstream split(line);
    for (std::string cell; std::getline(split, cell, ';');) cells.push_back(cell);
    EXPECT_EQ(cells.size(), 4u) << "not formulation;kind;status;reason: " << line;
    if (cells.size() == 4) matrix[{cells[0], cells[1]}] = {cells[2], cells[3]};
  }
  return matrix;
}

struct Result {
  std::string status, message;
  Norms error;
};

Result run(const FormulationInfo& info, const Case& c, const System<double>& system,
           const Solution<long double>* reference, const Norms& size) {
  if (!info.create_double) return {"objection", "not offered in double", {}};
  if (const auto objection = info.objection(c.model)) return {"objection", *objection, {}};
  Solution<double> solution(c.model);
  Outcome outcome;
  try {
    outcome = info.create_double(c.model)->solve(system, solution);
  } catch (const std::exception& error) {
    return {"exception", error.what(), {}};  // never allowed
  }
  Result result{std::string(to_string(outcome.status)), outcome.message, {}};
  if (outcome.usable() && reference) result.error = relative(difference(c.model, solution, *reference), size);
  return result;
}

TEST(Objections, matrix_of_formulations_and_kinds_of_model_is_the_one_of_the_file) {
  const Matrix allowed = read_matrix(LANC_SOURCE_DIR "/tests/contract/objections.csv");
  std::map<std::pair<std::string, std::string>, bool> met;
  const bool print = std::getenv("LANC_PRINT_OBJECTIONS") != nullptr;
  for (const Kind& kind : zoo()) {
    SCOPED_TRACE(kind.name);
    const Case c = kind.make();
    Evaluator<double> evaluator(c.model);
    const System<double>& system = evaluator.system(c.state, c.loads);
    Solution<long double> reference(c.model);
    Norms size;
    if (kind.solvable) {
      reference = reference_solution(c);
      size = sizes(system_in_long_double(c), reference);
    }
    for (const FormulationInfo& info : formulations()) {
      const std::string name(info.name);
      const Result result = run(info, c, system, kind.solvable ? &reference : nullptr, size);
      const auto line = allowed.find({name, kind.name});
      const std::string expected = line != allowed.end() ? line->second.status : "solved";
      met[{name, kind.name}] = true;
      EXPECT_EQ(result.status, expected) << name << " on " << kind.name << ": " << result.message;
      if (!kind.solvable) {
        EXPECT_NE(result.status, "solved") << name << " on " << kind.name;
      }
      if (result.status != "solved") {
        EXPECT_FALSE(result.message.empty()) << name << " on " << kind.name << " says nothing about its status";
        if (print)
          std::printf("%s;%s;%s;%s\n", name.c_str(), kind.name.c_str(), result.status.c_str(), result.message.c_str());
      } else if (kind.solvable) {
        // Conditioning grows with the square of the length of a chain, in the worst case.
        const double n = c.model.bodies();
        EXPECT_TRUE(within(name + " on " + kind.name, result.error.worst(), kind.condition * (1 + 1e-2 * n * n), 1));
      }
    }
  }
  for (const auto& entry : allowed) {
    if (!find_formulation(entry.first.first)) continue;  // not built in, for example without the GPL parts
    EXPECT_TRUE(met.count(entry.first)) << "no such kind of model: " << entry.first.second;
  }
}

}  // namespace
}  // namespace lanc::test
