// The recursive formulations beside Bullet's articulated-body algorithm, in turns, in one process.
#include <BulletDynamics/Featherstone/btMultiBody.h>
#include <fmt/format.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <memory>

#include "lib/model/error.h"
#include "lib/report/crossing.h"
#include "lib/report/experiment.h"
#include "lib/report/phases.h"
#include "lib/report/sidecar.h"

namespace {

using namespace lanc;
using Eigen::Matrix3d;
using Eigen::Vector3d;

Vector3d eigen(const Vec3<double>& a) { return {a.x, a.y, a.z}; }
Matrix3d eigen(const Mat3<double>& a) {
  Matrix3d m;
  m << eigen(a.x), eigen(a.y), eigen(a.z);
  return m;
}
btVector3 bullet(const Vector3d& a) { return {a.x(), a.y(), a.z()}; }

/// A link in Bullet's axes: origin at the centre of mass, axes along the principal axes of inertia.
struct PrincipalFrame {
  double mass;
  Vector3d com, moments;  // com in our joint axes
  Matrix3d axes;          // columns: principal axes in our joint axes

  explicit PrincipalFrame(const RigidInertia<double>& inertia) : mass(inertia.mass), com(eigen(inertia.h) / mass) {
    const Vector3d columns[] = {Vector3d::UnitX(), Vector3d::UnitY(), Vector3d::UnitZ()};
    Matrix3d about_com;
    for (int k = 0; k < 3; ++k) {
      const Vector3d& e = columns[k];
      about_com.col(k) = eigen(inertia.J * Vec3<double>{e.x(), e.y(), e.z()}) - mass * com.cross(e.cross(com));
    }
    const Eigen::SelfAdjointEigenSolver<Matrix3d> principal(about_com);
    moments = principal.eigenvalues();
    axes = principal.eigenvectors();
    if (axes.determinant() < 0) axes.col(0) *= -1;
  }
};

/// Bullet's multibody of a model of revolute joints without springs, drives and armature. Throws InputError for others.
class Bullet {
 public:
  Bullet(const Model& model, const State<double>& state) : model_(model), state_(state) {
    for (const Link& link : model.links())
      if (link.kind.traits().name != "revolute" || link.drive >= 0)
        throw InputError("this comparison knows revolute joints only; choose chain:N or tree:N");
    if (model.has_armature() || !model.passive().empty() || !model.springs().empty() || !model.wrenches().empty())
      throw InputError("this comparison knows no springs, friction, armature or constant wrenches");
    body_ = std::make_unique<btMultiBody>(model.bodies(), 0.0, btVector3(0, 0, 0), true, false);
    std::vector<PrincipalFrame> frames;
    for (int i = 0; i < model.bodies(); ++i) {
      const Link& link = model.link(i);
      frames.emplace_back(link.inertia);
      const PrincipalFrame& frame = frames.back();
      Matrix3d parent_axes = Matrix3d::Identity();
      Vector3d parent_com = Vector3d::Zero();
      if (link.parent != ground) parent_axes = frames[link.parent].axes, parent_com = frames[link.parent].com;
      // parent's principal axes -> this one's, at zero angle
      const Eigen::Quaterniond turn(Matrix3d((parent_axes.transpose() * eigen(link.X) * frame.axes).transpose()));
      body_->setupRevolute(i, frame.mass, bullet(frame.moments), link.parent,
                           btQuaternion(turn.x(), turn.y(), turn.z(), turn.w()),
                           bullet(frame.axes.transpose() * Vector3d::UnitZ()),
                           bullet(parent_axes.transpose() * (eigen(link.o) - parent_com)),
                           bullet(frame.axes.transpose() * frame.com), true);
    }
    body_->finalizeMultiDof();
    body_->setLinearDamping(0);
    body_->setAngularDamping(0);
    body_->setMaxCoordinateVelocity(1e30);
    set_positions();
    set_velocities();
    for (int i = 0; i < model.bodies(); ++i) body_->addLinkForce(i, bullet(eigen(model.link(i).weight)));
  }

