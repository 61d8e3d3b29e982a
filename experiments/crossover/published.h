// Operation counts from the literature, to draw beside ours: serial chain of n revolute joints, forward dynamics.
#pragma once

#include <span>
#include <string_view>

namespace lanc {

/// Multiplications plus additions as published; trigonometric functions and most often divisions are not in them, and
/// they give η̇ only, where this project also asks for every â and f̂.
struct PublishedCount {
  std::string_view name, source;
  bool recursive;
  double (*operations)(double n);
};

std::span<const PublishedCount> published_counts();

}  // namespace lanc
