// A block of bodies, from one after the other to side by side and back.
// Private to lib: what uses it differs between objects compiled for different processors.
#pragma once

#include "lib/system/body_frame.h"
#include "lib/system/system.h"

namespace lanc {

/// Axes and angular velocities of as many bodies as a block has lanes.
template <class S>
[[gnu::always_inline]] inline void frames_into_lanes(const BodyFrame<S>* frames, Mat3<Packed<S>>& R,
                                                     Vec3<Packed<S>>& omega) {
#pragma GCC unroll 8
  for (int k = 0; k < PackedScalar<S>::lanes; ++k) {
    const BodyFrame<S>& f = frames[k];
    set_lane<S>(R, k, {vector_at<S>(f.x), vector_at<S>(f.y), vector_at<S>(f.z)});
    set_lane<S>(omega, k, vector_at<S>(f.omega));
  }
}

/// Inertias of bodies first to last − 1, and forces on them.
template <class S>
[[gnu::always_inline]] inline void bodies_from_lanes(const Vec3<Packed<S>>& h, const Sym3<Packed<S>>& J,
                                                     const Wrench<Packed<S>>& force, int first, int last,
                                                     System<S>& system) {
  const auto one = [&](int i, int lane) __attribute__((always_inline)) {
    system.bodies[i].inertia.h = lane_of<S>(h, lane);
    system.bodies[i].inertia.J = lane_of<S>(J, lane);
    system.rhs.force[i].moment = lane_of<S>(force.moment, lane);
    system.rhs.force[i].force = lane_of<S>(force.force, lane);
  };
  if constexpr (PackedScalar<S>::lanes == 1)
    one(first, 0);  // no loop: packs stay in registers
  else
    for (int i = first; i < last; ++i) one(i, i - first);
}

#if defined(__AVX512F__)

// With 512 bits by transposition: eight numbers a load or store instead of one.

template <>
[[gnu::always_inline]] inline void frames_into_lanes(const BodyFrame<double>* frames, Mat3<Pack<double, 8>>& R,
                                                     Vec3<Pack<double, 8>>& omega) {
  std::array<Pack<double, 8>, 8> xy, zw;
  const auto both = [](const std::array<double, 4>& a, const std::array<double, 4>& b) {
    return shuffled<0, 1, 2, 3, 4, 5, 6, 7>(Pack<double, 4>::load(a.data()), Pack<double, 4>::load(b.data()));
  };
  for (int k = 0; k < 8; ++k) {
    xy[k] = both(frames[k].x, frames[k].y);
    zw[k] = both(frames[k].z, frames[k].omega);
  }
  transpose(xy), transpose(zw);
  R = {{xy[0], xy[1], xy[2]}, {xy[4], xy[5], xy[6]}, {zw[0], zw[1], zw[2]}};
  omega = {zw[4], zw[5], zw[6]};
}

template <>
[[gnu::always_inline]] inline void bodies_from_lanes(const Vec3<Pack<double, 8>>& h, const Sym3<Pack<double, 8>>& J,
                                                     const Wrench<Pack<double, 8>>& force, int first, int last,
                                                     System<double>& system) {
  const Vec3<Pack<double, 8>>&m = force.moment, &f = force.force;
  std::array<Pack<double, 8>, 8> inertias{h.x, h.y, h.z, J.xx, J.yy, J.zz, J.xy, J.xz};
  std::array<Pack<double, 8>, 8> forces{m.x, m.y, m.z, f.x, f.y, f.z, J.yz, J.yz};
  transpose(inertias), transpose(forces);
  for (int i = first; i < last; ++i) {
    const Pack<double, 8>&a = inertias[i - first], &b = forces[i - first];
    RigidInertia<double>& M = system.bodies[i].inertia;
    static_assert(sizeof M == 10 * sizeof(double));  // m, h and J are ten numbers in a row,
    static_assert(sizeof system.rhs.force[i] == 6 * sizeof(double));
    a.store(&M.h.x), M.J.yz = b[6];
    double* const f = &system.rhs.force[i].moment.x;
    shuffled<0, 1, 2, 3>(b, b).store(f), shuffled<4, 5>(b, b).store(f + 4);
  }
}

#endif

}  // namespace lanc
