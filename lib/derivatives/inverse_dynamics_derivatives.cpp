#include "lib/derivatives/inverse_dynamics_derivatives.h"

#include <algorithm>
#include <numeric>

#include "lib/system/passive_torque.h"

namespace lanc {
namespace {

/// Rows of `columns_`: M C, the bracket for η, the bracket for q (moment, force), the couples 2 Kᵀ C and Wᵀ C. Couples
/// are the same about every point.
enum Row { of_mass = 0, of_velocity = 6, of_position = 12, of_coriolis = 18, of_loads = 21, rows = 24 };
/// Rows of `met_`.
enum Met { mass_row, position_inward, velocity_inward, position_outward, velocity_outward, met_rows };

Motion<double> cross(const Motion<double>& a, const Motion<double>& b) {
  return {cross(a.angular, b.angular), cross(a.angular, b.linear) + cross(a.linear, b.angular)};
}
/// C ×* f̂.
Wrench<double> cross(const Motion<double>& a, const Wrench<double>& f) {
  return {cross(a.angular, f.moment) + cross(a.linear, f.force), cross(a.angular, f.force)};
}

void put(const Vec3<double>& a, double* at, int stride) { at[0] = a.x, at[stride] = a.y, at[2 * stride] = a.z; }
void put(const Wrench<double>& f, double* at, int stride) {
  put(f.moment, at, stride);
  put(f.force, at + 3 * stride, stride);
}

/// One motion on all wrenches of a group of rows at c; what the kind knows to be zero is left out.
template <ColumnKind kind>
[[gnu::always_inline]] inline double power(const double* w, int stride, int c, const Motion<double>& m) {
  const double* f = w + c;
  double sum = 0;
  if constexpr (kind != ColumnKind::translation)
    sum += m.angular.x * f[0] + m.angular.y * f[stride] + m.angular.z * f[2 * stride];
  if constexpr (kind != ColumnKind::rotation)
    sum += m.linear.x * f[3 * stride] + m.linear.y * f[4 * stride] + m.linear.z * f[5 * stride];
  return sum;
}

using Direction = InverseDynamicsDerivatives::Direction;

/// The joint of coordinate k meets `count` columns of what it carries. w: first of them, in row 0.
template <ColumnKind kind>
[[gnu::noinline]] void project(const Direction& direction, const double* __restrict w, int stride, int count,
                               bool loaded, double* __restrict mass, double* __restrict position,
                               double* __restrict velocity, double* __restrict position_out,
                               double* __restrict velocity_out) {
  constexpr ColumnKind screw = ColumnKind::screw;
  const Direction d = direction;
  const Vec3<double> turn = d.velocity.angular, s = d.C.angular;
  for (int c = 0; c < count; ++c) {
    const double *coriolis = w + of_coriolis * stride + c, *x = coriolis, *y = x + stride, *z = y + stride;
    mass[c] = power<kind>(w, stride, c, d.C);
    position[c] = power<screw>(w, stride, c, d.acceleration) + turn.x * *x + turn.y * *y + turn.z * *z;
    double rate = power<screw>(w, stride, c, d.rate);
    if constexpr (kind != ColumnKind::translation) rate += s.x * *x + s.y * *y + s.z * *z;
    velocity[c] = rate;
    position_out[c] = power<kind>(w + of_position * stride, stride, c, d.C);
    velocity_out[c] = power<kind>(w + of_velocity * stride, stride, c, d.C);
  }
  if (!loaded || kind == ColumnKind::translation) return;
  const double *x = w + of_loads * stride, *y = x + stride, *z = y + stride;
  for (int c = 0; c < count; ++c) position[c] += s.x * x[c] + s.y * y[c] + s.z * z[c];
}

}  // namespace

InverseDynamicsDerivatives::InverseDynamicsDerivatives(const Model& model)
    : mass(std::size_t(model.nv()) * model.nv()),
      position(mass.size()),
      velocity(mass.size()),
      model_(model),
      place_(model.nv()),
      coordinate_(model.nv()),
      begin_(model.bodies()),
      end_(model.bodies()),
      directions_(model.nv()),
      spatial_acceleration_(model.bodies()),
      carried_(model.bodies()),
      columns_(std::size_t(rows) * model.nv()),
      met_(std::size_t(met_rows) * model.nv()) {
  number_coordinates();
}

void InverseDynamicsDerivatives::number_coordinates() {
  const int n = model_.bodies();
  std::vector<int> size(n, 1), first(n);  // bodies a body carries, itself included, and its place among all
  for (int i = n - 1; i >= 0; --i)
    if (const int p = model_.link(i).parent; p != ground) size[p] += size[i];
  std::vector<int> next(n);
  int roots = 0;
  for (int i = 0; i < n; ++i) {
    const int p = model_.link(i).parent;
    int& begin = p == ground ? roots : next[p];
    first[i] = begin, begin += size[i], next[i] = first[i] + 1;
  }
  bodies_.resize(n);
  for (int i = 0; i < n; ++i) bodies_[first[i]] = i;
  int place = 0;
  std::vector<int> before(n + 1, 0);
  for (int b = 0; b < n; ++b) {
    const Link& link = model_.link(bodies_[b]);
    for (int k = link.v; k < link.v + link.nv; ++k, ++place) {
      place_[k] = place, coordinate_[place] = k;
      in_order_ = in_order_ && place == k;
    }
    before[b + 1] = place;
  }
  for (int i = 0; i < n; ++i) begin_[i] = before[first[i]], end_[i] = before[first[i] + size[i]];
}

/// Root to leaf: what every direction does, and what each body has to sum.
void InverseDynamicsDerivatives::outward(Evaluator<double>& evaluator, const System<double>& system,
                                         const State<double>& state, const Solution<double>& solution) {
  const std::vector<Motion<double>>& twists = evaluator.twists();
  for (int i = 0; i < model_.bodies(); ++i) {
    const Link& link = model_.link(i);
    const Motion<double>& v = twists[i];
    const Motion<double>& a = solution.acceleration[i];
    spatial_acceleration_[i] = {a.angular, a.linear - cross(v.angular, v.linear) - model_.gravity()};
    carried_[i].inertia = system.bodies[i].inertia;
    carried_[i].momenta = momenta(system.bodies[i].inertia, v);
    Motion<double> vp{}, ap{{}, -model_.gravity()};
    if (link.parent != ground) {
      vp = moved_outward(system.bodies[i].r, twists[link.parent]);
      ap = moved_outward(system.bodies[i].r, spatial_acceleration_[link.parent]);
    }
    const bool one = moves_as_one(link);
    for (int k = link.v; k < link.v + link.nv; ++k) {
      Direction& d = directions_[k];
      d.C = system.columns[k];
      d.velocity = cross(vp, d.C);
      d.acceleration = cross(ap, d.C) + cross(vp, d.velocity);
      d.rate = d.velocity + (one ? cross(v, d.C) : d.velocity);
      if (one || k + 1 == link.v + link.nv) continue;
      // the massless body between this freedom and the next
      ap += d.C * solution.vdot[k] + d.velocity * state.v[k];
      vp += d.C * state.v[k];
    }
  }
}

void InverseDynamicsDerivatives::sum_loads(const Loads<double>& loads) {
  loaded_ = !model_.wrenches().empty() || !loads.wrenches.empty();
  if (!loaded_) return;
  for (Carried& c : carried_) c.loads = {};
  for (const ConstantWrench& w : model_.wrenches()) carried_[w.body].loads += dead_load(w.wrench);
  for (const auto& w : loads.wrenches) carried_[w.body].loads += dead_load(w.wrench);
}

/// The columns of a body's own coordinates, about its reference point.
void InverseDynamicsDerivatives::begin_columns(int body, const System<double>& system, const Wrench<double>& wrench) {
  const Link& link = model_.link(body);
  const Carried& carried = carried_[body];
  const int stride = model_.nv();
  for (int k = link.v; k < link.v + link.nv; ++k) {
    const Direction& d = directions_[k];
    double* at = columns_.data() + place_[k];
    put(times_column(carried.inertia, model_.column_kind(k), system.columns[k]), at + of_mass * stride, stride);
    put(carried.inertia * d.rate + carried.momenta(d.C.angular) * 2, at + of_velocity * stride, stride);
    Wrench<double> bracket = carried.inertia * d.acceleration + carried.momenta(d.velocity.angular) * 2;
    if (loaded_) {
      bracket += carried.loads(d.C.angular);
      put(carried.loads.transposed(d.C), at + of_loads * stride, stride);
    }
    if (!moves_as_one(link)) bracket += cross(d.C, wrench);
    put(bracket, at + of_position * stride, stride);
    put(carried.momenta.transposed(d.C) * 2, at + of_coriolis * stride, stride);
  }
}

void InverseDynamicsDerivatives::meet(int k, ColumnKind kind, int end) {
  const int n = model_.nv(), first = place_[k], count = end - first;
  const auto met = [&](Met row) { return met_.data() + row * n; };
  double *mass_in = met(mass_row), *position_in = met(position_inward), *velocity_in = met(velocity_inward),
         *position_out = met(position_outward), *velocity_out = met(velocity_outward);
  const std::size_t column = std::size_t(k) * n;
  if (in_order_) {
    const std::size_t at = column + k;
    mass_in = mass.data() + at, position_in = position.data() + at, velocity_in = velocity.data() + at;
  }
  static constexpr auto by_kind =
      std::array{project<ColumnKind::rotation>, project<ColumnKind::translation>, project<ColumnKind::screw>};
  by_kind[static_cast<int>(kind)](directions_[k], columns_.data() + first, n, count, loaded_, mass_in, position_in,
                                  velocity_in, position_out, velocity_out);
  for (int c = 1; c < count; ++c) {
    const std::size_t at = std::size_t(coordinate_[first + c]) * n + k;
    position[at] = position_out[c], velocity[at] = velocity_out[c];
  }
  if (in_order_) return;
  for (int c = 0; c < count; ++c) {
    const std::size_t at = column + coordinate_[first + c];
    mass[at] = mass_in[c], position[at] = position_in[c], velocity[at] = velocity_in[c];
  }
}

/// + C_k ×* f̂ of a joint that moves as one: its own coordinates do not see it.
void InverseDynamicsDerivatives::turn_wrench(int k, const Wrench<double>& wrench) {
  const Wrench<double> f = cross(directions_[k].C, wrench);
  const int n = model_.nv();
  double* at = columns_.data() + of_position * n + place_[k];
  at[0] += f.moment.x, at[n] += f.moment.y, at[2 * n] += f.moment.z;
  at[3 * n] += f.force.x, at[4 * n] += f.force.y, at[5 * n] += f.force.z;
}

/// To the parent's reference point: B_ipᵀ of all columns.
void InverseDynamicsDerivatives::move(int first, int end, const Vec3<double>& r) {
  const int n = model_.nv();
  for (const int row : {of_mass, of_velocity, of_position}) {
    double* __restrict f = columns_.data() + row * n;
    for (int c = first; c < end; ++c) {
      const double x = f[3 * n + c], y = f[4 * n + c], z = f[5 * n + c];
      f[c] += r.y * z - r.z * y;
      f[n + c] += r.z * x - r.x * z;
      f[2 * n + c] += r.x * y - r.y * x;
    }
  }
}

void InverseDynamicsDerivatives::add_passive(const State<double>& state) {
  const std::size_t n = model_.nv();
  if (model_.has_armature())
    for (std::size_t k = 0; k < n; ++k) mass[k * n + k] += model_.armature()[k];
  for (const PassiveCoordinate& passive : model_.passive()) {
    const Link& link = model_.link(passive.body);
    if (link.drive >= 0) continue;
    const std::size_t k = link.v + passive.coordinate;
    Dual<2> q;
    if (passive.spec.stiffness != 0) q = Dual<2>::variable(state.q[link.q + passive.coordinate], 0);
    const Dual<2> torque = passive_torque(passive.spec, q, Dual<2>::variable(state.v[k], 1));
    position[k * n + k] -= torque.d[0];
    velocity[k * n + k] -= torque.d[1];
  }
}

void InverseDynamicsDerivatives::evaluate(Evaluator<double>& evaluator, const System<double>& system,
                                          const State<double>& state, const Loads<double>& loads,
                                          const Solution<double>& solution) {
  for (std::vector<double>* matrix : {&mass, &position, &velocity}) std::fill(matrix->begin(), matrix->end(), 0.0);
  outward(evaluator, system, state, solution);
  sum_loads(loads);
  for (int b = model_.bodies() - 1; b >= 0; --b) {
    const int i = bodies_[b];
    const Link& link = model_.link(i);
    begin_columns(i, system, solution.wrench[i]);
    for (int k = link.v; k < link.v + link.nv; ++k) meet(k, model_.column_kind(k), end_[i]);
    if (link.parent == ground) continue;
    if (moves_as_one(link))  // for those further inward
      for (int k = link.v; k < link.v + link.nv; ++k) turn_wrench(k, solution.wrench[i]);
    const Vec3<double>& r = system.bodies[i].r;
    move(begin_[i], end_[i], r);
    Carried &from = carried_[i], &to = carried_[link.parent];
    to.inertia += moved_inward(r, from.inertia);
    to.momenta += moved_inward(r, from.momenta);
    if (loaded_) to.loads += moved_inward(r, from.loads);
  }
  add_passive(state);
}

}  // namespace lanc
