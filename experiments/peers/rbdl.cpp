// RBDL: articulated-body algorithm and recursive inverse dynamics. Not in Debian: written from its documentation.
#include <rbdl/rbdl.h>

#include "experiments/peers/parts.h"
#include "experiments/peers/peer.h"

namespace lanc::peers {
namespace {

namespace rb = RigidBodyDynamics;

class Rbdl : public PeerModel {
 public:
  Rbdl(const Mechanism& mechanism, const std::vector<double>& vdot, Task task) : task_(task), ours_(mechanism.model) {
    require("rbdl", ours_, {"revolute", "prismatic", "free"});
    model_.gravity = eigen(ours_.gravity());
    for (const Link& link : ours_.links()) {
      const BodyMass body(link.inertia);
      ids_.push_back(model_.AddBody(link.parent == ground ? 0 : ids_[link.parent],
                                    rb::Math::SpatialTransform(eigen(link.X).transpose(), eigen(link.o)), joint(link),
                                    rb::Body(body.mass, body.com, body.inertia)));
    }
    q_.setZero(model_.q_size);
    v_.setZero(model_.qdot_size), found_.setZero(model_.qdot_size), given_.setZero(model_.qdot_size);
    int first = 0;
    for (int i = 0; i < ours_.bodies(); first += ours_.link(i).nv, ++i) {
      const Link& link = ours_.link(i);
      first_.push_back(first);
      if (link.nv == 1) {
        q_[first] = mechanism.state.q[link.q], v_[first] = mechanism.state.v[link.v];
        if (task_ == Task::inverse) given_[first] = vdot[link.v];
      } else {
        set_root(link, mechanism.state, vdot);
      }
    }
  }

  void call() override {
    if (task_ == Task::forward)
      rb::ForwardDynamics(model_, q_, v_, given_, found_);  // given: no torques
    else
      rb::InverseDynamics(model_, q_, v_, given_, found_);
  }
  std::vector<double> answer() override {
    call();
    std::vector<double> result(ours_.nv());
    for (int i = 0; i < ours_.bodies(); ++i) {
      const Link& link = ours_.link(i);
      const double* found = found_.data() + first_[i];
      double* own = result.data() + link.v;
      if (link.nv == 1) {
        *own = *found;
      } else if (task_ == Task::forward) {
        root_.from_world(root_.R * Eigen::Vector3d::Map(found + 3), frame_ * Eigen::Vector3d::Map(found), own);
      } else {
        Eigen::Vector3d::Map(own) = Eigen::Vector3d::Map(found + 3);
        Eigen::Vector3d::Map(own + 3) = root_.R.transpose() * (frame_ * Eigen::Vector3d::Map(found));
      }
    }
    return result;
  }

 private:
  static rb::Joint joint(const Link& link) {
    if (is(link, "revolute")) return rb::Joint(rb::JointTypeRevoluteZ);
    if (is(link, "free")) return rb::Joint(rb::JointTypeFloatingBase);
    return rb::Joint(rb::Math::SpatialVector(0, 0, 0, 0, 0, 1));
  }
  /// RBDL's floating base: position and velocity in axes of the joint's frame, then Euler parameters and angular
  /// velocity in body axes.
  void set_root(const Link& link, const State<double>& state, const std::vector<double>& vdot) {
    root_ = FreeRoot(ours_, state);
    frame_ = eigen(link.X);
    const double* q = state.q.data() + link.q;
    q_.head(3) = Eigen::Vector3d::Map(q);
    model_.SetQuaternion(ids_[0], rb::Math::Quaternion(q[4], q[5], q[6], q[3]), q_);
    v_.head(3) = frame_.transpose() * root_.linear;
    v_.segment(3, 3) = Eigen::Vector3d::Map(state.v.data() + link.v);
    if (task_ == Task::forward) return;
    Eigen::Vector3d alpha, a;
    root_.to_world(vdot.data() + link.v, alpha, a);
    given_.head(3) = frame_.transpose() * a;
    given_.segment(3, 3) = Eigen::Vector3d::Map(vdot.data() + link.v);
  }

  Task task_;
  Model ours_;
  rb::Model model_;
  std::vector<unsigned> ids_;
  std::vector<int> first_;  // velocity coordinate of RBDL by body
  FreeRoot root_;
  Eigen::Matrix3d frame_;
  rb::Math::VectorNd q_, v_, given_, found_;
};

template <Task task>
std::unique_ptr<PeerModel> build(const Mechanism& mechanism, const std::vector<double>& vdot) {
  return std::make_unique<Rbdl>(mechanism, vdot, task);
}

const PeerRegistration forward(
    {.name = "rbdl", .version = LANC_RBDL_VERSION, .computes = "ForwardDynamics", .build = build<Task::forward>});
const PeerRegistration inverse({.name = "rbdl",
                                .task = Task::inverse,
                                .version = LANC_RBDL_VERSION,
                                .computes = "InverseDynamics",
                                .build = build<Task::inverse>});

}  // namespace
}  // namespace lanc::peers
