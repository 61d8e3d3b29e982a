// Programs as a shell sees them: arguments in; standard output, standard error and exit code out.
#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace lanc::test {

using Words = std::vector<std::string>;

struct Finished {
  int exit_code = -1;
  std::string out, error;
  nlohmann::json json() const { return nlohmann::json::parse(out); }
};

/// A folder of this process's own, removed at the end.
const std::filesystem::path& folder();

std::string text_of(const std::filesystem::path& path);

/// Writes a file into folder() and returns its path.
std::string write(const std::string& name, const std::string& text);

/// Runs the program that lies beside this test.
Finished run(const std::string& program, const Words& arguments);

}  // namespace lanc::test
