#include "lib/io/text.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <vector>

namespace lanc {
namespace {

bool is_control(char c) { return static_cast<unsigned char>(c) < 0x20 || c == 0x7f; }

/// Optimal string alignment distance. O(product of the lengths).
int edit_distance(std::string_view a, std::string_view b) {
  std::vector<int> before(b.size() + 1), last(b.size() + 1), now(b.size() + 1);
  for (std::size_t j = 0; j <= b.size(); ++j) last[j] = static_cast<int>(j);
  for (std::size_t i = 1; i <= a.size(); ++i) {
    now[0] = static_cast<int>(i);
    for (std::size_t j = 1; j <= b.size(); ++j) {
      now[j] = std::min({last[j] + 1, now[j - 1] + 1, last[j - 1] + (a[i - 1] != b[j - 1])});
      if (i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1]) now[j] = std::min(now[j], before[j - 2] + 1);
    }
    std::swap(before, last);
    std::swap(last, now);
  }
  return last[b.size()];
}

}  // namespace

std::string read_model_file(const std::string& path) {
  constexpr std::size_t largest = std::size_t{64} << 20;
  const Place place{path};
  std::error_code ignored;
  if (std::filesystem::is_directory(path, ignored))
    throw InputError(place, "this is a directory; name a model file in it");
  std::ifstream file(path, std::ios::binary);
  if (!file) throw InputError(place, fmt::format("cannot be opened ({}); mend the path", std::strerror(errno)));
  std::string text;
  std::array<char, 1 << 16> block;
  while (file.read(block.data(), block.size()), file.gcount() > 0) {
    text.append(block.data(), static_cast<std::size_t>(file.gcount()));
    if (text.size() > largest)
      throw InputError(place, "the file is larger than 64 MiB; use a generator for a model of this size");
  }
  if (file.bad()) throw InputError(place, "reading failed; is the medium in order?");
  if (text.empty()) throw InputError(place, "the file is empty; write a model into it");
  return text;
}

void check_name(const std::string& text, const Place& place, const std::string& what) {
  constexpr std::size_t longest = 255;
  if (text.empty()) throw InputError(place, what + " is empty; give a name");
  if (text.size() > longest)
    throw InputError(place, fmt::format("{} is longer than {} bytes: {}; shorten it", what, longest, in_quotes(text)));
  if (std::any_of(text.begin(), text.end(), is_control))
    throw InputError(place, fmt::format("{} contains a control character: {}; remove it", what, in_quotes(text)));
  try {
    (void)nlohmann::json(text).dump();  // every name must be fit for the JSON output
  } catch (const nlohmann::json::exception&) {
    throw InputError(place, what + " is not valid UTF-8; save the file in UTF-8");
  }
}

std::string_view nearest(std::string_view word, std::span<const std::string_view> candidates) {
  constexpr std::size_t longest = 64;
  std::string_view best;
  int best_distance = word.size() <= 2 ? 1 : word.size() <= 5 ? 2 : 3;  // must be smaller
  if (word.size() > longest) return best;
  for (const std::string_view candidate : candidates) {
    if (candidate.size() > longest) continue;
    const int distance = edit_distance(word, candidate);
    if (distance < best_distance) best_distance = distance, best = candidate;
  }
  return best;
}

std::string did_you_mean(std::string_view word, std::span<const std::string_view> candidates) {
  const std::string_view near = nearest(word, candidates);
  return near.empty() ? std::string() : fmt::format("; did you mean '{}'?", near);
}

std::string in_quotes(std::string_view text) {
  constexpr std::size_t longest = 60;
  std::string shown(text.substr(0, longest));
  std::replace_if(shown.begin(), shown.end(), is_control, '?');
  return "'" + shown + (text.size() > longest ? "…'" : "'");
}

}  // namespace lanc
