// Axes and angular velocities of bodies, one by one and side by side.
#pragma once

#include <array>
#include <type_traits>

#include "lib/spatial/block.h"

namespace lanc {

/// Axes of a body's joint frame and its angular velocity, in world axes. Each has the room of four doubles, so that one
/// load can take it (wide.h); of other scalars, three.
template <class S>
struct alignas(64) BodyFrame {
  using Place = std::array<S, std::is_same_v<S, double> ? 4 : 3>;
  Place x{}, y{}, z{}, omega{};
};

template <class S>
[[gnu::always_inline]] inline Vec3<S> vector_at(const typename BodyFrame<S>::Place& place) {
  return {place[0], place[1], place[2]};
}
template <class S>
[[gnu::always_inline]] inline Mat3<S> axes_of(const BodyFrame<S>& frame) {
  return {vector_at<S>(frame.x), vector_at<S>(frame.y), vector_at<S>(frame.z)};
}

}  // namespace lanc
