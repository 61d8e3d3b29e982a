#include "formulations/recursive/recursive.h"

namespace lanc {

template <class S>
Recursive<S>::Recursive(const Model& model)
    : Formulation<S>(model), star_(model.bodies()), load_(model.bodies()), freedoms_(model.nv()) {}

/// Step 2, inertia: leaf to root, eq. 18. On entry star_[i] holds what the children of i handed down (if there are
/// any).
template <class S>
Outcome Recursive<S>::factorise(const System<S>& system) {
  const Model& model = this->model();
  for (int i = model.bodies() - 1; i >= 0; --i) {
    const Link& link = model.link(i);
    const auto& body = system.bodies[i];
    ArticulatedInertia<S>& M = star_[i];
    if (link.leaf)
      M = expanded(body.inertia);
    else
      add(M, body.inertia);

    ArticulatedInertia<S> rest = M;  // (1 − M* C N⁻¹ Cᵀ) M*, one column after the other
    for (int k = link.v; k < link.v + link.nv; ++k) {
      const ColumnKind kind = model.column_kind(k);
      const Wrench<S> U = times_column(rest, kind, system.columns[k]);
      S N = project(kind, system.columns[k], U);
      if (model.has_armature()) N += S(model.armature()[k]);
      freedoms_[k].inverse = S(1.0) / N;
      freedoms_[k].D = U * freedoms_[k].inverse;
      subtract_outer(rest, freedoms_[k].D, U);
    }
    if (link.parent == ground) continue;
    if (link.last_sibling)
      star_[link.parent] = moved_inward(body.r, rest);
    else
      add(star_[link.parent], moved_inward(body.r, rest));
  }
  return {};
}

template <class S>
void Recursive<S>::substitute(const System<S>& system, const RightHandSide<S>& rhs, Solution<S>& solution) {
  const Model& model = this->model();
  // Step 2, load: leaf to root.
  for (int i = model.bodies() - 1; i >= 0; --i) {
    const Link& link = model.link(i);
    Wrench<S>& f = load_[i];
    f = link.leaf ? rhs.force[i] : f + rhs.force[i];
    f -= star_[i] * rhs.bias[i];
    if (link.parent == ground && link.nv == 0) continue;
    Wrench<S> rest = f;
    for (int k = link.v; k < link.v + link.nv; ++k) {
      const S torque = rhs.tau[k] + project(model.column_kind(k), system.columns[k], rest);
      freedoms_[k].start = torque * freedoms_[k].inverse;
      rest -= freedoms_[k].D * torque;
    }
    if (link.parent == ground) continue;
    if (link.last_sibling)
      load_[link.parent] = moved_inward(system.bodies[i].r, rest);
    else
      load_[link.parent] += moved_inward(system.bodies[i].r, rest);
  }
  // Steps 3 and 4: root to leaf. A joint's columns are taken in reverse, the last released one first.
  for (int i = 0; i < model.bodies(); ++i) {
    const Link& link = model.link(i);
    Motion<S> a{};  // B_ip â_p + C η̇ of the columns done
    const bool at_rest = link.parent == ground;
    if (!at_rest) a = moved_outward(system.bodies[i].r, solution.acceleration[link.parent]);
    for (int k = link.v + link.nv - 1; k >= link.v; --k) {
      S vdot = freedoms_[k].start;
      if (!at_rest || k != link.v + link.nv - 1) vdot -= dot(a, freedoms_[k].D);
      solution.vdot[k] = vdot;
      add_along(model.column_kind(k), system.columns[k], vdot, a);
    }
    solution.wrench[i] = star_[i] * a - load_[i];
    solution.acceleration[i] = a + rhs.bias[i];
  }
}

template class Recursive<double>;
template class Recursive<long double>;
template class Recursive<Count>;

namespace {
const Registration registration(
    {.name = "recursive",
     .idea = "eq. 18: eliminate body by body from the leaves to the root, then substitute back",
     .source = "lecture, eq. 18; Featherstone 1983; Brandl, Johanni & Otter 1986",
     .recursive = true,
     .create_double = create<Recursive<double>, double>,
     .create_long_double = create<Recursive<long double>, long double>,
     .create_count = create<Recursive<Count>, Count>});
}  // namespace

}  // namespace lanc
