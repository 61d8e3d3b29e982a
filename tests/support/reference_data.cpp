#include "tests/support/reference_data.h"

#include <cmath>
#include <fstream>
#include <sstream>
#include <stdexcept>

namespace lanc::test {
namespace {

/// "12.340e-2": 12.34e-2 with half a unit of 1e-5.
Printed parse(const std::string& text) {
  const std::size_t exponent = text.find_first_of("eE"), point = text.find('.');
  const std::size_t end = exponent == std::string::npos ? text.size() : exponent;
  const int decimals = point == std::string::npos ? 0 : static_cast<int>(end - point - 1);
  const int power = exponent == std::string::npos ? 0 : std::stoi(text.substr(exponent + 1));
  return {std::stod(text), 0.5 * std::pow(10, power - decimals)};
}

}  // namespace

ReferenceData read_reference(const std::string& file) {
  const std::string path = std::string(LANC_SOURCE_DIR) + "/data/reference/" + file;
  std::ifstream stream(path);
  ReferenceData data;
  bool source = false, licence = false;
  for (std::string line; std::getline(stream, line);) {
    source = source || line.rfind("# Source: ", 0) == 0;
    licence = licence || line.find("Licence: ") != std::string::npos;
    if (line.empty() || line[0] == '#') continue;
    std::istringstream cells(line);
    std::string name;
    std::getline(cells, name, ',');
    for (std::string cell; std::getline(cells, cell, ',');) data[name].push_back(parse(cell));
  }
  if (data.empty() || !source || !licence)
    throw std::runtime_error(path + ": missing, empty, or without source and licence");
  return data;
}

std::vector<double> values(const std::vector<Printed>& printed) {
  std::vector<double> result;
  for (const Printed& p : printed) result.push_back(p.value);
  return result;
}

}  // namespace lanc::test
