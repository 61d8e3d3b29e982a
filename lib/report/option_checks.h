// What all programs ask of the values of their options; private to lib/report.
#pragma once

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <charconv>
#include <cstdint>
#include <string>

namespace lanc {

/// Not the empty text, which a shell makes of an unset variable.
inline CLI::Validator given() {
  return {[](const std::string& text) {
            return std::string(text.empty() ? "nothing is given; give a value, or leave it out" : "");
          },
          ""};
}

/// A whole number from 0 to 2⁶⁴ − 1.
inline CLI::Validator seed() {
  return {[](const std::string& text) {
            std::uint64_t value = 0;
            const auto [last, error] = std::from_chars(text.data(), text.data() + text.size(), value);
            return error == std::errc() && last == text.data() + text.size()
                       ? std::string()
                       : fmt::format("'{}' is no seed; give a whole number from 0 to 2^64 - 1", text);
          },
          ""};
}

/// A number between the two, both allowed; not a number is none.
inline CLI::Validator between(double lowest, double highest) {
  return {[=](const std::string& text) {
            double value = 0;
            return CLI::detail::lexical_cast(text, value) && value >= lowest && value <= highest
                       ? std::string()
                       : fmt::format("'{}' is not a number from {} to {}", text, lowest, highest);
          },
          ""};
}

}  // namespace lanc
