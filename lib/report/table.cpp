#include "lib/report/table.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace lanc {
namespace {

std::size_t width(const std::string& text) {
  return static_cast<std::size_t>(
      std::count_if(text.begin(), text.end(), [](char c) { return (static_cast<unsigned char>(c) & 0xc0) != 0x80; }));
}

}  // namespace

TextTable::TextTable(std::vector<std::string> header, int left) : left_(static_cast<std::size_t>(left)) {
  rows_.push_back(std::move(header));
}

void TextTable::row(std::vector<std::string> cells) { rows_.push_back(std::move(cells)); }

std::string TextTable::text(std::size_t most) const {
  const std::size_t shown = std::min(rows_.size(), most + 1);
  std::vector<std::size_t> widths(rows_.front().size(), 0);
  for (std::size_t r = 0; r < shown; ++r)
    for (std::size_t c = 0; c < widths.size(); ++c) widths[c] = std::max(widths[c], width(rows_[r][c]));
  std::string text;
  for (std::size_t r = 0; r < shown; ++r) {
    std::string line;
    for (std::size_t c = 0; c < widths.size(); ++c) {
      const std::string fill(widths[c] - width(rows_[r][c]), ' ');
      line += "  " + (c < left_ ? rows_[r][c] + fill : fill + rows_[r][c]);
    }
    text += line.substr(0, line.find_last_not_of(' ') + 1) + "\n";
  }
  if (shown < rows_.size()) text += fmt::format("  ... {} more; --format json has all\n", rows_.size() - shown);
  return text;
}

std::string table_number(double value) { return std::isfinite(value) ? fmt::format("{:.6g}", value) : "-"; }

}  // namespace lanc
