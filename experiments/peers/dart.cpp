// DART: articulated-body algorithm and inverse dynamics of a skeleton.
#include <dart/config.hpp>
#include <dart/dynamics/BallJoint.hpp>
#include <dart/dynamics/FreeJoint.hpp>
#include <dart/dynamics/PrismaticJoint.hpp>
#include <dart/dynamics/RevoluteJoint.hpp>
#include <dart/dynamics/Skeleton.hpp>
#include <dart/dynamics/WeldJoint.hpp>

#include <fmt/format.h>

#include "experiments/peers/parts.h"
#include "experiments/peers/peer.h"

namespace lanc::peers {
namespace {

namespace dd = dart::dynamics;

/// DART's velocities of free and spherical joints are ours: components in axes of the body, angular part first.
class Dart : public PeerModel {
 public:
  Dart(const Mechanism& mechanism, const std::vector<double>& vdot, Task task)
      : task_(task), skeleton_(dd::Skeleton::create("lanc")) {
    const Model& model = mechanism.model;
    require("dart", model, {"revolute", "prismatic", "fixed", "free", "spherical"});
    skeleton_->setGravity(eigen(model.gravity()));
    skeleton_->disableSelfCollisionCheck();
    for (const Link& link : model.links()) add(link);
    q_.setZero(model.nv());
    v_.setZero(model.nv());
    given_.setZero(model.nv());
    index_.resize(model.nv());
    for (int i = 0; i < model.bodies(); ++i) {
      const Link& link = model.link(i);
      const dd::Joint* joint = bodies_[i]->getParentJoint();
      const Eigen::VectorXd positions = joint_positions(link, mechanism.state);
      for (int k = 0; k < link.nv; ++k) {
        const auto own = static_cast<Eigen::Index>(joint->getIndexInSkeleton(k));
        index_[link.v + k] = own;
        q_[own] = positions[k];
        v_[own] = mechanism.state.v[link.v + k];
        given_[own] = vdot[link.v + k];
      }
    }
  }

  void call() override {
    skeleton_->setPositions(q_);
    skeleton_->setVelocities(v_);
    if (task_ == Task::forward) return skeleton_->computeForwardDynamics();
    skeleton_->setAccelerations(given_);
    skeleton_->computeInverseDynamics();
  }
  std::vector<double> answer() override {
    call();
    const Eigen::VectorXd found = task_ == Task::forward ? skeleton_->getAccelerations() : skeleton_->getForces();
    if (task_ == Task::inverse) skeleton_->resetGeneralizedForces();
    std::vector<double> result;
    for (const Eigen::Index own : index_) result.push_back(found[own]);
    return result;
  }

 private:
  /// The fields that all kinds of joints have.
  template <class Joint>
  static typename Joint::Properties placed(const Link& link, int body) {
    typename Joint::Properties properties;
    properties.mName = fmt::format("j{}", body);
    properties.mT_ParentBodyToJoint.linear() = eigen(link.X);
    properties.mT_ParentBodyToJoint.translation() = eigen(link.o);
    if constexpr (std::is_base_of_v<dd::RevoluteJoint, Joint> || std::is_base_of_v<dd::PrismaticJoint, Joint>)
      properties.mAxis = Eigen::Vector3d::UnitZ();
    return properties;
  }
  template <class Joint>
  dd::BodyNode* create(const Link& link, const dd::BodyNode::AspectProperties& body) {
    dd::BodyNode* parent = link.parent == ground ? nullptr : bodies_[link.parent];
    const auto own = static_cast<int>(bodies_.size());
    return skeleton_
        ->createJointAndBodyNodePair<Joint>(parent, placed<Joint>(link, own), dd::BodyNode::Properties(body))
        .second;
  }
  void add(const Link& link) {
    const BodyMass mass(link.inertia);
    dd::BodyNode::AspectProperties body(fmt::format("b{}", bodies_.size()),
                                        dd::Inertia(mass.mass, mass.com, mass.inertia));
    bodies_.push_back(is(link, "revolute")    ? create<dd::RevoluteJoint>(link, body)
                      : is(link, "prismatic") ? create<dd::PrismaticJoint>(link, body)
                      : is(link, "spherical") ? create<dd::BallJoint>(link, body)
                      : is(link, "free")      ? create<dd::FreeJoint>(link, body)
                                              : create<dd::WeldJoint>(link, body));
  }
  static Eigen::VectorXd joint_positions(const Link& link, const State<double>& state) {
    const double* q = state.q.data() + link.q;
    if (is(link, "spherical")) return dd::BallJoint::convertToPositions(quaternion(q).toRotationMatrix());
    if (!is(link, "free")) return Eigen::VectorXd::Map(q, link.nq);
    Eigen::Isometry3d pose(quaternion(q + 3));
    pose.translation() = Eigen::Vector3d(q[0], q[1], q[2]);
    return dd::FreeJoint::convertToPositions(pose);
  }

  Task task_;
  dd::SkeletonPtr skeleton_;
  std::vector<dd::BodyNode*> bodies_;
  std::vector<Eigen::Index> index_;  // of our velocity coordinate in DART
  Eigen::VectorXd q_, v_, given_;
};

template <Task task>
std::unique_ptr<PeerModel> build(const Mechanism& mechanism, const std::vector<double>& vdot) {
  return std::make_unique<Dart>(mechanism, vdot, task);
}

const PeerRegistration forward({.name = "dart",
                                .version = DART_VERSION,
                                .computes = "Skeleton: positions and velocities set, computeForwardDynamics "
                                            "(articulated-body algorithm)",
                                .build = build<Task::forward>});
const PeerRegistration inverse({.name = "dart",
                                .task = Task::inverse,
                                .version = DART_VERSION,
                                .computes = "Skeleton: positions, velocities and accelerations set, "
                                            "computeInverseDynamics",
                                .build = build<Task::inverse>});

}  // namespace
}  // namespace lanc::peers
