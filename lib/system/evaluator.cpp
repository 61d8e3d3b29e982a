#include "lib/system/evaluator.h"

#include <algorithm>

#include "lib/scalar/native_pack.h"
#include "lib/spatial/wide.h"
#include "lib/system/body_lanes.h"
#include "lib/system/passive_torque.h"

namespace lanc {

template <class S>
Evaluator<S>::Evaluator(const Model& model)
    : system_(model),
      frames_(lanes * blocks_of<S>(model.bodies())),
      masses_(blocks_of<S>(model.bodies())),
      origin_velocities_(model.bodies()),
      motions_(model.drives()),
      sampled_(model.angles().begin(), model.angles().end()),
      angles_(lanes * blocks_of<S>(static_cast<int>(model.angles().size())), S(0.0)),  // whole blocks
      sines_(angles_.size()),
      cosines_(angles_.size()),
      closure_blocks_(closure_blocks(model.closures())),
      positions_(model.bodies()),
      twists_(model.bodies()) {
  only_angles_ = model.nq() == static_cast<int>(sampled_.size());
  for (int k = 0; only_angles_ && k < model.nq(); ++k) only_angles_ = sampled_[k] == k;
  if (!sampled_.empty()) sampled_.resize(angles_.size(), sampled_.back());
  // Columns of pure rotations and translations keep these zeros; step() writes the other half only.
  for (auto& column : system_.columns) column = {{S(0.0), S(0.0), S(0.0)}, {S(0.0), S(0.0), S(0.0)}};
  for (auto& column : system_.drive_columns) column = {{S(0.0), S(0.0), S(0.0)}, {S(0.0), S(0.0), S(0.0)}};
  for (int i = 0; i < model.bodies(); ++i) {
    const Link& link = model.link(i);
    Masses& masses = masses_[static_cast<unsigned>(i) / lanes];
    const PrincipalTensor<double> J = principal_tensor(link.inertia.J);
    if constexpr (lanes == 1) {
      masses = {link.inertia.h, J, link.weight};
    } else {
      set_lane<S>(masses.h, lane(i), link.inertia.h);
      masses.J.c.set(lane(i), J.c), set_lane<S>(masses.J.u, lane(i), J.u), set_lane<S>(masses.J.w, lane(i), J.w);
      set_lane<S>(masses.weight, lane(i), link.weight);
    }
    system_.bodies[i].inertia.mass = S(link.inertia.mass);
  }
}

namespace {

/// R X.
template <FrameTurn turn, class S, class W>
[[gnu::always_inline]] inline Mat3<W> turned(const Mat3<W>& R, const Mat3<double>& X) {
  if constexpr (turn == FrameTurn::none) return R;
  if constexpr (turn == FrameTurn::yzx) return {R.y, R.z, R.x};
  if constexpr (turn == FrameTurn::zxy) return {R.z, R.x, R.y};
  if constexpr (turn == FrameTurn::other) return R * cast<S>(X);
}

}  // namespace

/// One body: pose and angular velocity (5), (7), bias acceleration (9). Works on local copies and stores them at the
/// end: the compiler cannot know that the arrays do not overlap.
template <class S>
template <class Joint, FrameTurn turn>
void Evaluator<S>::step(int body, const S* q, const S* v) {
  constexpr JointTraits traits = Joint::traits;
  using W = Widest<S>;
  const Link& link = system_.model.link(body);
  JointStep<W> joint;
  joint.pitch = link.pitch;
  Turns<Joint, S> turns;
  for (std::size_t a = 0; a < turns.size(); ++a) turns[a] = {sines_[link.angle + a], cosines_[link.angle + a]};
  std::array<Motion<W>, traits.nv> columns;
  Vec3<W> r, w;  // w: angular velocity of the body
  Motion<W> bias{};
  if (link.parent == ground) {
    joint.F = widened<W>(cast<S>(link.X));
    Joint::move(q, turns.data(), v, joint, columns.data());
    r = widened<W>(cast<S>(link.o));
    if constexpr (traits.moves_origin) r += joint.displacement;
    if constexpr (traits.nv > 0) w = joint.angular;
  } else {
    const BodyFrame<S>& parent = frames_[link.parent];
    const Mat3<W> R{load<W>(parent.x), load<W>(parent.y), load<W>(parent.z)};
    const Vec3<W> omega = load<W>(parent.omega);
    joint.F = turned<turn, S>(R, link.X);
    Joint::move(q, turns.data(), v, joint, columns.data());
    r = R * cast<S>(link.o);
    if constexpr (traits.moves_origin) r += joint.displacement;
    w = omega;
    if constexpr (traits.nv > 0) {
      w += joint.angular;
      bias.angular = cross(omega, joint.angular);
    }
    bias.linear = cross(omega, cross(omega, r));
    if constexpr (traits.moves_origin) {
      const Vec3<W> coriolis = cross(omega, joint.linear);
      bias.linear += coriolis + coriolis;
    }
  }
  if constexpr (Joint::has_column_rate) {
    bias.angular += joint.angular_rate;
    if constexpr (traits.moves_origin) bias.linear += joint.linear_rate;
  }
  if constexpr (traits.nv == 1)
    if (link.drive >= 0) add_along(traits.columns[0], columns[0], S(motions_[link.drive].acceleration), bias);

  Motion<S>* out = link.drive < 0 ? system_.columns.data() + link.v : system_.drive_columns.data() + link.drive;
  for (int k = 0; k < traits.nv; ++k) {
    if (traits.columns[k] != ColumnKind::translation) store(columns[k].angular, out[k].angular);
    if (traits.columns[k] != ColumnKind::rotation) store(columns[k].linear, out[k].linear);
  }
  store(r, system_.bodies[body].r);
  store(bias.angular, system_.rhs.bias[body].angular), store(bias.linear, system_.rhs.bias[body].linear);
  BodyFrame<S>& frame = frames_[body];
  store(joint.R.x, frame.x), store(joint.R.y, frame.y), store(joint.R.z, frame.z), store(w, frame.omega);
  if constexpr (traits.moves_origin) store(joint.linear, origin_velocities_[body]);
}

/// A block of bodies, for each by itself: inertia in world axes, gyroscopic force and weight.
template <class S>
void Evaluator<S>::weigh(int block) {
  const int width = lanes, first = block * width, last = std::min(first + width, system_.model.bodies());
  Mat3<B> R;
  Vec3<B> w;
  frames_into_lanes<S>(frames_.data() + first, R, w);
  const Masses& masses = masses_[block];
  const Vec3<B> h = R * cast<B>(masses.h);
  const Sym3<B> J = rotated(R, masses.J);
  // f̂^c = [(J ω) × ω; (ω × h) × ω], f̂^t = [h × g; m g]
  const Vec3<B> moment = plus_cross(cross(J * w, w), h, cast<B>(system_.model.gravity())),
                force = plus_cross(cast<B>(masses.weight), cross(w, h), w);
  bodies_from_lanes<S>(h, J, {moment, force}, first, last, system_);
}

template <class S>
const System<S>& Evaluator<S>::system(const State<S>& state, const Loads<S>& loads, [[maybe_unused]] Prefetch* ahead) {
  using Step = void (*)(Evaluator&, int body, const S* q, const S* v);
  static constexpr auto steps = for_each_joint_kind([]<class Joint>() {
    constexpr auto with = []<FrameTurn turn>() -> Step {
      return [](Evaluator& self, int body, const S* q, const S* v) { self.step<Joint, turn>(body, q, v); };
    };
    using enum FrameTurn;  // in their order
    return std::array{with.template operator()<none>(), with.template operator()<yzx>(),
                      with.template operator()<zxy>(), with.template operator()<other>()};
  });
  const Model& model = system_.model;
  sample_motions(state.t);
  sample_angles(state);
  constexpr int width = lanes;
  const int n = model.bodies();
  for (int i = 0; i < n; ++i) {
    if constexpr (std::is_same_v<S, NativePack>)
      if (ahead && i % Prefetch::bodies_a_step == 0) ahead->step();
    const Link& link = model.link(i);
    const Step step = steps[link.kind.index][static_cast<int>(link.turn)];
    if (link.drive < 0) {
      step(*this, i, state.q.data() + link.q, state.v.data() + link.v);
    } else {
      const S position(motions_[link.drive].position), velocity(motions_[link.drive].velocity);
      step(*this, i, &position, &velocity);
    }
    if ((i + 1) % width == 0 || i + 1 == n) weigh(i / width);
  }
  if (loads.tau.empty())
    std::fill(system_.rhs.tau.begin(), system_.rhs.tau.end(), S(0.0));
  else
    std::copy(loads.tau.begin(), loads.tau.end(), system_.rhs.tau.begin());
  apply_passive(state);
  if (!model.springs().empty()) apply_springs();
  for (const ConstantWrench& w : model.wrenches()) system_.rhs.force[w.body] += cast<S>(w.wrench);
  for (const auto& w : loads.wrenches) system_.rhs.force[w.body] += w.wrench;
  if (model.has_closures()) close_loops(state);
  return system_;
}

template <class S>
void Evaluator<S>::sample_motions(double t) {
  for (int d = 0; d < system_.model.drives(); ++d) motions_[d] = system_.model.motion(d).at(t);
}

template <class S>
void Evaluator<S>::sample_angles(const State<S>& state) {
  const int n = static_cast<int>(sampled_.size());
  if (lanes == 1 && only_angles_) return sines_and_cosines(state.q.data(), sines_.data(), cosines_.data(), n);
  // In whole blocks: what is written number by number is late for a block.
  const auto sample = [&](auto angle) __attribute__((always_inline)) {
    constexpr int width = lanes;
    for (int first = 0; first < n; first += width) {
      B block;
      for (int k = 0; k < width; ++k) PackedScalar<S>::set(block, k, angle(sampled_[first + k]));
      store_block<S>(block, angles_.data() + first);
    }
  };
  const S* const q = state.q.data();
  if (system_.model.drives() == 0)
    sample([q](int from) { return q[from]; });
  else
    sample([&](int from) { return from >= 0 ? q[from] : S(motions_[-1 - from].position); });
  sines_and_cosines(angles_.data(), sines_.data(), cosines_.data(), n);
}

/// Joint springs, dampers, Coulomb friction and constant torques: into τ, or onto the drive of a prescribed freedom.
template <class S>
void Evaluator<S>::apply_passive(const State<S>& state) {
  std::fill(system_.drive_load.begin(), system_.drive_load.end(), S(0.0));
  for (const PassiveCoordinate& passive : system_.model.passive()) {
    const Link& link = system_.model.link(passive.body);
    const CoordinateSpec& c = passive.spec;
    const bool driven = link.drive >= 0;
    const S v = driven ? S(motions_[link.drive].velocity) : state.v[link.v + passive.coordinate];
    // only coordinates whose rates are velocities have a spring, and then a position of the same number
    S q(0.0);
    if (c.stiffness != 0) q = driven ? S(motions_[link.drive].position) : state.q[link.q + passive.coordinate];
    const S torque = passive_torque(c, q, v);
    if (driven)
      system_.drive_load[link.drive] = S(c.armature * motions_[link.drive].acceleration) - torque;
    else
      system_.rhs.tau[link.v + passive.coordinate] += torque;
  }
}

template <class S>
[[gnu::always_inline]] inline MovingBody<S> Evaluator<S>::moving_body(int body) const {
  const BodyFrame<S>* frame = &ground_.frame;
  const Vec3<S>* position = &ground_.position;
  const Motion<S>* twist = &ground_.twist;
  if (body != ground) frame = &frames_[body], position = &positions_[body], twist = &twists_[body];
  return {axes_of(*frame), *position, *twist};
}

template <class S>
void Evaluator<S>::apply_springs() {
  move_bodies<true, true>();
  for (const PointSpring& spring : system_.model.springs()) {
    const WrenchPair<S> w = spring_wrenches(spring, moving_body(spring.body_a), moving_body(spring.body_b));
    if (spring.body_a != ground) system_.rhs.force[spring.body_a] += w.a;
    if (spring.body_b != ground) system_.rhs.force[spring.body_b] += w.b;
  }
}

/// Rows of all closures: g, ġ, G_a, G_b and γ̿.
template <class S>
void Evaluator<S>::close_loops(const State<S>& state) {
  const ClosureSet& set = system_.model.closures();
  system_.state = state;
  move_bodies<true, true>();
  const Vec3<S> none{S(0.0), S(0.0), S(0.0)};
  for (const ClosureBlock& block : closure_blocks_) {
    if (lanes > 1 && block.count > 1) {
      close_side_by_side(block);
      continue;
    }
    for (int i = block.first; i < block.first + block.count; ++i) {
      const Closure& c = set.closures[i];
      closure::rows_of(c, set, state.t, moving_body(c.body_a), moving_body(c.body_b),
                       [&](int k, const closure::Row<S>& row) {
                         system_.closure_rows[c.row + k] = {row.a, row.b, row.value, row.rate};
                         system_.rhs.closure[c.row + k] = row.bias;
                       });
    }
  }
  for (const Coupler& c : set.couplers) {
    MotionSample motion;
    if (c.motion >= 0) motion = set.motions[c.motion]->at(state.t);
    S g(-c.offset - motion.position), rate(-motion.velocity);
    for (const Coupler::Term& term : c.terms) {
      g += S(term.factor) * state.q[term.q];
      rate += S(term.factor) * state.v[term.v];
    }
    system_.closure_rows[c.row] = {{none, none}, {none, none}, g, rate};
    system_.rhs.closure[c.row] = S(-motion.acceleration);
  }
}

/// As moving_body(), into a lane. Always inlined: through memory it took a tenth of the kinematics of a ladder.
template <class S>
[[gnu::always_inline]] inline void Evaluator<S>::set_moving_body(MovingBody<B>& block, int lane, int body) const {
  const MovingBody<S> one = moving_body(body);
  set_lane<S>(block.axes, lane, one.axes), set_lane<S>(block.position, lane, one.position);
  set_lane<S>(block.twist.angular, lane, one.twist.angular), set_lane<S>(block.twist.linear, lane, one.twist.linear);
}

/// The rows of a block of closures, all at once.
template <class S>
void Evaluator<S>::close_side_by_side(const ClosureBlock& block) {
  if constexpr (lanes > 1) {
    const Closure* const closures = system_.model.closures().closures.data() + block.first;
    MovingBody<B>&a = ends_a_, &b = ends_b_;
    const int width = lanes, last = block.count - 1;
    for (int lane = 0; lane < width; ++lane) {
      set_moving_body(a, lane, closures[std::min(lane, last)].body_a);
      set_moving_body(b, lane, closures[std::min(lane, last)].body_b);
    }
    const auto store = [&](int k, const closure::Row<B>& row) {
      for (int lane = 0; lane <= last; ++lane) {
        const int at = closures[lane].row + k;
        system_.closure_rows[at] = {{lane_of<S>(row.a.moment, lane), lane_of<S>(row.a.force, lane)},
                                    {lane_of<S>(row.b.moment, lane), lane_of<S>(row.b.force, lane)},
                                    PackedScalar<S>::get(row.value, lane),
                                    PackedScalar<S>::get(row.rate, lane)};
        system_.rhs.closure[at] = PackedScalar<S>::get(row.bias, lane);
      }
    };
    const Closure& c = closures[0];
    const Conditions& conditions = c.conditions();
    if (conditions.only_along()) return closure::rows_of_points(conditions, block, a, b, store);
    const auto one = closure::frame_on(a, block.axes_a, block.point_a);
    const auto other = closure::frame_on(b, block.axes_b, block.point_b);
    const closure::Separation<B> from_a(one, other);
    for (int k = 0; k < conditions.count; ++k)
      store(k, closure::condition(conditions.rows[k], one, other, from_a, B(c.pitch), {c.length, 0, 0}));
  }
}

template <class S>
const System<S>& Evaluator<S>::stabilise(double alpha) {
  for (std::size_t k = 0; k < system_.closure_rows.size(); ++k)
    system_.rhs.closure[k] +=
        S(2 * alpha) * system_.closure_rows[k].rate + S(alpha * alpha) * system_.closure_rows[k].g;
  return system_;
}

template <class S>
Mat3<S> Evaluator<S>::body_rotation(int body) const {
  return rotation(body) * cast<S>(system_.model.body_axes(body));
}

/// One pass over the bodies, for what is asked for.
template <class S>
template <bool positions, bool twists>
[[gnu::always_inline]] inline void Evaluator<S>::move_bodies() {
  for (int i = 0; i < system_.model.bodies(); ++i) {
    const Link& link = system_.model.link(i);
    const Vec3<S>& r = system_.bodies[i].r;
    Vec3<S> position = r, linear{S(0.0), S(0.0), S(0.0)};
    if (link.parent != ground) {
      if constexpr (positions) position = positions_[link.parent] + r;
      if constexpr (twists) linear = moved_outward(r, twists_[link.parent]).linear;
    }
    if constexpr (positions) positions_[i] = position;
    if constexpr (!twists) continue;
    if (link.kind.traits().moves_origin) linear += origin_velocities_[i];
    twists_[i] = {angular_velocity(i), linear};
  }
}

template <class S>
const std::vector<Vec3<S>>& Evaluator<S>::positions() {
  move_bodies<true, false>();
  return positions_;
}

template <class S>
const std::vector<Motion<S>>& Evaluator<S>::twists() {
  move_bodies<false, true>();
  return twists_;
}

template class Evaluator<double>;
template class Evaluator<long double>;
template class Evaluator<Count>;
template class Evaluator<Dual<8>>;
template class Evaluator<NativePack>;

}  // namespace lanc
