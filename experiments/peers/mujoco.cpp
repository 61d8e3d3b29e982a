// MuJoCo: mass matrix by composite inertias and sparse LᵀDL; closed loops as soft constraints by Newton's method.
#include <fmt/format.h>
#include <mujoco/mujoco.h>

#include <cstring>

#include "experiments/peers/mujoco_xml.h"
#include "experiments/peers/parts.h"
#include "experiments/peers/peer.h"
#include "lib/model/error.h"

namespace lanc::peers {
namespace {

struct Free {
  void operator()(mjModel* m) const { mj_deleteModel(m); }
  void operator()(mjData* d) const { mj_deleteData(d); }
};

[[noreturn]] void fail(const char* message) { throw InputError(std::string("mujoco: ") + message); }

std::unique_ptr<mjModel, Free> load(const Model& model) {
  require("mujoco", model, {"revolute", "prismatic", "fixed", "free", "spherical"}, {"point-on-point", "fixed"});
  mju_user_error = fail;  // else it ends the program
  const std::string text = mujoco_xml(model);
  const auto files = std::make_unique<mjVFS>();
  mj_defaultVFS(files.get());
  mj_makeEmptyFileVFS(files.get(), "model.xml", static_cast<int>(text.size()));
  std::memcpy(files->filedata[mj_findFileVFS(files.get(), "model.xml")], text.data(), text.size());
  char error[1000] = "";
  std::unique_ptr<mjModel, Free> loaded(mj_loadXML("model.xml", files.get(), error, sizeof error));
  mj_deleteVFS(files.get());
  if (!loaded) fail(error);
  return loaded;
}

/// Everything is off that is not the mass matrix and, on closed loops, the equality constraints.
int flags_off(bool closed) {
  const int always = mjDSBL_FRICTIONLOSS | mjDSBL_LIMIT | mjDSBL_CONTACT | mjDSBL_PASSIVE | mjDSBL_CLAMPCTRL |
                     mjDSBL_ACTUATION | mjDSBL_SENSOR | mjDSBL_WARMSTART;
  return closed ? always : always | mjDSBL_CONSTRAINT | mjDSBL_EQUALITY;
}

class MuJoCo : public PeerModel {
 public:
  MuJoCo(const Mechanism& mechanism, const std::vector<double>& vdot, Task task)
      : task_(task), ours_(mechanism.model), model_(load(ours_)), data_(mj_makeData(model_.get())) {
    model_->opt.disableflags = flags_off(ours_.has_closures());
    for (int k = 0; k < 3; ++k) model_->opt.gravity[k] = eigen(ours_.gravity())[k];
    for (std::size_t k = 0; k < ours_.closures().closures.size(); ++k)
      place(ours_.closures().closures[k], model_->eq_data + mjNEQDATA * k);
    if (has_free_root(ours_)) root_ = FreeRoot(ours_, mechanism.state);
    qpos_.resize(model_->nq), qvel_.resize(model_->nv), qacc_.resize(model_->nv);
    for (int i = 0; i < ours_.bodies(); ++i) set(i, mechanism.state, vdot);
  }

  void call() override {
    mjModel* m = model_.get();
    mjData* d = data_.get();
    std::copy(qpos_.begin(), qpos_.end(), d->qpos);
    std::copy(qvel_.begin(), qvel_.end(), d->qvel);
    if (task_ == Task::forward) return mj_forward(m, d);
    std::copy(qacc_.begin(), qacc_.end(), d->qacc);
    mj_kinematics(m, d);
    mj_comPos(m, d);
    mj_comVel(m, d);
    mj_rne(m, d, 1, d->qfrc_inverse);
  }

  std::vector<double> answer() override {
    call();
    const mjtNum* found = task_ == Task::forward ? data_->qacc : data_->qfrc_inverse;
    std::vector<double> result(ours_.nv());
    for (int i = 0; i < ours_.bodies(); ++i) {
      const Link& link = ours_.link(i);
      double* own = result.data() + link.v;
      if (!is(link, "free")) {
        std::copy_n(found + address(i), link.nv, own);
        continue;
      }
      const Eigen::Map<const Eigen::Vector3d> linear(found), angular(found + 3);  // world axes; body axes
      if (task_ == Task::forward) {
        root_.from_world(root_.R * angular, linear, own);
      } else {
        Eigen::Vector3d::Map(own) = angular;
        Eigen::Vector3d::Map(own + 3) = root_.R.transpose() * linear;
      }
    }
    return result;
  }

