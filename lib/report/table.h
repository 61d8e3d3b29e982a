// Tables for people: aligned columns of text.
#pragma once

#include <string>
#include <vector>

namespace lanc {

/// Columns as wide as their widest cell, two spaces apart, indented by two; the first `left` columns are aligned left,
/// the others right. UTF-8, one column per code point.
class TextTable {
 public:
  explicit TextTable(std::vector<std::string> header, int left = 1);
  void row(std::vector<std::string> cells);
  bool empty() const { return rows_.size() == 1; }
  /// The table with its line breaks; of more than `most` rows only the first, and a line that says how many there are.
  std::string text(std::size_t most = 200) const;

 private:
  std::size_t left_;
  std::vector<std::vector<std::string>> rows_;  // the first is the header
};

/// Six significant digits; a dash for what is not finite.
std::string table_number(double value);

}  // namespace lanc
