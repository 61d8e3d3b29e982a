#include "tests/support/lecture_figures.h"

namespace lanc::test {

Model planar_four_bar(double a, double b, double c, double d, bool hinge_cut) {
  ModelSpec spec;
  spec.name = "planar four-bar";
  spec.length = (a + b + c + d) / 4;
  const auto rod = [](const char* name, const Eigen::Vector3d& tip) {
    BodySpec body;
    body.name = name;
    body.mass = tip.norm();
    body.com = tip / 2;
    body.inertia = (Eigen::Matrix3d::Identity() * tip.squaredNorm() - tip * tip.transpose()) * body.mass / 12 +
                   Eigen::Matrix3d::Identity() * 1e-3 * body.mass;
    return body;
  };
  const auto hinge = [](const char* name, const char* parent, const char* body, const Eigen::Vector3d& at) {
    JointSpec joint;
    joint.name = name;
    joint.kind = *find_joint_kind("revolute");
    joint.parent = parent;
    joint.body = body;
    joint.frame.position = at;
    return joint;
  };
  spec.bodies = {rod("crank", {a, 0, 0}), rod("coupler", {b, 0, 0}), rod("rocker", {0, -c, 0})};
  spec.joints = {hinge("beta1", "", "crank", {0, 0, 0}), hinge("beta2", "crank", "coupler", {a, 0, 0}),
                 hinge("beta3", "", "rocker", {0, d, 0})};
  ClosureSpec cut;
  cut.name = "cut";
  cut.kind = *find_closure_kind(hinge_cut ? "revolute" : "point-on-line");  // the line is z: rows x and y
  // the frame that gives the axes of the rows stands on the rocker; for the lecture's rows it would be ground
  cut.body_a = "rocker";
  cut.body_b = "coupler";
  cut.frame_a.position = {0, -c, 0};
  cut.frame_b.position = {b, 0, 0};
  spec.closures = {cut};
  return Model::build(spec);
}

}  // namespace lanc::test
