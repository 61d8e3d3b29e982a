#include "lib/derivatives/mass_inverse.h"

#include <algorithm>
#include <array>

#include "lib/derivatives/six_rows.h"

namespace lanc {
namespace {

/// A freedom of eq. 18 is released, leaf to root: response = Cᵀ f / N, f −= D Cᵀ f. Then the loads go on by `arm`.
template <ColumnKind kind>
void release(const Motion<double>& C, const Wrench<double>& D, double inverse, const Vec3<double>& arm, int first,
             int end, const SixRows& loads, double* response) {
  const Motion<double> c = C;
  const Wrench<double> d = D;
  const Vec3<double> r = arm;
  for_columns(first, end, [&](int i, auto lanes) {
    SixLanes f(loads, i, lanes);
    const Lanes torque = project<kind>(c, f);
    lanes.store(response + i, torque * inverse);
    f.add_upper(d.moment, -torque), f.add_lower(d.force, -torque);
    f.move_inward(r);
    f.store(loads, i, lanes);
  });
}

/// And root to leaf: accelerations come by `arm`; response −= D·a is then the freedom's η̇, and a += C η̇.
template <ColumnKind kind>
void follow(const Motion<double>& C, const Wrench<double>& D, const Vec3<double>& arm, int first, int end,
            const SixRows& from, const SixRows& to, double* response) {
  const Motion<double> c = C;
  const Wrench<double> d = D;
  const Vec3<double> r = arm;
  for_columns(first, end, [&](int i, auto lanes) {
    SixLanes a(from, i, lanes);
    a.move_outward(r);
    const Lanes vdot = lanes.load(response + i) - (a.upper(d.moment) + a.lower(d.force));
    lanes.store(response + i, vdot);
    add_along<kind>(c, vdot, a);
    a.store(to, i, lanes);
  });
}

constexpr auto releases =
    std::array{release<ColumnKind::rotation>, release<ColumnKind::translation>, release<ColumnKind::screw>};
constexpr auto follows =
    std::array{follow<ColumnKind::rotation>, follow<ColumnKind::translation>, follow<ColumnKind::screw>};

void move_inward(const Vec3<double>& arm, int first, int end, const SixRows& loads) {
  const Vec3<double> r = arm;
  for_columns(first, end, [&](int i, auto lanes) {
    SixLanes f(loads, i, lanes);
    f.move_inward(r);
    f.store_upper(loads, i, lanes);
  });
}

void move_outward(const Vec3<double>& arm, int first, int end, const SixRows& from, const SixRows& to) {
  const Vec3<double> r = arm;
  for_columns(first, end, [&](int i, auto lanes) {
    SixLanes a(from, i, lanes);
    a.move_outward(r);
    a.store(to, i, lanes);
  });
}

}  // namespace

MassInverse::MassInverse(const Model& model, const CoordinateOrder& order)
    : model_(model),
      order_(order),
      slot_(model.bodies()),
      star_(model.bodies()),
      freedoms_(model.nv()),
      load_(std::size_t(6) * padded(model.nv())),
      response_(order.same ? 0 : std::size_t(model.nv()) * model.nv()) {
  // The last of the siblings takes over its parent's place; those before need one more.
  int slots = 1;
  std::vector<int> last(model.bodies(), -1);
  for (const int i : order.bodies)
    if (const int p = model.link(i).parent; p != ground) last[p] = i;
  for (const int i : order.bodies) {
    const int p = model.link(i).parent;
    slot_[i] = p == ground ? 0 : slot_[p] + (last[p] == i ? 0 : 1);
    slots = std::max(slots, slot_[i] + 1);
  }
  slots_.resize(std::size_t(6) * padded(model.nv()) * slots);
}

void MassInverse::inward(const System<double>& system) {
  const SixRows f{load_.data(), padded(model_.nv())};
  for (int b = model_.bodies() - 1; b >= 0; --b) {
    const int i = order_.bodies[b];
    const Link& link = model_.link(i);
    ArticulatedInertia<double> rest = expanded(system.bodies[i].inertia);  // M*, then what is left of it
    if (!link.leaf) add(rest, star_[i]);
    const Vec3<double>& r = system.bodies[i].r;
    const int first = order_.begin[i], end = order_.end[i];
    for (int k = link.v + link.nv - 1; k >= link.v; --k) {
      const ColumnKind kind = model_.column_kind(k);
      const Motion<double>& C = system.columns[k];
      const Wrench<double> U = times_column(rest, kind, C);
      const double N = project(kind, C, U) + model_.armature()[k];
      Freedom& freedom = freedoms_[k];
      freedom.inverse = 1 / N;
      freedom.D = U * freedom.inverse;
      subtract_outer(rest, freedom.D, U);
      const int own = order_.place[k];
      const bool last = k == link.v;
      releases[static_cast<int>(kind)](C, freedom.D, freedom.inverse, last ? r : nowhere, own + 1, end, f, response(k));
      response(k)[own] = freedom.inverse;
      f.set(own, last ? moved_inward(r, freedom.D * -1) : freedom.D * -1);
    }
    if (link.parent == ground) continue;
    if (link.nv == 0) move_inward(r, first, end, f);
    if (link.last_sibling)
      star_[link.parent] = moved_inward(r, rest);
    else
      add(star_[link.parent], moved_inward(r, rest));
  }
}

void MassInverse::outward(const System<double>& system, std::vector<double>& inverse) {
  const int n = model_.nv(), stride = padded(n);
  const auto accelerations = [&](int body) {
    return SixRows{slots_.data() + std::size_t(6) * stride * slot_[body], stride};
  };
  for (const int i : order_.bodies) {
    const Link& link = model_.link(i);
    const int first = order_.begin[i], end = order_.tree_end[i];
    const SixRows a = accelerations(i);
    const bool root = link.parent == ground;
    if (root)
      for (int row = 0; row < 6; ++row) std::fill(a.row(row) + first, a.row(row) + end, 0.0);
    const SixRows parent = root ? a : accelerations(link.parent);
    const Vec3<double>& r = system.bodies[i].r;
    if (link.nv == 0) move_outward(r, first, end, parent, a);
    for (int k = link.v; k < link.v + link.nv; ++k) {
      const int own = order_.place[k];
      double* row = response(k);
      const bool arrive = k == link.v;
      follows[static_cast<int>(model_.column_kind(k))](system.columns[k], freedoms_[k].D, arrive ? r : nowhere, own,
                                                       end, arrive ? parent : a, a, row);
      if (order_.same) {  // row k of `inverse` itself
        double* column = inverse.data() + k;
        for (int c = own; c < end; ++c) column[std::size_t(c) * n] = row[c];
        continue;
      }
      for (int c = own; c < end; ++c) {
        const std::size_t other = order_.coordinate[c];
        inverse[other * n + k] = inverse[std::size_t(k) * n + other] = row[c];
      }
    }
  }
}

void MassInverse::evaluate(const System<double>& system, std::vector<double>& inverse) {
  if (!order_.chain) std::fill(inverse.begin(), inverse.end(), 0.0);
  if (!order_.same) std::fill(response_.begin(), response_.end(), 0.0);
  rows_ = order_.same ? inverse.data() : response_.data();
  inward(system);
  outward(system, inverse);
}

}  // namespace lanc
