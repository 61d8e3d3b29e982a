// Bad input is an exception that names the place, the thing and the mend.
#pragma once

#include <stdexcept>
#include <string>

namespace lanc {

/// Where a piece of a model came from; empty file for models built in code.
struct Place {
  std::string file;
  int line = 0, column = 0;

  /// "file:line:column: ", as compilers print it, without what is not known, or nothing.
  std::string prefix() const {
    if (file.empty()) return {};
    if (line == 0) return file + ": ";
    if (column == 0) return file + ":" + std::to_string(line) + ": ";
    return file + ":" + std::to_string(line) + ":" + std::to_string(column) + ": ";
  }
};

/// Thrown for every model, state, load or argument that cannot be used.
class InputError : public std::runtime_error {
 public:
  InputError(const Place& place, const std::string& what) : std::runtime_error(place.prefix() + what) {}
  explicit InputError(const std::string& what) : InputError(Place{}, what) {}
};

}  // namespace lanc
