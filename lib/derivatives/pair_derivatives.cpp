#include "lib/derivatives/pair_derivatives.h"

#include "lib/system/closure_jacobian.h"
#include "lib/system/equations.h"

namespace lanc {
namespace {

constexpr int lanes = 8, directions = 24, most_rows = 6;
using D = Dual<lanes>;

double component(const Motion<double>& m, int i) {
  const Vec3<double>& v = i < 3 ? m.angular : m.linear;
  return i % 3 == 0 ? v.x : i % 3 == 1 ? v.y : v.z;
}
Motion<double> unit(int i) {
  const auto e = [](int j) { return Vec3<double>{j == 0 ? 1.0 : 0.0, j == 1 ? 1.0 : 0.0, j == 2 ? 1.0 : 0.0}; };
  return {e(i), e(i - 3)};
}

void add(Vec3<D>& v, const Vec3<double>& d, int lane) { v.x.d[lane] += d.x, v.y.d[lane] += d.y, v.z.d[lane] += d.z; }
Vec3<double> value(const Vec3<D>& v) { return {v.x.value, v.y.value, v.z.value}; }
Vec3<double> derivative(const Vec3<D>& v, int lane) { return {v.x.d[lane], v.y.d[lane], v.z.d[lane]}; }
Wrench<double> value(const Wrench<D>& w) { return {value(w.moment), value(w.force)}; }
Wrench<double> derivative(const Wrench<D>& w, int lane) {
  return {derivative(w.moment, lane), derivative(w.force, lane)};
}

/// The body, changing at rate 1 along its direction i: displacements 0..5, then twists.
void seed(MovingBody<D>& body, int i, int lane) {
  const Motion<double> e = unit(i % 6);
  if (i < 6) {
    for (Vec3<D>* axis : {&body.axes.x, &body.axes.y, &body.axes.z}) add(*axis, cross(e.angular, value(*axis)), lane);
    add(body.position, e.linear, lane);
  } else {
    add(body.twist.angular, e.angular, lane), add(body.twist.linear, e.linear, lane);
  }
}

MovingBody<D> lifted(const MovingBody<double>& body) {
  return {cast<D>(body.axes), cast<D>(body.position), cast<D>(body.twist)};
}

void add(Wrench<double>& w, const Wrench<double>& d, double by) { w += d * by; }
void add(WrenchPair<double>& w, const WrenchPair<double>& d, double by) { add(w.a, d.a, by), add(w.b, d.b, by); }

}  // namespace

struct PairDerivatives::Sensitivity {
  WrenchPair<double> value, wrench[directions];
  double row[directions][most_rows] = {};

