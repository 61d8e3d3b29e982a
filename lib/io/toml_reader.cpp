#include "lib/io/toml_reader.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "lib/io/text.h"

namespace lanc {
namespace {

std::string_view type_name(const toml::node& node) {
  switch (node.type()) {
    case toml::node_type::table: return "a table";
    case toml::node_type::array: return "an array";
    case toml::node_type::string: return "a string";
    case toml::node_type::integer: return "an integer";
    case toml::node_type::floating_point: return "a number";
    case toml::node_type::boolean: return "true or false";
    default: return "a date or time";
  }
}

/// Index behind the string that begins at `at`; the end of the text when it does not end.
std::size_t skip_string(std::string_view text, std::size_t at) {
  const char quote = text[at];
  const std::string triple(3, quote);
  const bool escapes = quote == '"', multiline = text.substr(at, 3) == triple;
  at += multiline ? 3 : 1;
  for (; at < text.size(); ++at) {
    if (escapes && text[at] == '\\') {
      ++at;
    } else if (multiline && text.substr(at, 3) == triple) {
      for (at += 3; at < text.size() && text[at] == quote;) ++at;  // the string may end with quotes of its own
      return at;
    } else if (!multiline && (text[at] == quote || text[at] == '\n')) {
      return at + 1;
    }
  }
  return text.size();
}

/// toml++ limits the nesting of values, but makes a table for every part of a.dotted.key, and destroys them
/// recursively: a line of dots would overflow the stack. No key of the format has more than two dots.
void refuse_deep_keys(std::string_view text, const std::string& file) {
  constexpr int most = 8;
  int dots = 0, line = 1;
  std::size_t line_start = 0;
  for (std::size_t at = 0; at < text.size();) {
    const char c = text[at];
    if (c == '"' || c == '\'') {
      const std::size_t end = skip_string(text, at);
      for (; at < end && at < text.size(); ++at)
        if (text[at] == '\n') ++line, line_start = at + 1;
      continue;
    }
    if (c == '#')
      while (at + 1 < text.size() && text[at + 1] != '\n') ++at;
    if (c == '\n') ++line, line_start = at + 1;
    if (c == '\n' || c == ',' || c == '=' || c == '[' || c == ']' || c == '{' || c == '}') dots = 0;
    if (c == '.' && ++dots > most)
      throw InputError({file, line, static_cast<int>(at - line_start) + 1},
                       "a key of more than 8 dotted parts; the format has none");
    ++at;
  }
}

}  // namespace

toml::table parse_toml(std::string_view text, const std::string& file) {
  refuse_deep_keys(text, file);
  try {
    return toml::parse(text);
  } catch (const toml::parse_error& error) {
    const toml::source_position at = error.source().begin;
    throw InputError({file, static_cast<int>(at.line), static_cast<int>(at.column)},
                     fmt::format("this is not TOML: {}", error.description()));
  }
}

TomlTable::TomlTable(const toml::table& table, const std::string& file, std::string who,
                     std::span<const std::string_view> known)
    : table_(table), file_(file), who_(std::move(who)) {
  for (const auto& [key, value] : table_)
    if (std::find(known.begin(), known.end(), key.str()) == known.end()) unknown_key(key, known);
}

void TomlTable::unknown_key(const toml::key& key, std::span<const std::string_view> known) const {
  const toml::source_position at = key.source().begin;
  std::string mend = did_you_mean(key.str(), known);
  if (mend.empty() && known.size() <= 20) mend = fmt::format("; the keys here are {}", fmt::join(known, ", "));
  throw InputError({file_, static_cast<int>(at.line), static_cast<int>(at.column)},
                   fmt::format("{}: unknown key {}{}", who_, in_quotes(key.str()), mend));
}

Place TomlTable::place(const toml::node& node) const {
  const toml::source_position at = node.source().begin;
  return {file_, static_cast<int>(at.line), static_cast<int>(at.column)};
}

void TomlTable::fail(const toml::node& node, const std::string& what) const {
  throw InputError(place(node), who_ + ": " + what);
}

void TomlTable::wrong_type(const toml::node& node, std::string_view what, std::string_view expected) const {
  fail(node, fmt::format("{} must be {}, not {}", what, expected, type_name(node)));
}

double TomlTable::number(const toml::node& node, std::string_view what) const {
  double value = 0;
  if (const auto* real = node.as_floating_point())
    value = real->get();
  else if (const auto* integer = node.as_integer())
    value = static_cast<double>(integer->get());
  else
    wrong_type(node, what, "a number");
  if (!std::isfinite(value))
    fail(node, fmt::format("{} is not a finite number; write a plain decimal value in SI units", what));
  return value;
}

std::vector<double> TomlTable::numbers(const toml::node& node, std::string_view what) const {
  const toml::array* array = node.as_array();
  if (!array) wrong_type(node, what, "an array of numbers");
  std::vector<double> values;
  values.reserve(array->size());
  for (const toml::node& entry : *array) values.push_back(number(entry, what));
  return values;
}

const toml::table& TomlTable::table(const toml::node& node, std::string_view what) const {
  const toml::table* inner = node.as_table();
  if (!inner) wrong_type(node, what, "a table");
  return *inner;
}

std::string TomlTable::text(std::string_view key, const std::string& preset) const {
  const toml::node* node = find(key);
  if (!node) return preset;
  const auto* string = node->as_string();
  if (!string) wrong_type(*node, key, "a string");
  return string->get();
}

std::string TomlTable::name(std::string_view key) const {
  const toml::node* node = find(key);
  if (!node) fail(fmt::format("{0} is missing; add {0} = \"...\"", key));
  std::string value = text(key);
  check_name(value, place(*node), fmt::format("{}: {}", who_, key));
  return value;
}

double TomlTable::number(std::string_view key, double preset) const {
  const toml::node* node = find(key);
  return node ? number(*node, key) : preset;
}

bool TomlTable::flag(std::string_view key) const {
  const toml::node* node = find(key);
  if (!node) return false;
  const auto* boolean = node->as_boolean();
  if (!boolean) wrong_type(*node, key, "true or false");
  return boolean->get();
}

Eigen::Vector3d TomlTable::vector(std::string_view key) const {
  const toml::node* node = find(key);
  if (!node) return Eigen::Vector3d::Zero();
  const std::vector<double> values = numbers(*node, key);
  if (values.size() != 3) fail(*node, fmt::format("{} needs 3 numbers [x, y, z], not {}", key, values.size()));
  return {values[0], values[1], values[2]};
}

std::vector<double> TomlTable::numbers(std::string_view key) const {
  const toml::node* node = find(key);
  return node ? numbers(*node, key) : std::vector<double>();
}

const toml::table& TomlTable::table(std::string_view key) const {
  static const toml::table none;
  const toml::node* node = find(key);
  return node ? table(*node, key) : none;
}

std::vector<const toml::table*> TomlTable::tables(std::string_view key) const {
  std::vector<const toml::table*> result;
  const toml::node* node = find(key);
  if (!node) return result;
  const toml::array* array = node->as_array();
  if (!array) wrong_type(*node, key, fmt::format("a list of tables, each headed [[{}]]", key));
  for (const toml::node& entry : *array) result.push_back(&table(entry, fmt::format("an entry of {}", key)));
  return result;
}

}  // namespace lanc