 private:
  /// First velocity coordinate of the joint of our body i.
  int address(int i) const {
    const int joint = mj_name2id(model_.get(), mjOBJ_JOINT, fmt::format("j{}", i).c_str());
    return joint < 0 ? 0 : model_->jnt_dofadr[joint];
  }
  /// Anchors of `connect`, frames of `weld`, as the model has them; the compiler takes them from zero positions.
  static void place(const Closure& c, mjtNum* data) {
    const Eigen::Vector3d a = eigen(c.point_a), b = eigen(c.point_b);
    const bool weld = c.kind.traits().name == "fixed";
    for (int k = 0; k < 3; ++k) data[k] = weld ? b[k] : a[k], data[3 + k] = weld ? a[k] : b[k];
    if (!weld) return;
    const Eigen::Quaterniond turn(Eigen::Matrix3d(eigen(c.axes_a) * eigen(c.axes_b).transpose()));
    const double relative[] = {turn.w(), turn.x(), turn.y(), turn.z()};
    std::copy_n(relative, 4, data + 6);
  }
  void set(int i, const State<double>& state, const std::vector<double>& vdot) {
    const Link& link = ours_.link(i);
    if (link.nv == 0) return;
    const int v = address(i), q = model_->jnt_qposadr[model_->dof_jntid[v]];
    if (!is(link, "free")) {
      std::copy_n(state.q.data() + link.q, link.nq, &qpos_[q]);
      std::copy_n(state.v.data() + link.v, link.nv, &qvel_[v]);
      std::copy_n(vdot.data() + link.v, link.nv, &qacc_[v]);
      return;
    }
    const Eigen::Quaterniond turn(root_.R);
    const Eigen::Vector3d body_angular = root_.R.transpose() * root_.angular;
    Eigen::Vector3d alpha, a;
    root_.to_world(vdot.data() + link.v, alpha, a);
    const double pose[] = {
        root_.position.x(), root_.position.y(), root_.position.z(), turn.w(), turn.x(), turn.y(), turn.z()};
    std::copy_n(pose, 7, &qpos_[q]);
    std::copy_n(root_.linear.data(), 3, &qvel_[v]);
    std::copy_n(body_angular.data(), 3, &qvel_[v + 3]);
    std::copy_n(a.data(), 3, &qacc_[v]);
    std::copy_n(vdot.data() + link.v, 3, &qacc_[v + 3]);
  }

  Task task_;
  Model ours_;
  std::unique_ptr<mjModel, Free> model_;
  std::unique_ptr<mjData, Free> data_;
  FreeRoot root_;
  std::vector<mjtNum> qpos_, qvel_, qacc_;
};

template <Task task>
std::unique_ptr<PeerModel> build(const Mechanism& mechanism, const std::vector<double>& vdot) {
  if (task == Task::inverse && mechanism.model.has_closures())
    throw InputError("mujoco is asked for the inverse dynamics of open mechanisms only");
  return std::make_unique<MuJoCo>(mechanism, vdot, task);
}

const PeerRegistration forward(
    {.name = "mujoco",
     .version = mj_versionString(),
     .computes = "mj_forward: mass matrix; constraints, contacts, passive forces, actuation, sensors and warm start "
                 "off, on closed loops Newton's method on equality constraints of impedance 0.9999, no warm start",
     .build = build<Task::forward>,
     .soft_loops = true});
const PeerRegistration inverse({.name = "mujoco",
                                .task = Task::inverse,
                                .version = mj_versionString(),
                                .computes = "mj_kinematics, mj_comPos, mj_comVel, mj_rne with accelerations",
                                .build = build<Task::inverse>});

}  // namespace
}  // namespace lanc::peers
