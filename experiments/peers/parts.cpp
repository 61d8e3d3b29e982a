#include "experiments/peers/parts.h"

#include <fmt/format.h>

#include <algorithm>

#include "lib/model/error.h"

namespace lanc::peers {

using Eigen::Matrix3d;
using Eigen::Vector3d;

Vector3d eigen(const Vec3<double>& a) { return {a.x, a.y, a.z}; }

Matrix3d eigen(const Mat3<double>& a) {
  Matrix3d m;
  m << eigen(a.x), eigen(a.y), eigen(a.z);
  return m;
}

BodyMass::BodyMass(const RigidInertia<double>& M)
    : mass(M.mass), com(M.mass > 0 ? Vector3d(eigen(M.h) / M.mass) : Vector3d::Zero()) {
  inertia << M.J.xx, M.J.xy, M.J.xz, M.J.xy, M.J.yy, M.J.yz, M.J.xz, M.J.yz, M.J.zz;
  inertia -= mass * (com.squaredNorm() * Matrix3d::Identity() - com * com.transpose());
}

PrincipalFrame BodyMass::principal_frame() const {
  const Eigen::SelfAdjointEigenSolver<Matrix3d> principal(inertia);
  Matrix3d axes = principal.eigenvectors();
  if (axes.determinant() < 0) axes.col(0) *= -1;
  return {com, principal.eigenvalues(), axes};
}

void require(std::string_view peer, const Model& model, std::initializer_list<std::string_view> joints,
             std::initializer_list<std::string_view> closures) {
  const auto listed = [](std::initializer_list<std::string_view> list, std::string_view name) {
    return std::find(list.begin(), list.end(), name) != list.end();
  };
  for (int i = 0; i < model.bodies(); ++i) {
    const Link& link = model.link(i);
    const std::string_view kind = link.kind.traits().name;
    if (!listed(joints, kind)) throw InputError(fmt::format("{} is not given {} joints", peer, kind));
    if (kind == "free" && i > 0)
      throw InputError(fmt::format("{} is given a free joint for the first body only", peer));
    if (link.drive >= 0) throw InputError(fmt::format("{} is not given prescribed motions", peer));
  }
  if (!model.springs().empty() || !model.wrenches().empty() || !model.passive().empty() || model.has_armature())
    throw InputError(fmt::format("{} is not given springs, friction, damping, armature or constant wrenches", peer));
  for (const Closure& closure : model.closures().closures) {
    const std::string_view kind = closure.kind.traits().name;
    if (!listed(closures, kind)) throw InputError(fmt::format("{} is not given closures {}", peer, kind));
    if (closure.motion >= 0) throw InputError(fmt::format("{} is not given driven closures", peer));
  }
  if (!model.closures().couplers.empty()) throw InputError(fmt::format("{} is not given couplers", peer));
}

Eigen::Quaterniond quaternion(const double* q) { return {q[0], q[1], q[2], q[3]}; }

FreeRoot::FreeRoot(const Model& model, const State<double>& state) {
  const Link& link = model.link(0);
  const double *q = state.q.data() + link.q, *v = state.v.data() + link.v;
  const Matrix3d frame = eigen(link.X);
  R = frame * quaternion(q + 3).toRotationMatrix();
  position = eigen(link.o) + frame * Vector3d(q[0], q[1], q[2]);
  angular = R * Vector3d(v[0], v[1], v[2]);
  linear = R * Vector3d(v[3], v[4], v[5]);
}

void FreeRoot::from_world(const Vector3d& alpha, const Vector3d& a, double* vdot) const {
  // d/dt (Rᵀ x) = Rᵀ (ẋ − ω × x)
  Vector3d::Map(vdot) = R.transpose() * alpha;
  Vector3d::Map(vdot + 3) = R.transpose() * (a - angular.cross(linear));
}

void FreeRoot::to_world(const double* vdot, Vector3d& alpha, Vector3d& a) const {
  alpha = R * Vector3d::Map(vdot);
  a = R * Vector3d::Map(vdot + 3) + angular.cross(linear);
}

}  // namespace lanc::peers