  void set_positions() {
    for (int i = 0; i < model_.bodies(); ++i) body_->setJointPos(i, state_.q[model_.link(i).q]);
  }
  /// Velocities grow by η̇ dt.
  void solve(double dt) {
    body_->computeAccelerationsArticulatedBodyAlgorithmMultiDof(dt, reals_, vectors_, matrices_, false, false, false);
  }
  std::vector<double> accelerations() {
    set_velocities();
    solve(1);
    std::vector<double> vdot(model_.nv());
    for (int i = 0; i < model_.bodies(); ++i)
      vdot[model_.link(i).v] = body_->getJointVel(i) - state_.v[model_.link(i).v];
    set_velocities();
    return vdot;
  }

 private:
  void set_velocities() {
    for (int i = 0; i < model_.bodies(); ++i) body_->setJointVel(i, state_.v[model_.link(i).v]);
  }

  Model model_;
  State<double> state_;
  std::unique_ptr<btMultiBody> body_;
  btAlignedObjectArray<btScalar> reals_;
  btAlignedObjectArray<btVector3> vectors_;
  btAlignedObjectArray<btMatrix3x3> matrices_;
};

/// Largest difference relative to the largest value.
double difference(const std::vector<double>& a, const std::vector<double>& b) {
  double worst = 0, size = 0;
  for (std::size_t k = 0; k < a.size(); ++k) {
    worst = std::max(worst, std::abs(a[k] - b[k]));
    size = std::max(size, std::abs(b[k]));
  }
  return worst / size;
}

void compare(Experiment& experiment, const std::string& name, const FormulationInfo& info, std::FILE* out) {
  constexpr double same = 1e-8;
  const Mechanism mechanism = experiment.load(name);
  PhaseTimer ours(info.create_double, mechanism.model, mechanism.state);
  Bullet peer(mechanism.model, mechanism.state);
  const double apart = difference(peer.accelerations(), ours.solution().vdot);
  fmt::print(out, "{}, {}: accelerations differ by {:.1e} of the largest\n", name, info.name, apart);
  if (!(apart < same))
    throw InputError(fmt::format("Bullet solves another model than {} (difference {:.1e}); not timed", name, apart));

  std::vector<double> our_times, peer_times, peer_solves;
  Repeat total, solve;
  for (int r = 0; r < experiment.options().repetitions; ++r) {
    const auto rows = ours.repetition();
    our_times.push_back(rows.back().value);
    peer_times.push_back(total.seconds([&] {
      peer.set_positions();
      peer.solve(0);
    }));
    peer_solves.push_back(solve.seconds([&] { peer.solve(0); }));
    Report& report = experiment.report();
    report.write(experiment.cell(name, mechanism.model, std::string(info.name), {}, r), rows);
    report.write(experiment.cell(name, mechanism.model, "bullet", fmt::format("beside={}", info.name), r),
                 std::vector<Measurement>{{"solve", "time", peer_solves.back(), "s"},
                                          {"total", "time", peer_times.back(), "s"}});
  }
  const double mine = median(our_times), theirs = median(peer_times), solved = median(peer_solves);
  fmt::print(out, "  {:<10} {:8.3f} µs  kinematics and all outputs\n", info.name, 1e6 * mine);
  fmt::print(out, "  {:<10} {:8.3f} µs  with joint positions set; {:.3f} µs without\n", "Bullet", 1e6 * theirs,
             1e6 * solved);
  fmt::print(out, "  ratio {:.3f} (to Bullet without setting positions {:.3f})\n", mine / theirs, mine / solved);
}

}  // namespace

int main(int argc, char** argv) {
  Experiment experiment({.name = "bullet",
                         .question = "What does the recursion take, relative to Bullet's btMultiBody?",
                         .repetitions = 51,
                         .quick_repetitions = 11,
                         .models = [](bool) { return std::vector<std::string>{"chain:32"}; },
                         .formulations = [](const FormulationInfo& info) { return info.recursive; }});
  return experiment.run(argc, argv, [](Experiment& e) {
    std::FILE* out = e.options().out == "-" ? stderr : stdout;
    for (const std::string& model : e.models())
      for (const FormulationInfo* info : e.formulations()) compare(e, model, *info, out);
    const BuildInfo build = build_info();
    fmt::print(out, "ours: {}, {}\nBullet {}: as packaged, double precision\nprocessor: {}\n", build.compiler,
               build.flags, LANC_BULLET_VERSION, processor());
  });
}
