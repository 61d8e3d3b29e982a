// The shape of the source tree: which folder may include which, and what every folder of a kind must contain.
//
//   scalar → spatial → model → system → closure → formulation → {formulations/*, derivatives → integrate} →
//   {experiments, tests}
//
// An arrow means "may be included by everything to its right". io, solve and report are leaves: io knows model and,
// since its generators close loops, system and closure; solve knows nothing of ours but scalars; report knows io,
// system, closure and formulation, and no part of the chain knows io or report. What comes after model may use solve.
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <map>
#include <regex>
#include <set>

#include "lib/formulation/formulation.h"

namespace lanc::test {
namespace {

namespace fs = std::filesystem;
const fs::path root = LANC_SOURCE_DIR;

struct Source {
  std::string path;    // relative to the root
  std::string folder;  // "lib/model", "formulations/dense", "experiments/solve", "tests"
  std::vector<std::string> lines;
};

std::string folder_of(const fs::path& relative) {
  auto part = relative.begin();
  const std::string top = (part++)->string();
  if (top == "tests" || std::next(part) == relative.end()) return top;
  return top + "/" + part->string();
}

const std::vector<Source>& sources() {
  static const std::vector<Source> all = [] {
    std::vector<Source> list;
    for (const char* top : {"lib", "formulations", "experiments", "tests"})
      for (const auto& entry : fs::recursive_directory_iterator(root / top)) {
        const std::string extension = entry.path().extension().string();
        if (extension != ".h" && extension != ".cpp" && extension != ".py") continue;
        const fs::path relative = entry.path().lexically_relative(root);
        Source source{relative.generic_string(), folder_of(relative), {}};
        std::ifstream file(entry.path());
        for (std::string line; std::getline(file, line);) source.lines.push_back(line);
        list.push_back(std::move(source));
      }
    return list;
  }();
  return all;
}

/// What a folder may include besides itself.
const std::map<std::string, std::set<std::string>> allowed = {
    {"lib/scalar", {}},
    {"lib/spatial", {"lib/scalar"}},
    {"lib/model", {"lib/scalar", "lib/spatial"}},
    {"lib/system", {"lib/scalar", "lib/spatial", "lib/model", "lib/solve"}},
    {"lib/closure", {"lib/scalar", "lib/spatial", "lib/model", "lib/system", "lib/solve"}},
    {"lib/solve", {"lib/scalar"}},
    {"lib/formulation", {"lib/scalar", "lib/spatial", "lib/model", "lib/system", "lib/closure", "lib/solve"}},
    {"lib/derivatives",
     {"lib/scalar", "lib/spatial", "lib/model", "lib/system", "lib/closure", "lib/solve", "lib/formulation"}},
    {"lib/integrate",
     {"lib/scalar", "lib/spatial", "lib/model", "lib/system", "lib/closure", "lib/solve", "lib/formulation",
      "lib/derivatives"}},
    {"lib/io", {"lib/scalar", "lib/spatial", "lib/model", "lib/system", "lib/closure"}},
    {"lib/report",
     {"lib/scalar", "lib/spatial", "lib/model", "lib/system", "lib/closure", "lib/formulation", "lib/derivatives",
      "lib/integrate", "lib/io"}},
};

bool may_include(const Source& source, const std::string& included) {
  const std::string target = folder_of(included);
  if (target == source.folder || source.folder == "tests") return true;
  if (source.path == "lib/lanc.h") return target.rfind("lib/", 0) == 0;  // the one header for users
  if (source.folder.rfind("formulations/", 0) == 0) {
    const auto& formulation = allowed.at("lib/formulation");
    return target == "lib/formulation" || formulation.count(target) > 0;
  }
  if (source.folder.rfind("experiments/", 0) == 0) return target.rfind("lib/", 0) == 0;
  const auto rule = allowed.find(source.folder);
  return rule != allowed.end() && rule->second.count(target) > 0;
}

TEST(Architecture, includes_follow_the_arrows) {
  const std::regex include("^\\s*#\\s*include\\s*\"((lib|formulations|experiments|tests)/[^\"]+)\"");
  int seen = 0;
  for (const Source& source : sources())
    for (const std::string& line : source.lines) {
      std::smatch match;
      if (!std::regex_search(line, match, include)) continue;
      ++seen;
      EXPECT_TRUE(may_include(source, match[1])) << source.path << " may not include " << match[1];
    }
  EXPECT_GT(seen, 100);
}

TEST(Architecture, every_folder_of_lib_has_a_rule) {
  for (const Source& source : sources())
    if (source.folder.rfind("lib/", 0) == 0) {
      EXPECT_TRUE(allowed.count(source.folder)) << source.path;
    }
}

TEST(Architecture, suitesparse_shows_in_lib_solve_alone) {
  const std::regex header(
      "#\\s*include\\s*[<\"](suitesparse/)?"
      "(cholmod|klu|umfpack|amd|colamd|camd|ccolamd|btf|ldl|SuiteSparse|spqr)[^>\"]*\\.(h|hpp)");
  for (const Source& source : sources()) {
    if (source.folder == "lib/solve") continue;
    if (source.path == "lib/report/sidecar.cpp") continue;  // versions of the libraries, for the record
    for (const std::string& line : source.lines)
      EXPECT_FALSE(std::regex_search(line, header)) << source.path << ": " << line;
  }
}

TEST(Architecture, experiments_name_no_formulation) {
  for (const Source& source : sources()) {
    if (source.folder.rfind("experiments/", 0) != 0 || fs::path(source.path).filename() != "main.cpp") continue;
    for (const std::string& line : source.lines)
      for (const FormulationInfo& info : formulations())
        EXPECT_EQ(line.find("\"" + std::string(info.name) + "\""), std::string::npos)
            << source.path << " names the formulation " << info.name << "; take it from the register or the options";
  }
}

std::string read(const fs::path& path) {
  std::ifstream file(path);
  return {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
}

TEST(Architecture, every_formulation_has_a_readme_with_all_sections) {
  int seen = 0;
  for (const auto& entry : fs::directory_iterator(root / "formulations")) {
    if (!entry.is_directory()) continue;
    ++seen;
    const std::string text = read(entry.path() / "README.md");
    EXPECT_FALSE(text.empty()) << entry.path() << " has no README.md";
    for (const char* section :
         {"**Idea.**", "**Equations.**", "**Source.**", "**Cost.**", "**When to use.**", "**When not.**"})
      EXPECT_NE(text.find(section), std::string::npos) << entry.path() << "/README.md lacks " << section;
  }
  EXPECT_GE(seen, 3);
}

TEST(Architecture, every_formulation_is_registered_under_the_name_of_its_folder) {
  for (const FormulationInfo& info : formulations()) {
    EXPECT_TRUE(fs::is_directory(root / "formulations" / info.name)) << info.name;
    EXPECT_FALSE(info.idea.empty()) << info.name;
    EXPECT_FALSE(info.source.empty()) << info.name;
    EXPECT_TRUE(info.create_double != nullptr) << info.name;
    EXPECT_EQ(find_formulation(info.name), &info);
  }
}

TEST(Architecture, every_experiment_has_a_readme) {
  for (const auto& entry : fs::directory_iterator(root / "experiments"))
    if (fs::exists(entry.path() / "main.cpp")) EXPECT_TRUE(fs::exists(entry.path() / "README.md")) << entry.path();
}

TEST(Architecture, files_are_short_and_finished) {
  constexpr std::size_t longest = 400;
  const std::string unfinished = std::string("TO") + "DO";
  for (const Source& source : sources()) {
    EXPECT_LE(source.lines.size(), longest) << source.path << " is too long to be read at once; split it";
    for (const std::string& line : source.lines)
      EXPECT_EQ(line.find(unfinished), std::string::npos) << source.path << ": " << line;
  }
}

TEST(Architecture, public_headers_are_guarded) {
  for (const Source& source : sources())
    if (fs::path(source.path).extension() == ".h")
      EXPECT_NE(std::find(source.lines.begin(), source.lines.end(), "#pragma once"), source.lines.end()) << source.path;
}

}  // namespace
}  // namespace lanc::test
