// Typed reading of TOML tables with errors that name place, thing and mend. Private to the library (exposes toml++).
#pragma once

#include <toml++/toml.h>
#include <Eigen/Core>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "lib/model/error.h"

namespace lanc {

/// One table of a model file. Everything it returns is checked: types, counts, finite numbers.
class TomlTable {
 public:
  /// `who` names the table in messages ("joint 'elbow'"). Throws InputError for the first key that is not in `known`.
  TomlTable(const toml::table& table, const std::string& file, std::string who,
            std::span<const std::string_view> known);

  const std::string& who() const { return who_; }
  const std::string& file() const { return file_; }
  Place place() const { return place(table_); }
  Place place(const toml::node& node) const;

  /// Null when the key is absent.
  const toml::node* find(std::string_view key) const { return table_.get(key); }
  std::string text(std::string_view key, const std::string& preset = {}) const;
  /// A name (lib/io/text.h, check_name); must be there.
  std::string name(std::string_view key) const;
  double number(std::string_view key, double preset = 0) const;
  bool flag(std::string_view key) const;
  Eigen::Vector3d vector(std::string_view key) const;  // zero when absent
  std::vector<double> numbers(std::string_view key) const;
  const toml::table& table(std::string_view key) const;  // an empty one when absent
  /// The tables of [[key]]; none when absent.
  std::vector<const toml::table*> tables(std::string_view key) const;

  // The same for a value that is at hand; `what` names it.
  double number(const toml::node& node, std::string_view what) const;
  std::vector<double> numbers(const toml::node& node, std::string_view what) const;
  const toml::table& table(const toml::node& node, std::string_view what) const;
  [[noreturn]] void unknown_key(const toml::key& key, std::span<const std::string_view> known) const;
  [[noreturn]] void fail(const toml::node& node, const std::string& what) const;
  [[noreturn]] void fail(const std::string& what) const { fail(table_, what); }

 private:
  [[noreturn]] void wrong_type(const toml::node& node, std::string_view what, std::string_view expected) const;

  const toml::table& table_;
  const std::string& file_;
  std::string who_;
};

/// The document, or InputError with line and column. Inputs made to exhaust the stack are refused.
toml::table parse_toml(std::string_view text, const std::string& file);

}  // namespace lanc
