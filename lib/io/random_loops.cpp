#include "lib/io/random_loops.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "lib/closure/assembly.h"
#include "lib/closure/scaling.h"
#include "lib/io/draw_space.h"
#include "lib/model/validate.h"
#include "lib/spatial/eigen.h"
#include "lib/system/closure_jacobian.h"
#include "lib/system/evaluator.h"

namespace lanc {
namespace {

constexpr double clearly_independent = 0.05, clearly_dependent = 1e-9;  // of a row's length
constexpr int tries_per_loop = 200, tries_per_mechanism = 50;

/// World axes and origin of a frame.
struct Pose {
  Mat3<double> axes;
  Vec3<double> origin;
};

/// Where frame B stands when a joint of that kind between A and B has the coordinates q.
Pose moved_by_joint(JointKind kind, const Pose& A, double pitch, const double* q) {
  static constexpr auto movers = for_each_joint_kind([]<class Joint>() {
    return +[](const double* q, JointStep<double>& step) {
      const double v[6] = {};
      Motion<double> C[6];
      Joint::move(q, turns_of<Joint>(q).data(), v, step, C);
    };
  });
  JointStep<double> step{.F = A.axes, .pitch = pitch};
  movers[kind.index](q, step);
  return {step.R, kind.traits().moves_origin ? A.origin + step.displacement : A.origin};
}

/// One attempt at a mechanism; failed() when a loop did not fit.
class RandomLoops {
 public:
  RandomLoops(const RandomLoopsOptions& options, const ModelSpec& frame, Draw& draw) : options_(options), draw_(draw) {
    choose_causes();
    RandomTreeOptions tree = options.tree;
    tree.bodies = 4 * static_cast<int>(std::count(causes_.begin(), causes_.end(), RedundancyCause::none)) + 2;
    spec_ = random_tree(tree, draw);
    spec_.name = frame.name;
    spec_.gravity = frame.gravity;
    tree_bodies_ = static_cast<int>(spec_.bodies.size());
    for (unsigned char k = 0; k < closures::all_closures.size(); ++k) {
      const ClosureTraits& traits = ClosureKind{k}.traits();
      const auto& kinds = options.tree.kinds;
      if (!traits.joint || std::find(kinds.begin(), kinds.end(), *traits.joint) != kinds.end())
        closure_kinds_.push_back({k});
    }
  }

  std::optional<Mechanism> mechanism() {
    for (const RedundancyCause cause : causes_) {
      if (cause == RedundancyCause::parallel) add_planar();
      if (cause == RedundancyCause::bennett) add_bennett();
    }
    const Model tree = Model::build(spec_);
    state_ = draw_state(tree, draw_);
    for (const auto& [body, angle] : angles_) state_.q[tree.link(body).q] = angle;
    Evaluator<double> evaluator(tree);
    evaluator.system(state_);
    for (int i = 0; i < tree.bodies(); ++i) poses_.push_back({evaluator.body_rotation(i), evaluator.positions()[i]});
    for (ClosureSpec& c : half_open_)
      if (!close_special(c)) return std::nullopt;
    for (const RedundancyCause cause : causes_)
      if (cause == RedundancyCause::none && !add_generic(tree)) return std::nullopt;
    if (duplicates_) duplicate();
    return finished(tree);
  }

 private:
  void choose_causes() {
    using enum RedundancyCause;
    for (int k = 0; k < options_.loops; ++k) {
      RedundancyCause cause = none;
      if (options_.cause == any)
        cause = draw_.chance(0.6) ? none : draw_.chance(0.5) ? parallel : bennett;
      else if (k == 0 && (options_.cause == parallel || options_.cause == bennett))
        cause = options_.cause;
      causes_.push_back(cause);
    }
    duplicates_ = options_.cause == duplicate || (options_.cause == any && draw_.chance(0.15));
  }

  std::string name_of(int body) const { return body == ground ? std::string() : spec_.bodies[body].name; }
  int draw_tree_body_or_ground() {
    const int k = draw_.index(tree_bodies_ + 1);
    return k == tree_bodies_ ? ground : k;
  }
  Pose pose(int body) const { return body == ground ? Pose{identity3<double>(), {0, 0, 0}} : poses_[body]; }
  int index_of(const std::string& name) const {
    for (int i = 0; i < static_cast<int>(spec_.bodies.size()); ++i)
      if (spec_.bodies[i].name == name) return i;
    return ground;
  }

