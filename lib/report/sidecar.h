// How a number came about: version, commit, compiler, processor, libraries, command line.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace lanc {

/// Facts of this build of the library.
struct BuildInfo {
  std::string_view version, commit;  // commit: empty when it was not built from a git clone
  bool dirty = false;                // with changes that are not in the commit
  std::string_view compiler, flags, build_type;
  bool optimised = false, sanitized = false;
};
BuildInfo build_info();

/// The processor as the system names it.
std::string processor();

/// What to say, loudly, of a build whose times mean nothing; nothing for an optimised one.
std::optional<std::string> build_warning(const BuildInfo& info);

/// JSON object with the keys
///   experiment version commit dirty compiler flags build_type optimised sanitized cpu threads libraries command_line
///   options seed date finished
/// `options`: those that decide which rows there are and what they mean; --resume compares them. `more_libraries`: name
/// and version, beside those of the project.
std::string sidecar(std::string_view experiment, std::span<const std::string> command_line,
                    std::span<const std::pair<std::string, std::string>> options, std::optional<std::uint64_t> seed,
                    std::span<const std::pair<std::string, std::string>> more_libraries = {});

}  // namespace lanc
