// Axes and angular velocities of bodies, one by one and side by side.
#pragma once

#include <array>

#include "lib/spatial/block.h"

namespace lanc {

/// Axes of a body's joint frame and its angular velocity, in world axes. Each has the room of four numbers, so that one
/// load can take it (wide.h).
template <class S>
struct alignas(64) BodyFrame {
  using Place = std::array<S, 4>;
  Place x{}, y{}, z{}, omega{};
};

template <class S>
[[gnu::always_inline]] inline Vec3<S> vector_at(const typename BodyFrame<S>::Place& place) {
  return {place[0], place[1], place[2]};
}

}  // namespace lanc
