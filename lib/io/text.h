// Reading model files, and words for messages about them.
#pragma once

#include <span>
#include <string>
#include <string_view>

#include "lib/model/error.h"

namespace lanc {

/// Whole contents of a model file. Throws InputError when it cannot be read, is a directory, is empty, or exceeds 64
/// MiB (some 200 000 bodies; larger models come from generators). Never reads further than that, so a device is safe to
/// name.
std::string read_model_file(const std::string& path);

/// Throws InputError unless `text` may be the name of a body, joint or spring: not empty, valid UTF-8 without control
/// characters, at most 255 bytes. `what` says whose name it is.
void check_name(const std::string& text, const Place& place, const std::string& what);

/// The candidate a mistyped word is close to (edit distance with transpositions: one in words of three to five
/// letters, two in longer ones), or nothing.
std::string_view nearest(std::string_view word, std::span<const std::string_view> candidates);

/// "; did you mean 'x'?", or nothing when no candidate is near.
std::string did_you_mean(std::string_view word, std::span<const std::string_view> candidates);

/// 'text' for a message, cut when it is long, with control characters shown as '?'.
std::string in_quotes(std::string_view text);

}  // namespace lanc
