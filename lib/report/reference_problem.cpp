#include "lib/report/reference_problem.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <fstream>
#include <iterator>

#include "lib/io/toml_reader.h"
#include "lib/report/csv.h"

namespace lanc {
namespace {

std::string file_contents(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  if (!in) throw InputError(Place{path}, "this file cannot be read");
  return {std::istreambuf_iterator<char>(in), {}};
}

double number(const std::string& text, const std::string& path, int line) {
  double value = 0;
  const auto [last, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || last != text.data() + text.size())
    throw InputError(Place{path, line, 1}, fmt::format("'{}' is not a number", text));
  return value;
}

/// Comments begin with #; then the header, then a value a line.
std::vector<ReferenceValue> read_values(const std::string& path) {
  static const std::vector<std::string> header = {"t", "quantity", "value", "tolerance", "factor", "origin"};
  const std::string text = file_contents(path);
  std::vector<ReferenceValue> values;
  bool begun = false;
  int line = 0;
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t end = std::min(text.find('\n', at), text.size());
    const std::string row = text.substr(at, end - at);
    at = end + 1, ++line;
    if (row.empty() || row[0] == '#') continue;
    const std::vector<std::string> fields = read_csv(row + "\n").at(0).fields;
    if (!begun && fields != header)
      throw InputError(Place{path, line, 1}, fmt::format("the header must be {}", fmt::join(header, ",")));
    if (begun) {
      if (fields.size() != header.size())
        throw InputError(Place{path, line, 1}, fmt::format("{} fields, not {}", fields.size(), header.size()));
      values.push_back({number(fields[0], path, line), fields[1], number(fields[2], path, line),
                        number(fields[3], path, line), number(fields[4], path, line), fields[5]});
    }
    begun = true;
  }
  if (values.empty()) throw InputError(Place{path}, "no values");
  std::stable_sort(values.begin(), values.end(), [](const auto& a, const auto& b) { return a.t < b.t; });
  return values;
}

std::vector<std::string> texts(const TomlTable& table, std::string_view key) {
  std::vector<std::string> list;
  const toml::node* node = table.find(key);
  if (!node) return list;
  if (!node->is_array()) table.fail(*node, fmt::format("{} must be an array of texts", key));
  for (const toml::node& entry : *node->as_array()) {
    if (!entry.is_string()) table.fail(entry, fmt::format("{} must be an array of texts", key));
    list.push_back(entry.as_string()->get());
  }
  return list;
}

}  // namespace

std::vector<ReferenceProblem> read_reference_problems(const std::string& data) {
  const std::string path = data + "/reference/problems.toml";
  const toml::table source = parse_toml(file_contents(path), path);
  static constexpr std::string_view top[] = {"problem"};
  static constexpr std::string_view keys[] = {"number", "name",      "source", "model",
                                              "end",    "reference", "points", "tests"};
  std::vector<ReferenceProblem> problems;
  for (const toml::table* entry : TomlTable(source, path, "problems", top).tables("problem")) {
    const TomlTable table(*entry, path, "problem", keys);
    ReferenceProblem problem{.number = table.text("number"),
                             .name = table.text("name"),
                             .source = table.text("source"),
                             .model = table.text("model"),
                             .end = table.number("end"),
                             .points = texts(table, "points"),
                             .reference = table.text("reference"),
                             .tests = texts(table, "tests")};
    if (problem.number.empty() || problem.name.empty() || problem.source.empty())
      table.fail("number, name and source are needed");
    if (problem.model.empty() == problem.tests.empty()) table.fail("give a model, or tests that check it");
    if (!problem.model.empty()) {
      if (problem.reference.empty()) table.fail("a model needs a reference");
      if (problem.model.find(".toml") != std::string::npos) problem.model = data + "/models/" + problem.model;
      problem.values = read_values(data + "/reference/" + problem.reference);
    }
    problems.push_back(std::move(problem));
  }
  return problems;
}

}  // namespace lanc
