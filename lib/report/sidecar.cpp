#include "lib/report/sidecar.h"

#include <fmt/chrono.h>
#include <fmt/format.h>
#include <gnu/libc-version.h>
#include <link.h>

#include <SuiteSparse_config.h>
#include <CLI/Version.hpp>
#include <Eigen/Core>
#include <ctime>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <thread>

namespace lanc {

namespace {

/// The BLAS that is loaded decides how fast library factorisations are; its file name tells which one it is.
std::string loaded_blas() {
  std::string found;
  dl_iterate_phdr(
      [](dl_phdr_info* info, std::size_t, void* result) {
        std::error_code error;
        const auto real = std::filesystem::canonical(info->dlpi_name, error).filename().string();
        if (error || real.find("blas") == std::string::npos) return 0;
        *static_cast<std::string*>(result) = real;
        return 1;
      },
      &found);
  return found;
}

nlohmann::ordered_json libraries() {
  nlohmann::ordered_json list;
  list["Eigen"] = fmt::format("{}.{}.{}", EIGEN_WORLD_VERSION, EIGEN_MAJOR_VERSION, EIGEN_MINOR_VERSION);
  list["SuiteSparse"] =
      fmt::format("{}.{}.{}", SUITESPARSE_MAIN_VERSION, SUITESPARSE_SUB_VERSION, SUITESPARSE_SUBSUB_VERSION);
  if (const std::string blas = loaded_blas(); !blas.empty()) list["BLAS"] = blas;
  list["CLI11"] = CLI11_VERSION;
  list["fmt"] = fmt::format("{}.{}.{}", FMT_VERSION / 10000, FMT_VERSION / 100 % 100, FMT_VERSION % 100);
  list["nlohmann-json"] =
      fmt::format("{}.{}.{}", NLOHMANN_JSON_VERSION_MAJOR, NLOHMANN_JSON_VERSION_MINOR, NLOHMANN_JSON_VERSION_PATCH);
#ifdef _GLIBCXX_RELEASE
  list["libstdc++"] = std::to_string(_GLIBCXX_RELEASE);
#endif
  list["glibc"] = gnu_get_libc_version();
  return list;
}

nlohmann::json text_or_null(std::string_view text) {
  return text.empty() ? nlohmann::json() : nlohmann::json(std::string(text));
}

}  // namespace

std::string processor() {
  std::ifstream in("/proc/cpuinfo");
  for (std::string line; std::getline(in, line);)
    if (line.rfind("model name", 0) == 0 && line.find(": ") != std::string::npos)
      return line.substr(line.find(": ") + 2);
  return "unknown";
}

std::optional<std::string> build_warning(const BuildInfo& info) {
  if (info.optimised && !info.sanitized) return std::nullopt;
  return fmt::format(
      "WARNING: this is {} build ({}): its times mean nothing. Configure with -DCMAKE_BUILD_TYPE=Release.",
      info.sanitized ? "a sanitizer" : "an unoptimised", info.build_type);
}

std::string sidecar(std::string_view experiment, std::span<const std::string> command_line,
                    std::span<const std::pair<std::string, std::string>> options, std::optional<std::uint64_t> seed,
                    std::span<const std::pair<std::string, std::string>> more_libraries) {
  const BuildInfo build = build_info();
  nlohmann::ordered_json json;
  json["experiment"] = std::string(experiment);
  json["version"] = std::string(build.version);
  json["commit"] = text_or_null(build.commit);
  json["dirty"] = build.dirty;
  json["compiler"] = std::string(build.compiler);
  json["flags"] = std::string(build.flags);
  json["build_type"] = std::string(build.build_type);
  json["optimised"] = build.optimised;
  json["sanitized"] = build.sanitized;
  json["cpu"] = processor();
  json["threads"] = std::thread::hardware_concurrency();
  json["libraries"] = libraries();
  for (const auto& [name, version] : more_libraries) json["libraries"][name] = version;
  json["command_line"] = std::vector<std::string>(command_line.begin(), command_line.end());
  json["options"] = nlohmann::ordered_json::object();
  for (const auto& [name, value] : options) json["options"][name] = value;
  json["seed"] = seed ? nlohmann::json(*seed) : nlohmann::json();
  json["date"] = fmt::format("{:%Y-%m-%dT%H:%M:%SZ}", fmt::gmtime(std::time(nullptr)));
  json["finished"] = false;
  return json.dump(2);
}

}  // namespace lanc