  /// A hinge and a body on it; returns the joint, whose frame and axis are the caller's.
  JointSpec& add_hinge(std::string parent) {
    const std::string number = std::to_string(spec_.bodies.size() + 1);
    BodySpec body = draw_body(draw_);
    body.name = "b" + number;
    spec_.bodies.push_back(std::move(body));
    JointSpec joint;
    joint.name = "j" + number;
    joint.kind = *find_joint_kind("revolute");
    joint.parent = std::move(parent);
    joint.body = spec_.bodies.back().name;
    spec_.joints.push_back(std::move(joint));
    return spec_.joints.back();
  }

  ClosureSpec& begin_closing_hinge(const std::string& base) {
    ClosureSpec c;
    c.kind = *find_closure_kind("revolute");
    c.body_a = spec_.bodies.back().name;
    c.body_b = base;
    half_open_.push_back(std::move(c));
    return half_open_.back();
  }

  /// Three or four bodies on parallel hinges, back to their base.
  void add_planar() {
    const std::string base = name_of(draw_tree_body_or_ground());
    const Eigen::Vector3d axis = draw_direction(draw_);
    std::string parent = base;
    for (int k = 3 + draw_.index(2); k > 0; --k) {
      JointSpec& joint = add_hinge(parent);
      joint.axis = axis;
      joint.frame.position = draw_vector(draw_, 0.3);
      parent = joint.body;
    }
    ClosureSpec& c = begin_closing_hinge(base);
    c.axis = axis;
    c.frame_a.position = draw_vector(draw_, 0.3);
  }

  /// Bennett's linkage in Denavit-Hartenberg parameters: lengths a, b, a, b, twists α, β, α, β, a / sin α = b / sin β,
  /// θ3 = −θ1, tan(θ1/2) tan(θ2/2) = (tan(β/2) + tan(α/2)) / (tan(β/2) − tan(α/2)).
  void add_bennett() {
    const std::string base = name_of(draw_tree_body_or_ground());
    const double ka = draw_.between(0.2, 0.4), kb = draw_.between(0.5, 0.7);  // tan of half the twists
    const auto sine = [](double k) { return 2 * k / (1 + k * k); };
    const auto twist = [&](double k) {
      Eigen::Matrix3d R = Eigen::Matrix3d::Identity();
      R(1, 1) = R(2, 2) = (1 - k * k) / (1 + k * k);
      R(2, 1) = sine(k), R(1, 2) = -sine(k);
      return R;
    };
    const double a = draw_.between(0.2, 0.4), b = a * sine(kb) / sine(ka);
    double angle = draw_.between(0.5, 2.5);
    if (draw_.chance(0.5)) angle = -angle;
    JointSpec& first = add_hinge(base);
    first.frame.rotation = draw_rotation(draw_);
    first.frame.position = draw_vector(draw_, 0.3);
    angles_.push_back({static_cast<int>(spec_.bodies.size()) - 1, angle});
    const double second_angle = 2 * std::atan((kb + ka) / ((kb - ka) * std::tan(angle / 2)));
    JointSpec& second = add_hinge(spec_.bodies.back().name);
    second.frame = {twist(ka), {a, 0, 0}};
    angles_.push_back({static_cast<int>(spec_.bodies.size()) - 1, second_angle});
    JointSpec& third = add_hinge(spec_.bodies.back().name);
    third.frame = {twist(kb), {b, 0, 0}};
    angles_.push_back({static_cast<int>(spec_.bodies.size()) - 1, -angle});
    begin_closing_hinge(base).frame_a = {twist(ka), {a, 0, 0}};
  }

  Pose frame_a_of(const ClosureSpec& c) const {
    const Pose body = pose(index_of(c.body_a));
    return {body.axes * (from_eigen(c.frame_a.rotation) * from_eigen(closure_axes(c))),
            body.origin + body.axes * from_eigen(c.frame_a.position)};
  }

