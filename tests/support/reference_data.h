// Published numbers: data/reference/*.csv, lines of a name and its numbers, with source and licence in comments.
#pragma once

#include <map>
#include <string>
#include <vector>

namespace lanc::test {

/// A number as it is printed, with half a unit of its last digit.
struct Printed {
  double value, half_unit;
};

using ReferenceData = std::map<std::string, std::vector<Printed>>;

/// Throws std::runtime_error when the file is missing, holds no numbers, or names neither source nor licence.
ReferenceData read_reference(const std::string& file);

std::vector<double> values(const std::vector<Printed>& printed);

}  // namespace lanc::test
