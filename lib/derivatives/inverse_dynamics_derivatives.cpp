#include "lib/derivatives/inverse_dynamics_derivatives.h"

#include <algorithm>
#include <array>
#include <utility>

#include "lib/system/passive_torque.h"

namespace lanc {
namespace {

/// Rows of `columns_`: M C, the bracket for η, the bracket for q (moment, force), the couples 2 Kᵀ C and Wᵀ C. Couples
/// are the same about every point.
enum Row { of_mass = 0, of_velocity = 6, of_position = 12, of_coriolis = 18, of_loads = 21, rows = 24 };
/// Rows of `met_`.
enum Met { position_inward, velocity_inward, position_outward, velocity_outward, met_rows };

[[gnu::always_inline]] inline Motion<double> cross(const Motion<double>& a, const Motion<double>& b) {
  return {cross(a.angular, b.angular), cross(a.angular, b.linear) + cross(a.linear, b.angular)};
}
/// C ×* f̂.
[[gnu::always_inline]] inline Wrench<double> cross(const Motion<double>& a, const Wrench<double>& f) {
  return {cross(a.angular, f.moment) + cross(a.linear, f.force), cross(a.angular, f.force)};
}

void put(const Vec3<double>& a, double* at, int stride) { at[0] = a.x, at[stride] = a.y, at[2 * stride] = a.z; }
void put(const Wrench<double>& f, double* at, int stride) {
  put(f.moment, at, stride);
  put(f.force, at + 3 * stride, stride);
}

using Direction = InverseDynamicsDerivatives::Direction;

/// Where a coordinate's meetings are written, one number a column.
struct Meetings {
  double *position, *velocity;          // of what is carried, in the coordinate's column
  double *position_out, *velocity_out;  // of the coordinate, in its row
};

/// The joint of a coordinate meets `count` columns of what it carries; these then go on by `arm`.
template <ColumnKind kind>
void meet_columns(const Direction& direction, const Vec3<double>& arm, int first, int end, const SixRows& columns,
                  bool loaded, const Meetings& to) {
  const Direction d = direction;
  const Vec3<double> r = arm;
  for_columns(first, end, [&](int c, auto lanes) {
    const auto group = [&](Row row) { return SixRows{columns.row(row), columns.stride}; };
    const auto couple = [&](Row row, const Vec3<double>& s) {
      const auto at = [&](int i) { return lanes.load(columns.row(row + i) + c); };
      return at(0) * s.x + at(1) * s.y + at(2) * s.z;
    };
    SixLanes mass(group(of_mass), c, lanes), position(group(of_position), c, lanes),
        velocity(group(of_velocity), c, lanes);
    Lanes in = project<ColumnKind::screw>(d.acceleration, mass) + couple(of_coriolis, d.velocity.angular);
    if (loaded) in += couple(of_loads, d.C.angular);
    lanes.store(to.position + c, in);
    in = project<ColumnKind::screw>(d.rate, mass);
    if constexpr (kind != ColumnKind::translation) in += couple(of_coriolis, d.C.angular);
    lanes.store(to.velocity + c, in);
    lanes.store(to.position_out + c, project<kind>(d.C, position));
    lanes.store(to.velocity_out + c, project<kind>(d.C, velocity));
    for (const auto& [wrenches, row] :
         {std::pair{&mass, of_mass}, {&position, of_position}, {&velocity, of_velocity}}) {
      wrenches->move_inward(r);
      wrenches->store_upper(group(row), c, lanes);
    }
  });
}

void move_columns(const Vec3<double>& arm, int first, int end, const SixRows& columns) {
  const Vec3<double> r = arm;
  for_columns(first, end, [&](int c, auto lanes) {
    for (const Row row : {of_mass, of_velocity, of_position}) {
      const SixRows group{columns.row(row), columns.stride};
      SixLanes f(group, c, lanes);
      f.move_inward(r);
      f.store_upper(group, c, lanes);
    }
  });
}

}  // namespace

InverseDynamicsDerivatives::InverseDynamicsDerivatives(const Model& model, const CoordinateOrder& order)
    : position(std::size_t(model.nv()) * model.nv()),
      velocity(position.size()),
      model_(model),
      order_(order),
      directions_(model.nv()),
      spatial_acceleration_(model.bodies()),
      carried_(model.bodies()),
      columns_(std::size_t(rows) * padded(model.nv())),
      met_(std::size_t(met_rows) * padded(model.nv())) {}

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
  const int stride = padded(model_.nv());
  for (int k = link.v; k < link.v + link.nv; ++k) {
    const Direction& d = directions_[k];
    double* at = columns_.data() + order_.place[k];
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

void InverseDynamicsDerivatives::meet(int k, ColumnKind kind, const Vec3<double>& arm, int end) {
  const int n = model_.nv(), first = order_.place[k];
  const auto met = [&](Met row) { return met_.data() + row * padded(n); };
  Meetings to{met(position_inward), met(velocity_inward), met(position_outward), met(velocity_outward)};
  const std::size_t row = std::size_t(k) * n;
  if (order_.same) to.position_out = &position[row], to.velocity_out = &velocity[row];
  static constexpr auto by_kind = std::array{meet_columns<ColumnKind::rotation>, meet_columns<ColumnKind::translation>,
                                             meet_columns<ColumnKind::screw>};
  by_kind[static_cast<int>(kind)](directions_[k], arm, first, end, columns(), loaded_, to);
  if (order_.same) {
    std::size_t at = row + n + k;
    for (int c = first + 1; c < end; ++c, at += n) position[at] = to.position[c], velocity[at] = to.velocity[c];
    return;
  }
  for (int c = first; c < end; ++c) {
    const std::size_t other = order_.coordinate[c];
    position[other * n + k] = to.position[c], velocity[other * n + k] = to.velocity[c];
    position[row + other] = to.position_out[c], velocity[row + other] = to.velocity_out[c];
  }
}

/// + C_k ×* f̂ of a joint that moves as one: its own coordinates do not see it.
void InverseDynamicsDerivatives::turn_wrench(int k, const Wrench<double>& wrench) {
  const Wrench<double> f = cross(directions_[k].C, wrench);
  const int n = padded(model_.nv());
  double* at = columns_.data() + of_position * n + order_.place[k];
  at[0] += f.moment.x, at[n] += f.moment.y, at[2 * n] += f.moment.z;
  at[3 * n] += f.force.x, at[4 * n] += f.force.y, at[5 * n] += f.force.z;
}

void InverseDynamicsDerivatives::add_passive(const State<double>& state) {
  const std::size_t n = model_.nv();
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
  if (!order_.chain)
    for (std::vector<double>* matrix : {&position, &velocity}) std::fill(matrix->begin(), matrix->end(), 0.0);
  outward(evaluator, system, state, solution);
  sum_loads(loads);
  for (int b = model_.bodies() - 1; b >= 0; --b) {
    const int i = order_.bodies[b];
    const Link& link = model_.link(i);
    begin_columns(i, system, solution.wrench[i]);
    const Vec3<double>& r = system.bodies[i].r;
    const bool one = moves_as_one(link);
    for (int k = link.v + link.nv - 1; k >= link.v; --k)
      meet(k, model_.column_kind(k), !one && k == link.v ? r : nowhere, order_.end[i]);
    if (link.parent == ground) continue;
    if (one)  // for those further inward
      for (int k = link.v; k < link.v + link.nv; ++k) turn_wrench(k, solution.wrench[i]);
    if (one || link.nv == 0) move_columns(r, order_.begin[i], order_.end[i], columns());
    Carried &from = carried_[i], &to = carried_[link.parent];
    to.inertia += moved_inward(r, from.inertia);
    to.momenta += moved_inward(r, from.momenta);
    if (loaded_) to.loads += moved_inward(r, from.loads);
  }
  add_passive(state);
}

}  // namespace lanc