  /// what(a, b, wrenches, rows) on dual bodies.
  template <class What>
  Sensitivity(const MovingBody<double>& a, const MovingBody<double>& b, What&& what) {
    for (int first = 0; first < directions; first += lanes) {
      MovingBody<D> da = lifted(a), db = lifted(b);
      for (int lane = 0; lane < lanes; ++lane)
        seed(first + lane < directions / 2 ? da : db, (first + lane) % (directions / 2), lane);
      WrenchPair<D> wrenches{};
      D rows[most_rows];
      what(da, db, wrenches, rows);
      value = {lanc::value(wrenches.a), lanc::value(wrenches.b)};
      for (int lane = 0; lane < lanes; ++lane) {
        wrench[first + lane] = {derivative(wrenches.a, lane), derivative(wrenches.b, lane)};
        for (int k = 0; k < most_rows; ++k) row[first + lane][k] = rows[k].d[lane];
      }
    }
  }
};

PairDerivatives::PairDerivatives(const Model& model) : model_(model) {
  if (!model.springs().empty() || model.has_closures())
    rhs_ = RightHandSide<double>(model), alone_ = Solution<double>(model);
  for (const PointSpring& s : model.springs()) springs_.push_back(add_pair(s.body_a, s.body_b));
  for (const Closure& c : model.closures().closures) closures_.push_back(add_pair(c.body_a, c.body_b));
}

PairDerivatives::Pair PairDerivatives::add_pair(int body_a, int body_b) {
  Pair pair{body_a, body_b, static_cast<int>(steps_.size()), 0};
  const int until = common_ancestor(model_, body_a, body_b);
  for (const Side side : {on_a, on_b})
    for (int i = side == on_a ? body_a : body_b; i != until; i = model_.link(i).parent) {
      const Link& link = model_.link(i);
      for (int k = link.v + link.nv - 1; k >= link.v; --k) {
        Step step{};
        step.k = k, step.side = side, step.as_one = moves_as_one(link);
        steps_.push_back(step);
      }
    }
  pair.end = static_cast<int>(steps_.size());
  return pair;
}

const Solution<double>& PairDerivatives::without_pairs(Evaluator<double>& evaluator, const System<double>& system,
                                                       const Solution<double>& solution) {
  evaluator.positions(), evaluator.twists();
  rhs_ = system.rhs, alone_ = solution;
  for (const PointSpring& s : model_.springs()) {
    const WrenchPair<double> w = spring_wrenches(s, evaluator.moving_body(s.body_a), evaluator.moving_body(s.body_b));
    if (s.body_a != ground) rhs_.force[s.body_a] -= w.a;
    if (s.body_b != ground) rhs_.force[s.body_b] -= w.b;
  }
  std::fill(alone_.lambda.begin(), alone_.lambda.end(), 0.0);
  wrenches(system, rhs_, alone_);
  return alone_;
}

void PairDerivatives::walk(const Pair& pair, const Evaluator<double>& evaluator,
                           const InverseDynamicsDerivatives& dynamics, const Solution<double>* solution) {
  for (int i = pair.begin; i < pair.end; ++i) {
    Step& step = steps_[i];
    const int body = step.side == on_a ? pair.body_a : pair.body_b;
    const MovingBody<double> at = evaluator.moving_body(body);
    const Vec3<double> r = at.position - evaluator.moving_body(model_.body_of_velocity(step.k)).position;
    const InverseDynamicsDerivatives::Direction& d = dynamics.direction(step.k);
    const Motion<double> velocity = moved_outward(r, d.velocity);  // Ψ̇
    step.C = moved_outward(r, d.C);
    const Vec3<double>&s = step.C.angular, &w = at.twist.angular, &v = at.twist.linear;
    step.twist = Motion<double>{cross(s, w), cross(s, v)} + velocity;
    if (!solution) continue;
    const Motion<double>& a = solution->acceleration[body];
    const Motion<double> second = moved_outward(r, d.acceleration), rate = moved_outward(r, d.rate);
    step.acceleration = {
        cross(s, a.angular) + second.angular - cross(w, velocity.angular),
        cross(s, a.linear) + second.linear + cross(model_.gravity(), s) + cross(velocity.angular, v) * 2};
    step.acceleration_v = {rate.angular - cross(w, s), rate.linear + cross(s, v) * 2};
  }
}

/// As in `dynamics`: seen from the displaced bodies a wrench changes by δ′w = δw − [s × τ; s × f], and further inward
/// than the direction by C ×* w besides. Coordinates that carry both bodies see no change: the wrenches balance.
void PairDerivatives::add_wrenches(const Pair& pair, const Sensitivity& sensitivity,
                                   InverseDynamicsDerivatives& dynamics) {
  const std::size_t n = model_.nv();
  const WrenchPair<double>& wrenches = sensitivity.value;
  for (int i = pair.begin; i < pair.end; ++i) {
    Step& step = steps_[i];
    const WrenchPair<double>* of_side = sensitivity.wrench + (step.side == on_a ? 0 : directions / 2);
    step.wrench = step.wrench_v = {};
    for (int c = 0; c < 6; ++c) {
      add(step.wrench, of_side[c], component(step.C, c));
      add(step.wrench, of_side[6 + c], component(step.twist, c));
      add(step.wrench_v, of_side[6 + c], component(step.C, c));
    }
    const Wrench<double>& own = step.side == on_a ? wrenches.a : wrenches.b;
    const Vec3<double>& s = step.C.angular;
    (step.side == on_a ? step.wrench.a : step.wrench.b) -= {cross(s, own.moment), cross(s, own.force)};
  }
  for (int l = pair.begin; l < pair.end; ++l)
    for (int k = pair.begin; k < pair.end; ++k) {
      const Step &in = steps_[l], &out = steps_[k];
      const std::size_t at = out.k * n + in.k;
      Wrench<double> change = out.side == on_a ? in.wrench.a : in.wrench.b;
      const bool one_joint = in.as_one && model_.body_of_velocity(in.k) == model_.body_of_velocity(out.k);
      if (in.side == out.side && l < k && !one_joint) {
        const Wrench<double>& w = in.side == on_a ? wrenches.a : wrenches.b;
        change +=
            Wrench<double>{cross(in.C.angular, w.moment) + cross(in.C.linear, w.force), cross(in.C.angular, w.force)};
      }
      dynamics.position[at] -= dot(out.C, change);
      dynamics.velocity[at] -= dot(out.C, out.side == on_a ? in.wrench_v.a : in.wrench_v.b);
    }
}

void PairDerivatives::add_rows(const Pair& pair, const Sensitivity& sensitivity, const Closure& closure,
                               const System<double>& system, std::vector<double>& position,
                               std::vector<double>& velocity) const {
  const int total = model_.closures().rows();
  for (int i = pair.begin; i < pair.end; ++i) {
    const Step& step = steps_[i];
    const auto* of_side = sensitivity.row + (step.side == on_a ? 0 : directions / 2);
    for (int k = 0; k < closure.conditions().count; ++k) {
      const auto& row = system.closure_rows[closure.row + k];
      const Wrench<double>& G = step.side == on_a ? row.a : row.b;
      double along_q = dot(step.acceleration, G), along_v = dot(step.acceleration_v, G);
      for (int c = 0; c < 6; ++c) {
        along_q += of_side[c][k] * component(step.C, c) + of_side[6 + c][k] * component(step.twist, c);
        along_v += of_side[6 + c][k] * component(step.C, c);
      }
      const std::size_t at = std::size_t(step.k) * total + closure.row + k;
      position[at] += along_q, velocity[at] += along_v;
    }
  }
}

void PairDerivatives::add_springs(const Evaluator<double>& evaluator, InverseDynamicsDerivatives& dynamics) {
  for (std::size_t p = 0; p < springs_.size(); ++p) {
    const Pair& pair = springs_[p];
    const PointSpring& spring = model_.springs()[p];
    walk(pair, evaluator, dynamics, nullptr);
    const Sensitivity sensitivity(
        evaluator.moving_body(pair.body_a), evaluator.moving_body(pair.body_b),
        [&](const auto& a, const auto& b, WrenchPair<D>& wrenches, D*) { wrenches = spring_wrenches(spring, a, b); });
    add_wrenches(pair, sensitivity, dynamics);
  }
}

void PairDerivatives::add_closures(const Evaluator<double>& evaluator, const System<double>& system, double t,
                                   const Solution<double>& solution, const std::vector<double>& lambda,
                                   InverseDynamicsDerivatives& dynamics, std::vector<double>& position,
                                   std::vector<double>& velocity) {
  const ClosureSet& set = model_.closures();
  for (std::size_t p = 0; p < closures_.size(); ++p) {
    const Pair& pair = closures_[p];
    const Closure& closure = set.closures[p];
    walk(pair, evaluator, dynamics, &solution);
    const auto acceleration = [&](int body) {
      return cast<D>(body == ground ? Motion<double>{} : solution.acceleration[body]);
    };
    const Motion<D> a_a = acceleration(pair.body_a), a_b = acceleration(pair.body_b);
    const Sensitivity sensitivity(evaluator.moving_body(pair.body_a), evaluator.moving_body(pair.body_b),
                                  [&](const auto& a, const auto& b, WrenchPair<D>& wrenches, D* rows) {
                                    closure::rows_of(closure, set, t, a, b, [&](int k, const closure::Row<D>& row) {
                                      const D multiplier(lambda[closure.row + k]);
                                      wrenches.a += row.a * multiplier, wrenches.b += row.b * multiplier;
                                      rows[k] = dot(a_a, row.a) + dot(a_b, row.b) + row.bias;
                                    });
                                  });
    add_wrenches(pair, sensitivity, dynamics);
    add_rows(pair, sensitivity, closure, system, position, velocity);
  }
}

}  // namespace lanc