  /// Puts frame B on its body where it now is in the world.
  void place_b(ClosureSpec& c, const Pose& B) const {
    const Pose body = pose(index_of(c.body_b));
    const Mat3<double> axes = transposed(from_eigen(closure_axes(c)));
    c.frame_b.rotation = to_eigen(transposed(body.axes) * (B.axes * axes));
    c.frame_b.position = to_eigen(transpose_times(body.axes, B.origin - body.origin));
  }

  bool close_special(ClosureSpec& c) {
    c.name = "l" + std::to_string(spec_.closures.size() + 1);
    place_b(c, frame_a_of(c));
    if (c.axis) c.frame_b.rotation.setIdentity();  // planar: the same numbers make axes exactly parallel
    return add_rows(c, false) && (spec_.closures.push_back(c), true);
  }

  bool add_generic(const Model& tree) {
    for (int attempt = 0; attempt < tries_per_loop; ++attempt) {
      const int a = draw_tree_body_or_ground(), b = draw_tree_body_or_ground();
      const ClosureKind kind = closure_kinds_[draw_.index(static_cast<int>(closure_kinds_.size()))];
      const bool driven = options_.tree.driven && kind.traits().can_be_driven() && draw_.chance(0.3);
      if (a == b) continue;
      ClosureSpec c = generic(kind, name_of(a), name_of(b), driven);
      const int rows = driven && !kind.traits().has_length ? 6 : kind.traits().conditions.count;
      if (static_cast<int>(basis_.size()) + rows >= tree.nv() || !add_rows(c, true)) continue;
      spec_.closures.push_back(std::move(c));
      return true;
    }
    return false;
  }

  ClosureSpec generic(ClosureKind kind, std::string a, std::string b, bool driven) {
    const ClosureTraits& traits = kind.traits();
    ClosureSpec c;
    c.name = "l" + std::to_string(spec_.closures.size() + 1);
    c.kind = kind;
    c.body_a = std::move(a), c.body_b = std::move(b);
    c.frame_a.rotation = draw_rotation(draw_);
    c.frame_a.position = draw_vector(draw_, 0.3);
    if (traits.axes != JointAxes::none) c.axis = draw_direction(draw_);
    if (traits.axes == JointAxes::two) c.axis2 = draw_perpendicular(draw_, *c.axis);
    if (traits.has_pitch) c.pitch = draw_.between(0.02, 0.2);
    if (driven && !traits.has_length) c.motion = draw_motion(draw_);
    const Pose A = frame_a_of(c);
    place_b(c, traits.joint ? beyond_joint(*traits.joint, A, c) : beyond_own(A, c));
    if (traits.has_length) {
      const Pose body = pose(index_of(c.body_b));
      const Vec3<double> d = body.origin + body.axes * from_eigen(c.frame_b.position) - A.origin;
      const double length = std::sqrt(dot(d, d));
      if (driven)
        c.motion = Sine{length, draw_.between(-0.1, 0.1), draw_.between(1, 3), 0};
      else
        c.length = length;
    }
    return c;
  }

  Pose beyond_joint(JointKind kind, const Pose& A, const ClosureSpec& c) {
    const JointTraits& traits = kind.traits();
    double q[7] = {};
    for (int k = 0; k < traits.nq; ++k) q[k] = draw_.between(-1, 1);
    if (traits.quaternion >= 0) draw_.direction(q + traits.quaternion, 4);
    if (c.motion) q[0] = PrescribedMotion::create(*c.motion)->at(0).position;
    return moved_by_joint(kind, A, c.pitch, q);
  }

  /// Closures that are no joints: what they leave free is drawn.
  Pose beyond_own(const Pose& A, const ClosureSpec& c) {
    const Conditions& conditions = c.kind.traits().conditions;
    const auto has = [&](ConditionKind kind, int i) {
      return std::any_of(conditions.rows.begin(), conditions.rows.begin() + conditions.count,
                         [&](const Condition& row) { return row.kind == kind && row.i == i; });
    };
    Pose B = A;
    if (!has(ConditionKind::turn, 0)) B.axes = A.axes * from_eigen(draw_rotation(draw_));
    const Eigen::Vector3d direction = draw_direction(draw_);
    const double distance = draw_.between(0.2, 0.6);
    const Vec3<double> axes[3] = {A.axes.x, A.axes.y, A.axes.z};
    for (int i = 0; i < 3; ++i)
      if (!has(ConditionKind::along, i)) B.origin += axes[i] * (direction[i] * distance);
    return B;
  }

