#include "lib/system/energy.h"

namespace lanc {
namespace {

/// ½ m v² + ½ ωᵀ J ω + m v·(ω × c), about the reference point.
template <class S>
S kinetic_energy(const RigidInertia<S>& inertia, const Motion<S>& twist) {
  return dot(twist, inertia * twist) * S(0.5);
}

/// Springs and rotor inertias of all joint coordinates; `T` and `V` are added to.
template <class S>
void add_coordinates(const Model& model, const State<S>& state, S& T, S& V) {
  const S half(0.5);
  for (int k = 0; k < model.nv(); ++k)
    if (model.armature()[k] != 0) T += S(model.armature()[k]) * state.v[k] * state.v[k] * half;
  for (const PassiveCoordinate& passive : model.passive()) {
    const Link& link = model.link(passive.body);
    S q(0.0);
    if (link.drive >= 0) {
      const MotionSample sample = model.motion(link.drive).at(state.t);
      q = S(sample.position);
      const S v(sample.velocity);
      T += S(passive.spec.armature) * v * v * half;
    } else if (passive.spec.stiffness != 0) {
      q = state.q[link.q + passive.coordinate];
    }
    const S stretch = q - S(passive.spec.rest);
    if (passive.spec.stiffness != 0) V += S(passive.spec.stiffness) * stretch * stretch * half;
  }
}

}  // namespace

template <class S>
Energy<S> energy(Evaluator<S>& evaluator, const State<S>& state) {
  const System<S>& system = evaluator.system(state);
  const Model& model = system.model;
  const std::vector<Vec3<S>>& positions = evaluator.positions();
  const std::vector<Motion<S>>& twists = evaluator.twists();
  const Vec3<S> g = cast<S>(model.gravity());
  S T(0.0), V(0.0);
  for (int i = 0; i < model.bodies(); ++i) {
    const RigidInertia<S>& M = system.bodies[i].inertia;
    T += kinetic_energy(M, twists[i]);
    V -= dot(positions[i] * M.mass + M.h, g);
  }
  add_coordinates(model, state, T, V);
  for (const PointSpring& spring : model.springs()) {
    const auto end = [&](int body, const Vec3<double>& point) {
      return body == ground ? cast<S>(point) : positions[body] + evaluator.rotation(body) * cast<S>(point);
    };
    const Vec3<S> d = end(spring.body_b, spring.point_b) - end(spring.body_a, spring.point_a);
    const S stretch = sqrt(dot(d, d)) - S(spring.rest_length);
    V += S(spring.stiffness) * stretch * stretch * S(0.5);
  }
  return {T, V};
}

template Energy<double> energy(Evaluator<double>&, const State<double>&);
template Energy<long double> energy(Evaluator<long double>&, const State<long double>&);
template Energy<Count> energy(Evaluator<Count>&, const State<Count>&);

}  // namespace lanc
