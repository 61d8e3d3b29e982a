// Orocos KDL: chains; forward dynamics through the mass matrix, inverse dynamics by recursion.
#include <kdl/chainfdsolver_recursive_newton_euler.hpp>
#include <kdl/chainidsolver_recursive_newton_euler.hpp>

#include <fmt/format.h>

#include "experiments/peers/parts.h"
#include "experiments/peers/peer.h"
#include "lib/model/error.h"

namespace lanc::peers {
namespace {

KDL::Vector kdl(const Eigen::Vector3d& a) { return {a.x(), a.y(), a.z()}; }

KDL::Chain chain(const Model& model) {
  require("orocos-kdl", model, {"revolute", "prismatic", "fixed"});
  KDL::Chain chain;
  for (int i = 0; i < model.bodies(); ++i) {
    const Link& link = model.link(i);
    if (link.parent != i - 1) throw InputError("orocos-kdl has these solvers for chains only");
    const BodyMass body(link.inertia);
    const Eigen::Matrix3d X = eigen(link.X), &I = body.inertia;
    const KDL::Rotation axes(X(0, 0), X(0, 1), X(0, 2), X(1, 0), X(1, 1), X(1, 2), X(2, 0), X(2, 1), X(2, 2));
    const KDL::Vector origin = kdl(eigen(link.o)), axis = kdl(X.col(2));
    const std::string name = fmt::format("j{}", i);
    const KDL::Joint joint =
        is(link, "fixed")
            ? KDL::Joint(name)
            : KDL::Joint(name, origin, axis, is(link, "revolute") ? KDL::Joint::RotAxis : KDL::Joint::TransAxis);
    chain.addSegment(KDL::Segment(
        fmt::format("b{}", i), joint, KDL::Frame(axes, origin),
        KDL::RigidBodyInertia(body.mass, kdl(body.com),
                              KDL::RotationalInertia(I(0, 0), I(1, 1), I(2, 2), I(0, 1), I(0, 2), I(1, 2)))));
  }
  return chain;
}

KDL::JntArray array(const std::vector<double>& values) {
  KDL::JntArray result(static_cast<unsigned>(values.size()));
  for (unsigned k = 0; k < values.size(); ++k) result(k) = values[k];
  return result;
}

/// Scalar joints in series: coordinates are ours, in our order.
template <class Solver>
class Kdl : public PeerModel {
 public:
  Kdl(const Mechanism& mechanism, const std::vector<double>& vdot)
      : chain_(chain(mechanism.model)),
        solver_(chain_, kdl(eigen(mechanism.model.gravity()))),
        q_(array(mechanism.state.q)),
        v_(array(mechanism.state.v)),
        given_(array(vdot)),
        found_(chain_.getNrOfJoints()),
        external_(chain_.getNrOfSegments(), KDL::Wrench::Zero()) {}

  void call() override {
    const int code = solver_.CartToJnt(q_, v_, given_, external_, found_);  // given: torques, or accelerations
    if (code < 0) throw InputError(fmt::format("orocos-kdl: {}", solver_.strError(code)));
  }
  std::vector<double> answer() override {
    call();
    return {found_.data.data(), found_.data.data() + found_.rows()};
  }

 private:
  KDL::Chain chain_;
  Solver solver_;
  KDL::JntArray q_, v_, given_, found_;
  KDL::Wrenches external_;
};

const PeerRegistration forward({.name = "orocos-kdl",
                                .version = LANC_KDL_VERSION,
                                .computes = "ChainFdSolver_RNE: mass matrix, bias by recursion, LDL; chains only",
                                .build = [](const Mechanism& m,
                                            const std::vector<double>&) -> std::unique_ptr<PeerModel> {
                                  return std::make_unique<Kdl<KDL::ChainFdSolver_RNE>>(
                                      m, std::vector<double>(m.model.nv()));  // no torques
                                }});
const PeerRegistration inverse({.name = "orocos-kdl",
                                .task = Task::inverse,
                                .version = LANC_KDL_VERSION,
                                .computes = "ChainIdSolver_RNE; chains only",
                                .build = [](const Mechanism& m,
                                            const std::vector<double>& vdot) -> std::unique_ptr<PeerModel> {
                                  return std::make_unique<Kdl<KDL::ChainIdSolver_RNE>>(m, vdot);
                                }});

}  // namespace
}  // namespace lanc::peers