  /// Adds the closure's rows to the basis of all rows when they are what they are meant to be.
  bool add_rows(const ClosureSpec& c, bool independent) {
    ModelSpec alone = spec_;
    alone.closures = {c};
    const Model model = Model::build(std::move(alone));
    Evaluator<double> evaluator(model);
    ClosureJacobian<double> jacobian(model);
    jacobian.evaluate(evaluator.system(state_));
    const ClosureScaling scaling(model);
    const std::size_t before = basis_.size();
    for (int k = 0; k < jacobian.rows(); ++k) {
      std::vector<double> row(model.nv(), 0.0);
      for (int p = jacobian.starts()[k]; p < jacobian.starts()[k + 1]; ++p)
        row[jacobian.columns()[p]] = jacobian.values()[p] * scaling.row[k] * scaling.column[jacobian.columns()[p]];
      const double size = norm(row), left = remove_basis(row);
      if (!independent && left <= clearly_dependent * std::max(size, 1.0)) continue;
      if (!(left > clearly_independent * std::max(size, 1.0))) {
        basis_.resize(before);
        return false;
      }
      for (double& x : row) x /= left;
      basis_.push_back(std::move(row));
    }
    return true;
  }

  static double norm(const std::vector<double>& x) {
    double square = 0;
    for (const double value : x) square += value * value;
    return std::sqrt(square);
  }
  double remove_basis(std::vector<double>& row) const {
    for (int twice = 0; twice < 2; ++twice)
      for (const std::vector<double>& b : basis_) {
        double along = 0;
        for (std::size_t k = 0; k < row.size(); ++k) along += b[k] * row[k];
        if (along != 0)
          for (std::size_t k = 0; k < row.size(); ++k) row[k] -= along * b[k];
      }
    return norm(row);
  }

  /// One closure once more, or the points of it.
  void duplicate() {
    ClosureSpec c = spec_.closures[draw_.index(static_cast<int>(spec_.closures.size()))];
    c.name = "d_" + c.name;
    const Conditions& conditions = c.kind.traits().conditions;
    const bool point = std::count_if(conditions.rows.begin(), conditions.rows.begin() + conditions.count,
                                     [](const Condition& r) { return r.kind == ConditionKind::along; }) == 3;
    if (draw_.chance(0.5) && point && !c.motion) {
      c.kind = *find_closure_kind("point-on-point");
      c.axis.reset(), c.axis2.reset();
    }
    spec_.closures.push_back(std::move(c));
  }

  std::optional<Mechanism> finished(const Model& tree) {
    constexpr double fastest = 30;  // scaled: beyond it the drawn velocities were nearly impossible ones
    if (static_cast<int>(basis_.size()) >= tree.nv()) return std::nullopt;
    const Model model = Model::build(std::move(spec_));
    VelocityResult velocities = consistent_velocities(model, std::move(state_));
    if (!velocities.consistent || velocities.violation > 1e-14 || velocities.changed > fastest) return std::nullopt;
    return Mechanism{model, std::move(velocities.state)};
  }

  const RandomLoopsOptions& options_;
  Draw& draw_;
  ModelSpec spec_;
  int tree_bodies_ = 0;
  bool duplicates_ = false;
  std::vector<RedundancyCause> causes_;  // one per loop
  std::vector<ClosureKind> closure_kinds_;
  std::vector<ClosureSpec> half_open_;          // closures of sub-loops, without frame B
  std::vector<std::pair<int, double>> angles_;  // of bodies on hinges whose angle is not free
  State<double> state_;
  std::vector<Pose> poses_;                 // of the user's body axes
  std::vector<std::vector<double>> basis_;  // orthonormal, of the scaled rows so far
};

}  // namespace

Mechanism random_loops(const RandomLoopsOptions& options, const ModelSpec& frame, Draw& draw) {
  for (int attempt = 0; attempt < tries_per_mechanism; ++attempt)
    if (auto mechanism = RandomLoops(options, frame, draw).mechanism()) return *std::move(mechanism);
  throw InputError(fmt::format("model '{}': the joints leave too few freedoms for {} loops; give kinds that move more",
                               frame.name, options.loops));
}

}  // namespace lanc
