// The result of an experiment: a tidy CSV, one number a row, and a JSON sidecar that says how it was made.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "lib/formulation/outcome.h"

namespace lanc {

/// What a group of rows is about. All rows of a cell are written at once; a cell is what --resume skips or repeats.
struct Cell {
  std::string model;  // as on the command line
  int bodies = 0, velocities = 0, closure_rows = 0;
  std::string formulation;
  std::string parameters;  // key=value;key=value
  std::optional<std::uint64_t> seed;
  std::optional<int> repetition;  // none: the numbers are exact, or a summary of all repetitions
};

/// One number. Phases: kinematics analyse assemble rank factorise solve total, or empty.
struct Measurement {
  std::string phase, metric;
  double value = 0;  // not finite: a row without a result, written as an empty value
  std::string unit;
  std::string status = std::string(to_string(Status::solved));
};

struct Row {
  Cell cell;
  Measurement measurement;
};

/// The columns of every CSV, in order.
std::span<const std::string_view> csv_columns();

/// The row as one line of CSV with its line break, and back. Reading throws InputError.
std::string csv_line(std::string_view experiment, const Cell& cell, const Measurement& measurement);
Row csv_row(std::span<const std::string> fields);

/// Whole or not at all: into a file beside it, which then takes its name. Throws InputError.
void replace_file(const std::string& name, const std::string& text);

/// Writes FILE.csv and FILE.json. From construction until destruction SIGINT and SIGTERM end the program with exit
/// code 130 and 143 between two cells: cells are written whole, in one write, so that the CSV is valid whenever the
/// program ends. One at a time. Tested by tests/report/report_test.cpp.
class Report {
 public:
  struct Description {
    std::string experiment;
    std::string file;     // "-": standard output, and no sidecar
    std::string sidecar;  // JSON object: how the numbers are made (lib/report/sidecar.h)
    bool resume = false;
  };

  /// Begins a CSV, or continues one: an incomplete last row and the cell it belongs to are dropped, and measured again.
  /// Throws InputError when the file cannot be written, or is of another experiment, version, build or of other options
  /// than the sidecar beside it says.
  explicit Report(const Description& description);
  ~Report();
  Report(const Report&) = delete;
  Report& operator=(const Report&) = delete;

  /// True when the CSV that is continued has this cell already.
  bool has(const Cell& cell) const;
  /// Writes the rows of a cell.
  void write(const Cell& cell, std::span<const Measurement> measurements);
  /// All rows so far, those of the continued file included.
  const std::vector<Row>& rows() const;
  /// Notes in the sidecar that the experiment came to its end. Returns the path of the CSV.
  const std::string& finish();

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace lanc
