// M̄, G and eq. 14 as Matrix Market files, with the names of their rows.
#include <fmt/format.h>

#include <filesystem>
#include <fstream>

#include "experiments/solve/answer.h"
#include "lib/io/matrix_market.h"
#include "lib/report/csv.h"
#include "lib/system/closure_jacobian.h"
#include "lib/system/eq14_matrix.h"
#include "lib/system/mass_matrix.h"

namespace lanc {
namespace {

constexpr int most_velocities = 3000;  // a full M̄ of this size takes about 200 MB

constexpr const char* readme = R"(# Coefficients of eq. 14 at one state

Matrix Market files; a symmetric one holds its lower triangle. SI units, world axes.

| file | what |
|---|---|
| `mass_matrix.mtx` | M̄ = JᵀMJ with armature; rows in `velocities.csv` |
| `closure_jacobian.mtx` | G, a column a velocity; rows in `closure_rows.csv`, none where no loop is closed |
| `eq14.mtx` | the matrix of eq. 14, body by body (â, f̂, η̇), λ of a closure row behind its bodies; rows in `eq14_rows.csv` |
| `eq14_rhs.mtx` | its right-hand side |

A row of `eq14_rows.csv` names the unknown of that column and the equation of that row: (3) momentum balance, (8)
acceleration across the joint, (12) force along the joint's freedoms, and `closure`: −G_s â − G_η η̇ = γ̿. All closure
rows are there, redundant ones, too.
)";

std::ofstream open(const std::filesystem::path& path) {
  std::ofstream file(path);
  if (!file) throw InputError(Place{path.string()}, "this file cannot be written");
  return file;
}

void write_text(const std::filesystem::path& path, const std::string& text) {
  std::ofstream file = open(path);
  file << text;
  if (!file.flush()) throw InputError(Place{path.string()}, "writing failed; is the disk full?");
}

void write_mass_matrix(const System<double>& system, const std::filesystem::path& folder, const std::string& comment) {
  const int n = system.model.nv();
  const std::vector<double> M = mass_matrix(system);
  // structure: coordinates of bodies of which one carries the other
  std::int64_t entries = 0;
  for (int c = 0; c < n; ++c)
    for (int r = c; r < n; ++r) entries += M[static_cast<std::size_t>(c) * n + r] != 0;
  MatrixMarket file((folder / "mass_matrix.mtx").string(), comment, {n, n, entries, true});
  for (int c = 0; c < n; ++c)
    for (int r = c; r < n; ++r)
      if (const double x = M[static_cast<std::size_t>(c) * n + r]; x != 0) file.entry(r, c, x);
  file.finish();
}

void write_closure_jacobian(const System<double>& system, const std::filesystem::path& folder,
                            const std::string& comment) {
  ClosureJacobian<double> G(system.model);
  G.evaluate(system);
  MatrixMarket file((folder / "closure_jacobian.mtx").string(), comment,
                    {G.rows(), system.model.nv(), static_cast<std::int64_t>(G.values().size()), false});
  for (int k = 0; k < G.rows(); ++k)
    for (int p = G.starts()[k]; p < G.starts()[k + 1]; ++p) file.entry(k, G.columns()[p], G.values()[p]);
  file.finish();
  std::string rows = "row,closure_row\n";
  for (int k = 0; k < G.rows(); ++k)
    rows += fmt::format("{},{}\n", k + 1, csv_field(system.model.closures().row_names[k]));
  write_text(folder / "closure_rows.csv", rows);
}

std::string eq14_rows(const Model& model, const Eq14Matrix<double>& matrix) {
  constexpr const char* motions[] = {"wdot_x", "wdot_y", "wdot_z", "vdot_x", "vdot_y", "vdot_z"};
  constexpr const char* wrenches[] = {"m_x", "m_y", "m_z", "f_x", "f_y", "f_z"};
  std::vector<std::string> rows(matrix.size());
  const std::vector<std::string> velocities = model.velocity_names();
  const auto line = [&](int row, const std::string& unknown, const std::string& owner, const char* equation) {
    rows[row] = fmt::format("{},{},{},{}\n", row + 1, unknown, csv_field(owner), equation);
  };
  for (int i = 0; i < model.bodies(); ++i) {
    const std::string& body = model.spec().bodies[i].name;
    for (int k = 0; k < 6; ++k) {
      line(matrix.row(i, Block::acceleration) + k, motions[k], body, "3");
      line(matrix.row(i, Block::wrench) + k, wrenches[k], model.spec().joints[i].name, "8");
    }
    for (int k = 0; k < model.link(i).nv; ++k)
      line(matrix.row(i, Block::velocity) + k, "vdot", velocities[model.link(i).v + k], "12");
  }
  for (int k = 0; k < model.closures().rows(); ++k)
    line(matrix.row(k, Block::closure), "lambda", model.closures().row_names[k], "closure");
  std::string text = "row,unknown,of,equation\n";
  for (const std::string& row : rows) text += row;
  return text;
}

void write_eq14(const System<double>& system, const std::filesystem::path& folder, const std::string& comment) {
  Eq14Layout layout;
  layout.bodies = BodyOrder::root_to_leaf;
  layout.upper_triangle = true;
  Eq14Matrix<double> matrix(system.model, layout);
  matrix.refill(system);
  const int zeros = system.model.closures().rows();  // on the diagonal, kept for rows that do not count
  MatrixMarket file((folder / "eq14.mtx").string(), comment,
                    {matrix.size(), matrix.size(), matrix.nonzeros() - zeros, true});
  for (int c = 0; c < matrix.size(); ++c) {  // a column of the upper triangle is a row of the lower one
    const bool closure = matrix.closure_of_column(c) >= 0;
    for (int k = matrix.starts()[c]; k < matrix.starts()[c + 1]; ++k)
      if (!(closure && matrix.rows()[k] == c)) file.entry(c, matrix.rows()[k], matrix.values()[k]);
  }
  file.finish();
  std::vector<double> b(matrix.size());
  matrix.scatter(system.rhs, b);
  write_matrix_market((folder / "eq14_rhs.mtx").string(), comment, b);
  write_text(folder / "eq14_rows.csv", eq14_rows(system.model, matrix));
}

}  // namespace

void export_matrices(const StateInput& input, const std::string& folder_name) {
  const Model& model = input.model;
  const std::filesystem::path folder(folder_name);
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error) throw InputError(Place{folder_name}, "this folder cannot be made: " + error.message());
  if (model.nv() > most_velocities)
    throw InputError(
        fmt::format("--export: M̄ of {} velocities is full and too large for a file; at most {} are "
                    "exported",
                    model.nv(), most_velocities));
  Evaluator<double> evaluator(model);
  const System<double>& system = evaluator.system(input.state, input.loads);
  std::string name = input.argument;
  std::replace(name.begin(), name.end(), '\n', ' ');
  const std::string comment = fmt::format("{} at t = {} s", name, input.state.t);
  write_mass_matrix(system, folder, comment);
  write_closure_jacobian(system, folder, comment);
  write_eq14(system, folder, comment);
  std::string velocities = "row,velocity\n";
  for (int k = 0; const std::string& velocity : model.velocity_names())
    velocities += fmt::format("{},{}\n", ++k, csv_field(velocity));
  write_text(folder / "velocities.csv", velocities);
  write_text(folder / "README.md", readme);
}

}  // namespace lanc
