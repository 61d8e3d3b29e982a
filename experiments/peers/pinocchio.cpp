// Pinocchio: articulated-body algorithm and recursive inverse dynamics. Not in Debian: written from its documentation.
#include <fmt/format.h>

#include <pinocchio/algorithm/aba.hpp>
#include <pinocchio/algorithm/rnea.hpp>
#include <pinocchio/config.hpp>
#include <pinocchio/multibody/data.hpp>
#include <pinocchio/multibody/model.hpp>

#include "experiments/peers/parts.h"
#include "experiments/peers/peer.h"

namespace lanc::peers {
namespace {

class Pinocchio : public PeerModel {
 public:
  Pinocchio(const Mechanism& mechanism, const std::vector<double>& vdot, Task task)
      : task_(task), ours_(mechanism.model), model_(made(ours_)), data_(model_) {
    q_.setZero(model_.nq), v_.setZero(model_.nv), tau_.setZero(model_.nv), given_.setZero(model_.nv);
    for (int i = 0; i < ours_.bodies(); ++i) {
      const Link& link = ours_.link(i);
      const double *q = mechanism.state.q.data() + link.q, *v = mechanism.state.v.data() + link.v;
      const auto at = model_.idx_qs[i + 1];
      if (link.nv == 1) {
        q_[at] = *q;
      } else {  // position, then Euler parameters with w last
        const double pose[] = {q[0], q[1], q[2], q[4], q[5], q[6], q[3]};
        std::copy_n(pose, 7, q_.data() + at);
      }
      for (int k = 0; k < link.nv; ++k) v_[index(i, k)] = v[k], given_[index(i, k)] = vdot[link.v + k];
    }
  }

  void call() override {
    if (task_ == Task::forward)
      pinocchio::aba(model_, data_, q_, v_, tau_);
    else
      pinocchio::rnea(model_, data_, q_, v_, given_);
  }
  std::vector<double> answer() override {
    call();
    const Eigen::VectorXd& found = task_ == Task::forward ? data_.ddq : data_.tau;
    std::vector<double> result(ours_.nv());
    for (int i = 0; i < ours_.bodies(); ++i)
      for (int k = 0; k < ours_.link(i).nv; ++k) result[ours_.link(i).v + k] = found[index(i, k)];
    return result;
  }

 private:
  static pinocchio::Model made(const Model& ours) {
    require("pinocchio", ours, {"revolute", "prismatic", "free"});
    pinocchio::Model model;
    model.gravity.linear() = eigen(ours.gravity());
    for (int i = 0; i < ours.bodies(); ++i) {
      const Link& link = ours.link(i);
      const BodyMass body(link.inertia);
      const pinocchio::SE3 frame(eigen(link.X), eigen(link.o));
      const auto parent = static_cast<pinocchio::JointIndex>(link.parent + 1);
      const std::string name = fmt::format("j{}", i);
      const auto joint = is(link, "revolute") ? model.addJoint(parent, pinocchio::JointModelRZ(), frame, name)
                         : is(link, "prismatic")
                             ? model.addJoint(parent, pinocchio::JointModelPZ(), frame, name)
                             : model.addJoint(parent, pinocchio::JointModelFreeFlyer(), frame, name);
      model.appendBodyToJoint(joint, pinocchio::Inertia(body.mass, body.com, body.inertia), pinocchio::SE3::Identity());
    }
    return model;
  }
  /// Of a free joint Pinocchio has the linear part first, both in body axes as ours.
  Eigen::Index index(int i, int k) const { return model_.idx_vs[i + 1] + (ours_.link(i).nv == 6 ? (k + 3) % 6 : k); }

  Task task_;
  Model ours_;
  pinocchio::Model model_;
  pinocchio::Data data_;
  Eigen::VectorXd q_, v_, tau_, given_;
};

template <Task task>
std::unique_ptr<PeerModel> build(const Mechanism& mechanism, const std::vector<double>& vdot) {
  return std::make_unique<Pinocchio>(mechanism, vdot, task);
}

const PeerRegistration forward(
    {.name = "pinocchio", .version = PINOCCHIO_VERSION, .computes = "aba", .build = build<Task::forward>});
const PeerRegistration inverse({.name = "pinocchio",
                                .task = Task::inverse,
                                .version = PINOCCHIO_VERSION,
                                .computes = "rnea",
                                .build = build<Task::inverse>});

}  // namespace
}  // namespace lanc::peers
