// CSV by RFC 4180: quoting, numbers that survive the round trip, and reading back what may have been cut off.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

namespace lanc {

/// The field, in quotes (quotes doubled) where RFC 4180 asks for them: comma, quote, CR or LF inside.
std::string csv_field(std::string_view text);

/// The shortest decimal that reads back as the same double; empty when not finite (a row without a result).
std::string csv_number(double value);

/// One record read, and where it ends in the text (behind its line break).
struct CsvRecord {
  std::vector<std::string> fields;
  std::size_t end = 0;
};

/// All complete records: a last one without its line break, or with an open quote, is left out. Accepts LF and CRLF.
std::vector<CsvRecord> read_csv(std::string_view text);

}  // namespace lanc
