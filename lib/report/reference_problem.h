// The published problems of data/reference: what is to be reproduced, and how exactly.
#pragma once

#include <string>
#include <vector>

namespace lanc {

/// One number that was published, or recomputed from a publication by other means than this library's.
struct ReferenceValue {
  double t = 0;          // s
  std::string quantity;  // a name of Quantities (lib/integrate/quantities.h)
  double value = 0;      // factor × our quantity
  double tolerance = 0;  // absolute, of `value`
  double factor = 1;     // maps conventions
  std::string origin;    // "published" or "recomputed"
};

/// One entry of data/reference/problems.toml.
struct ReferenceProblem {
  std::string number, name, source;
  std::string model;                // model argument; empty: `tests` check it
  double end = 0;                   // s; 0: no motion, a state of rest
  std::vector<std::string> points;  // as read_point() takes them
  std::string reference;            // name of the CSV
  std::vector<std::string> tests;
  std::vector<ReferenceValue> values;  // by time

  /// What programs call it: the name of the CSV without its ending.
  std::string short_name() const { return reference.substr(0, reference.find('.')); }
};

/// All of them, from the folder `data`; model files with their paths. Throws InputError with file and line.
/// Tested by tests/reference/problems_test.cpp.
std::vector<ReferenceProblem> read_reference_problems(const std::string& data);

}  // namespace lanc
