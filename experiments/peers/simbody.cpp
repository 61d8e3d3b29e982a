// Simbody: recursion on trees, exact multipliers on closed loops.
#include <algorithm>

#include "experiments/peers/parts.h"
#include "experiments/peers/peer.h"
#include "experiments/peers/simbody_tree.h"

namespace lanc::peers {
namespace {

Numbers3 numbers(const Vec3<double>& a) { return {a.x, a.y, a.z}; }
Numbers3 numbers(const Eigen::Vector3d& a) { return {a.x(), a.y(), a.z()}; }
Numbers9 numbers(const Eigen::Matrix3d& R) {
  Numbers9 result;
  std::copy_n(R.data(), 9, result.begin());
  return result;
}
SimbodyFrame frame(const Mat3<double>& axes, const Vec3<double>& origin) {
  return {numbers(eigen(axes)), numbers(origin)};
}

SimbodyTree::Joint joint(const Link& link) {
  using Joint = SimbodyTree::Joint;
  if (is(link, "revolute")) return Joint::revolute;
  if (is(link, "prismatic")) return Joint::prismatic;
  if (is(link, "spherical")) return Joint::spherical;
  return is(link, "free") ? Joint::free : Joint::fixed;
}

class Simbody : public PeerModel {
 public:
  explicit Simbody(const Mechanism& mechanism) : model_(mechanism.model), tree_(numbers(model_.gravity())) {
    require("simbody", model_, {"revolute", "prismatic", "fixed", "free", "spherical"}, {"point-on-point", "fixed"});
    for (const Link& link : model_.links()) {
      const RigidInertia<double>& M = link.inertia;
      tree_.add_body(link.parent, joint(link), frame(link.X, link.o),
                     {M.mass, numbers(BodyMass(M).com), {M.J.xx, M.J.yy, M.J.zz, M.J.xy, M.J.xz, M.J.yz}});
    }
    for (const Closure& c : model_.closures().closures)
      if (c.kind.traits().name == "fixed")
        tree_.add_weld(c.body_a, frame(c.axes_a, c.point_a), c.body_b, frame(c.axes_b, c.point_b));
      else
        tree_.add_ball(c.body_a, numbers(c.point_a), c.body_b, numbers(c.point_b));
    tree_.finish();
    turns_.resize(model_.bodies());
    for (int i = 0; i < model_.bodies(); ++i) set(i, mechanism.state);
  }

  void call() override { tree_.accelerate(); }

  std::vector<double> answer() override {
    call();
    std::vector<double> vdot(model_.nv());
    for (int i = 0; i < model_.bodies(); ++i) {
      const Link& link = model_.link(i);
      if (link.nv == 1) {
        vdot[link.v] = tree_.acceleration(i, 0);
      } else if (link.nv > 1) {
        // ours are the rates of components in body axes: d/dt (Rᵀ x) = Rᵀ (ẋ − ω × x)
        const Turn& turn = turns_[i];
        const auto found = [&](int k) {
          return Eigen::Vector3d(tree_.acceleration(i, k), tree_.acceleration(i, k + 1), tree_.acceleration(i, k + 2));
        };
        Eigen::Vector3d::Map(vdot.data() + link.v) = turn.R.transpose() * found(0);
        if (is(link, "free"))
          Eigen::Vector3d::Map(vdot.data() + link.v + 3) =
              turn.R.transpose() * (found(3) - turn.angular.cross(turn.linear));
      }
    }
    return vdot;
  }

 private:
  /// A free or spherical joint's motion, in axes of the joint's frame on the predecessor.
  struct Turn {
    Eigen::Matrix3d R;
    Eigen::Vector3d angular, linear;
  };

  void set(int i, const State<double>& state) {
    const Link& link = model_.link(i);
    const double *q = state.q.data() + link.q, *v = state.v.data() + link.v;
    if (link.nv == 1) tree_.set_coordinate(i, *q, *v);
    if (link.nv <= 1) return;
    const bool free = is(link, "free");
    Turn& turn = turns_[i];
    turn.R = quaternion(q + (free ? 3 : 0)).toRotationMatrix();
    turn.angular = turn.R * Eigen::Vector3d::Map(v);
    tree_.set_rotation(i, numbers(turn.R), numbers(turn.angular));
    if (!free) return;
    turn.linear = turn.R * Eigen::Vector3d::Map(v + 3);
    tree_.set_translation(i, {q[0], q[1], q[2]}, numbers(turn.linear));
  }

  Model model_;
  SimbodyTree tree_;
  std::vector<Turn> turns_;
};

const std::string version = SimbodyTree::version();
const PeerRegistration registration(
    {.name = "simbody",
     .version = version,
     .computes = "positions and velocities set, realize(Acceleration): recursion; closed loops by Constraint::Ball and "
                 "Constraint::Weld, exact",
     .build = [](const Mechanism& m, const std::vector<double>&) -> std::unique_ptr<PeerModel> {
       return std::make_unique<Simbody>(m);
     }});

}  // namespace
}  // namespace lanc::peers
