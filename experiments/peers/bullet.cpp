// Bullet's btMultiBody: articulated-body algorithm, double precision.
#include <BulletDynamics/Featherstone/btMultiBody.h>

#include "experiments/peers/parts.h"
#include "experiments/peers/peer.h"

namespace lanc::peers {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

btVector3 bullet(const Vector3d& a) { return {a.x(), a.y(), a.z()}; }
Vector3d from_bullet(const btVector3& a) { return {a.x(), a.y(), a.z()}; }
btQuaternion bullet_turn(const Matrix3d& R) {
  const Eigen::Quaterniond q(R);
  return {q.x(), q.y(), q.z(), q.w()};
}

class Bullet : public PeerModel {
 public:
  Bullet(const Mechanism& mechanism, const std::vector<double>&) : model_(mechanism.model) {
    require("bullet", model_, {"revolute", "prismatic", "fixed", "free"});
    floating_ = has_free_root(model_);
    if (floating_) root_ = FreeRoot(model_, mechanism.state);
    for (const Link& link : model_.links()) frames_.push_back(BodyMass(link.inertia).principal_frame());
    const BodyMass base(model_.link(0).inertia);
    body_ = std::make_unique<btMultiBody>(model_.bodies() - floating_, floating_ ? base.mass : 0.0,
                                          bullet(floating_ ? frames_[0].moments : Vector3d::Zero()), !floating_, false);
    for (int i = floating_; i < model_.bodies(); ++i) add(i);
    body_->finalizeMultiDof();
    body_->setLinearDamping(0);
    body_->setAngularDamping(0);
    body_->setMaxCoordinateVelocity(1e30);
    if (floating_) set_base();
    for (int i = floating_; i < model_.bodies(); ++i) {
      const Link& link = model_.link(i);
      body_->addLinkForce(i - floating_, bullet(eigen(link.weight)));
      if (link.nv == 1)
        coordinates_.push_back({i - floating_, link.v, mechanism.state.q[link.q], mechanism.state.v[link.v]});
    }
  }

  void call() override {
    set_state();
    solve(0);
  }

  /// Velocities grow by η̇ in a step of one second.
  std::vector<double> answer() override {
    set_state();
    solve(1);
    std::vector<double> vdot(model_.nv());
    for (const Coordinate& c : coordinates_) vdot[c.index] = body_->getJointVel(c.link) - c.v;
    if (floating_) {
      // Bullet's base velocity is that of the centre of mass, c from the reference point
      const Vector3d alpha = from_bullet(body_->getBaseOmega()) - root_.angular, c = root_.R * frames_[0].com;
      const Vector3d a = from_bullet(body_->getBaseVel()) - from_bullet(base_linear_);
      root_.from_world(alpha, a - alpha.cross(c) - root_.angular.cross(root_.angular.cross(c)), vdot.data());
    }
    return vdot;
  }

 private:
  void add(int i) {
    const Link& link = model_.link(i);
    const PrincipalFrame& frame = frames_[i];
    const PrincipalFrame parent = link.parent == ground ? PrincipalFrame() : frames_[link.parent];
    const BodyMass body(link.inertia);
    const int own = i - floating_, before = link.parent == ground ? -1 : link.parent - floating_;
    // parent's principal axes -> this one's, at zero position
    const btQuaternion turn = bullet_turn((parent.axes.transpose() * eigen(link.X) * frame.axes).transpose());
    const btVector3 axis = bullet(frame.axes.transpose() * Vector3d::UnitZ());
    const btVector3 to_joint = bullet(parent.axes.transpose() * (eigen(link.o) - parent.com));
    const btVector3 to_com = bullet(frame.axes.transpose() * frame.com), moments = bullet(frame.moments);
    if (is(link, "revolute"))
      body_->setupRevolute(own, body.mass, moments, before, turn, axis, to_joint, to_com, true);
    else if (is(link, "prismatic"))
      body_->setupPrismatic(own, body.mass, moments, before, turn, axis, to_joint, to_com, true);
    else
      body_->setupFixed(own, body.mass, moments, before, turn, to_joint, to_com, true);
  }
  void set_base() {
    const Vector3d c = root_.R * frames_[0].com;
    base_position_ = bullet(root_.position + c);
    base_turn_ = bullet_turn((root_.R * frames_[0].axes).transpose());
    base_angular_ = bullet(root_.angular);
    base_linear_ = bullet(root_.linear + root_.angular.cross(c));
    body_->addBaseForce(bullet(eigen(model_.link(0).weight)));
  }
  void set_state() {
    if (floating_) {
      body_->setBasePos(base_position_);
      body_->setWorldToBaseRot(base_turn_);
      body_->setBaseOmega(base_angular_);
      body_->setBaseVel(base_linear_);
    }
    for (const Coordinate& c : coordinates_) {
      body_->setJointPos(c.link, c.q);
      body_->setJointVel(c.link, c.v);
    }
  }
  void solve(double dt) {
    body_->computeAccelerationsArticulatedBodyAlgorithmMultiDof(dt, reals_, vectors_, matrices_, false, false, false);
  }

  Model model_;
  int floating_ = 0;                    // 1: the first body is Bullet's base, and links count from the second
  std::vector<PrincipalFrame> frames_;  // Bullet's own: origin at the centre of mass, principal axes
  struct Coordinate {
    int link, index;  // Bullet's, ours
    double q, v;
  };
  std::vector<Coordinate> coordinates_;
  FreeRoot root_;
  btVector3 base_position_, base_angular_, base_linear_;
  btQuaternion base_turn_;
  std::unique_ptr<btMultiBody> body_;
  btAlignedObjectArray<btScalar> reals_;
  btAlignedObjectArray<btVector3> vectors_;
  btAlignedObjectArray<btMatrix3x3> matrices_;
};

const PeerRegistration registration({.name = "bullet",
                                     .version = LANC_BULLET_VERSION,
                                     .computes = "btMultiBody with its positions and velocities set, articulated-body "
                                                 "algorithm in double precision; no joint wrenches",
                                     .build = [](const Mechanism& m, const std::vector<double>& vdot)
                                         -> std::unique_ptr<PeerModel> { return std::make_unique<Bullet>(m, vdot); }});

}  // namespace
}  // namespace lanc::peers
