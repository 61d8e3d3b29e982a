#include "formulations/schur-cholmod/schur_matrix.h"

#include <algorithm>
#include <cmath>

#include "formulations/schur-cholmod/dual_basis.h"

namespace lanc {

namespace {

int unknowns_of(const Model& model, const Link& link) {
  int size = 6 - link.nv;
  for (int k = link.v; k < link.v + link.nv; ++k) size += model.armature()[k] != 0;
  return size;
}

}  // namespace

/// J_c = J − m (c² 1 − c cᵀ), factored L D Lᵀ.
template <class S>
void SchurMatrix<S>::Body::invert(const RigidInertia<S>& M) {
  inverse_mass = S(1.0) / M.mass;
  c = M.h * inverse_mass;
  const Vec3<S>& h = M.h;
  const S hx = h.x * c.x, hy = h.y * c.y, hz = h.z * c.z;
  const S d1 = M.J.xx - (hy + hz);
  const S xy = M.J.xy + h.x * c.y, xz = M.J.xz + h.x * c.z;
  inverse_d.x = S(1.0) / d1;
  l21 = xy * inverse_d.x, l31 = xz * inverse_d.x;
  const S d2 = M.J.yy - (hx + hz) - l21 * xy;
  inverse_d.y = S(1.0) / d2;
  const S yz = M.J.yz + h.y * c.z - l21 * xz;
  l32 = yz * inverse_d.y;
  const S d3 = M.J.zz - (hx + hy) - l31 * xz - l32 * yz;
  inverse_d.z = S(1.0) / d3;
  quality = std::min({std::abs(to_double(d1) / to_double(M.J.xx)), std::abs(to_double(d2) / to_double(M.J.yy)),
                      std::abs(to_double(d3) / to_double(M.J.zz))});
}

template <class S>
Motion<S> SchurMatrix<S>::Body::times(const Wrench<S>& f) const {
  const Vec3<S> n = f.moment - cross(c, f.force);  // about the centre of mass
  const S y = n.y - l21 * n.x, z = n.z - l31 * n.x - l32 * y;
  Vec3<S> omega;
  omega.z = z * inverse_d.z;
  omega.y = y * inverse_d.y - l32 * omega.z;
  omega.x = n.x * inverse_d.x - l21 * omega.y - l31 * omega.z;
  return {omega, f.force * inverse_mass + cross(c, omega)};
}

template <class S>
std::int64_t SchurMatrix<S>::count_nonzeros(const Model& model) {
  // a body's joints are all coupled with each other: half of the square of their number of unknowns
  std::vector<std::int64_t> sum(model.bodies(), 0), squares(model.bodies(), 0);
  std::int64_t total = 0;
  for (int i = model.bodies() - 1; i >= 0; --i) {
    const Link& link = model.link(i);
    const std::int64_t m = unknowns_of(model, link);
    total += m * (m + 1) / 2 + m * sum[i] + (sum[i] * sum[i] - squares[i]) / 2;
    if (link.parent != ground) sum[link.parent] += m, squares[link.parent] += m * m;
  }
  for (int i = 0; i < model.bodies(); ++i) sum[i] += unknowns_of(model, model.link(i));
  for (const Closure& c : model.closures().closures)
    for (const int body : {c.body_a, c.body_b}) {
      if (body == ground) continue;
      const std::int64_t m = c.conditions().count;
      total += m * (sum[body] + m);
      sum[body] += m;
    }
  for (const Coupler& c : model.closures().couplers)
    for (const Coupler::Term& term : c.terms) {
      const int body = model.body_of_velocity(term.v), parent = model.link(body).parent;
      total += ++sum[body];
      if (parent != ground) total += ++sum[parent];
    }
  return total;
}

template <class S>
SchurMatrix<S>::SchurMatrix(const Model& model)
    : model_(model),
      bodies_(model.bodies()),
      joints_(model.bodies()),
      p_(model.nv()),
      load_(model.bodies()),
      known_(model.bodies()),
      free_(model.bodies()) {
  build();
  if (model.has_closures()) append_closures();
}

template <class S>
void SchurMatrix<S>::build() {
  const int n = model_.bodies();
  int total = 0;
  for (int i = 0; i < n; ++i) {
    Joint& joint = joints_[i];
    joint.size = unknowns_of(model_, model_.link(i));
    joint.first = total;
    total += joint.size;
  }
  w_.resize(total), y_.resize(total), z_.resize(total);
  for (Joint& joint : joints_) joint.start = total - joint.first - joint.size;

  // Which joints meet joint i at its parent: the parent's own, and siblings nearer to the root in number.
  std::vector<int> newest(n, ground), sibling(n, ground);  // children of a body, the last one first
  for (int i = 0; i < n; ++i) {
    joints_[i].coupled = static_cast<int>(couplings_.size());
    if (const int p = model_.link(i).parent; p != ground) {
      sibling[i] = newest[p], newest[p] = i;
      couplings_.push_back({p, 0});
      for (int j = sibling[i]; j != ground; j = sibling[j]) couplings_.push_back({j, 0});
    }
    joints_[i].coupled_end = static_cast<int>(couplings_.size());
  }
  // Rows of a column: the joints above it in the matrix, leaf first, then its own up to the diagonal.
  for (int i = n - 1; i >= 0; --i)
    for (int c = joints_[i].coupled; c < joints_[i].coupled_end; ++c) {
      Joint& other = joints_[couplings_[c].joint];
      couplings_[c].offset = other.own_offset;
      other.own_offset += joints_[i].size;
    }
  starts_.assign(total + 1, 0);
  for (int i = n - 1; i >= 0; --i) {
    Joint& joint = joints_[i];
    joint.column = starts_[joint.start];
    for (int c = 0; c < joint.size; ++c)
      starts_[joint.start + c + 1] = starts_[joint.start + c] + joint.own_offset + c + 1;
  }
  rows_.resize(starts_[total]);
  values_.assign(starts_[total], S(0.0));
  for (int i = 0; i < n; ++i) {
    const Joint& joint = joints_[i];
    for (int c = joint.coupled; c < joint.coupled_end; ++c) {
      const Joint& other = joints_[couplings_[c].joint];
      for (int b = 0; b < other.size; ++b)
        for (int a = 0; a < joint.size; ++a)
          rows_[starts_[other.start + b] + couplings_[c].offset + a] = joint.start + a;
    }
    for (int b = 0; b < joint.size; ++b) {
      for (int a = 0; a <= b; ++a) rows_[starts_[joint.start + b] + joint.own_offset + a] = joint.start + a;
      values_[starts_[joint.start + b + 1] - 1] = S(1.0);  // a regular sample for the solver
    }
  }
}

/// W_i and P_i from C_i. Columns that are pure rotations and translations have complements of the same kind.
template <class S>
void SchurMatrix<S>::joint_bases(const System<S>& system, int i) {
  const Link& link = model_.link(i);
  const Joint& joint = joints_[i];
  Wrench<S>* w = w_.data() + joint.first;
  const S o(0.0);
  const auto kind = [&](int k) { return model_.column_kind(link.v + k); };
  bool screws = false;
  for (int k = 0; k < link.nv; ++k) screws = screws || kind(k) == ColumnKind::screw;
  if (screws) {
    // Lengths measured in the model's: a basis that mixes moments and forces then does not depend on the unit of
    // length.
    const S per_length(std::exp2(-std::rint(std::log2(model_.length()))));
    std::array<std::array<S, 6>, 6> C{};
    for (int k = 0; k < link.nv; ++k) {
      const Motion<S>& a = system.columns[link.v + k];
      const Vec3<S> linear = a.linear * per_length;
      C[k] = {a.angular.x, a.angular.y, a.angular.z, linear.x, linear.y, linear.z};
    }
    const DualBasis<S, 6> basis(C, link.nv);
    const auto wrench = [&](const std::array<S, 6>& x) {
      return Wrench<S>{{x[0], x[1], x[2]}, Vec3<S>{x[3], x[4], x[5]} * per_length};
    };
    for (int k = 0; k < 6 - link.nv; ++k) *w++ = wrench(basis.K[k]);
    for (int k = 0; k < link.nv; ++k) p_[link.v + k] = wrench(basis.P[k]);
  } else {
    for (const ColumnKind half : {ColumnKind::rotation, ColumnKind::translation}) {
      const bool turns = half == ColumnKind::rotation;
      std::array<std::array<S, 3>, 3> C{};
      int f = 0;
      for (int k = 0; k < link.nv; ++k)
        if (kind(k) == half) {
          const Motion<S>& a = system.columns[link.v + k];
          const Vec3<S>& v = turns ? a.angular : a.linear;
          C[f++] = {v.x, v.y, v.z};
        }
      const DualBasis<S, 3> basis(C, f);
      const auto wrench = [&](const std::array<S, 3>& x) {
        const Vec3<S> v{x[0], x[1], x[2]}, zero{o, o, o};
        return turns ? Wrench<S>{v, zero} : Wrench<S>{zero, v};
      };
      for (int k = 0; k < 3 - f; ++k) *w++ = wrench(basis.K[k]);
      for (int k = 0, next = 0; k < link.nv; ++k)
        if (kind(k) == half) p_[link.v + k] = wrench(basis.P[next++]);
    }
  }
  for (int k = 0; k < link.nv; ++k)
    if (model_.armature()[link.v + k] != 0) *w++ = p_[link.v + k];
}

template <class S>
void SchurMatrix<S>::refill(const System<S>& system, std::span<const char> counts) {
  for (int i = 0; i < model_.bodies(); ++i) {
    const Link& link = model_.link(i);
    const Joint& joint = joints_[i];
    bodies_[i].invert(system.bodies[i].inertia);
    joint_bases(system, i);
    const Wrench<S>* w = w_.data() + joint.first;
    Wrench<S>* y = y_.data() + joint.first;
    Motion<S>* z = z_.data() + joint.first;
    for (int b = 0; b < joint.size; ++b) {
      const Motion<S> x = bodies_[i].times(w[b]);
      S* const column = values_.data() + starts_[joint.start + b] + joint.own_offset;
      for (int a = 0; a <= b; ++a) column[a] = dot(x, w[a]);
      if (link.parent == ground) continue;
      y[b] = moved_inward(system.bodies[i].r, w[b]) * S(-1.0);
      z[b] = bodies_[link.parent].times(y[b]);
      for (int a = 0; a <= b; ++a) column[a] += dot(z[b], y[a]);
    }
    for (int k = link.v + link.nv - 1, b = joint.size - 1; k >= link.v; --k)
      if (const double armature = model_.armature()[k]; armature != 0)
        values_[starts_[joint.start + b-- + 1] - 1] += S(1.0) / S(armature);
    for (int c = joint.coupled; c < joint.coupled_end; ++c) {
      const Joint& other = joints_[couplings_[c].joint];
      const Wrench<S>* theirs = (couplings_[c].joint == link.parent ? w_.data() : y_.data()) + other.first;
      for (int b = 0; b < other.size; ++b) {
        S* const column = values_.data() + starts_[other.start + b] + couplings_[c].offset;
        for (int a = 0; a < joint.size; ++a) column[a] = dot(z[a], theirs[b]);
      }
    }
  }
  if (!model_.has_closures()) return;
  counts_.assign(counts.begin(), counts.end());
  refill_closures(system);
}

template <class S>
void SchurMatrix<S>::scatter(const System<S>& system, const RightHandSide<S>& rhs, std::vector<S>& b) {
  for (int i = 0; i < model_.bodies(); ++i) {
    const Link& link = model_.link(i);
    load_[i] = rhs.force[i];
    if (link.nv == 0) continue;
    Wrench<S> known{{S(0.0), S(0.0), S(0.0)}, {S(0.0), S(0.0), S(0.0)}};
    for (int k = link.v; k < link.v + link.nv; ++k)
      if (model_.armature()[k] == 0) known += p_[k] * rhs.tau[k];
    known_[i] = known;
    load_[i] += known;
    if (link.parent != ground) load_[link.parent] -= moved_inward(system.bodies[i].r, known);
  }
  for (int i = 0; i < model_.bodies(); ++i) {
    const Link& link = model_.link(i);
    const Joint& joint = joints_[i];
    free_[i] = bodies_[i].times(load_[i]);
    for (int k = 0; k < joint.size; ++k) {
      const Wrench<S>& w = w_[joint.first + k];
      S& entry = b[joint.start + k];
      entry = dot(rhs.bias[i] - free_[i], w);
      if (link.parent != ground) entry -= dot(free_[link.parent], y_[joint.first + k]);
    }
    for (int k = link.v + link.nv - 1, row = joint.start + joint.size - 1; k >= link.v; --k)
      if (const double armature = model_.armature()[k]; armature != 0) b[row--] += rhs.tau[k] / S(armature);
  }
  scatter_closures(rhs, b);
}

template <class S>
void SchurMatrix<S>::gather(const System<S>& system, const RightHandSide<S>& rhs, const std::vector<S>& mu,
                            Solution<S>& solution) {
  for (int i = 0; i < model_.bodies(); ++i) {
    const Link& link = model_.link(i);
    const Joint& joint = joints_[i];
    Wrench<S> f{{S(0.0), S(0.0), S(0.0)}, {S(0.0), S(0.0), S(0.0)}};
    for (int k = 0; k < joint.size; ++k) f += w_[joint.first + k] * mu[joint.start + k];
    load_[i] += f;
    if (link.parent != ground) load_[link.parent] -= moved_inward(system.bodies[i].r, f);
    solution.wrench[i] = f;
    if (link.nv > 0) solution.wrench[i] += known_[i];
  }
  for (std::size_t k = 0; k < counts_.size(); ++k) solution.lambda[k] = mu[closure_start_ + k];
  for (std::size_t e = 0; e < ends_.size(); ++e) {
    const Wrench<S> reaction = end_w_[e] * solution.lambda[ends_[e].row];
    load_[ends_[e].body] += reaction;
    if (ends_[e].what == End::What::coordinate) solution.wrench[ends_[e].body] += reaction;
  }
  for (int i = 0; i < model_.bodies(); ++i) {
    const Link& link = model_.link(i);
    const Motion<S>& a = solution.acceleration[i] = bodies_[i].times(load_[i]);
    if (link.nv == 0) continue;
    Motion<S> d = a - rhs.bias[i];
    if (link.parent != ground) d = d - moved_outward(system.bodies[i].r, solution.acceleration[link.parent]);
    for (int k = link.v; k < link.v + link.nv; ++k) solution.vdot[k] = dot(d, p_[k]);
  }
}

template class SchurMatrix<double>;
template class SchurMatrix<long double>;
template class SchurMatrix<Count>;

}  // namespace lanc
