#include "experiments/peers/simbody_tree.h"

#include <Simbody.h>

#include <vector>

namespace lanc::peers {

using SimTK::MobilizedBody, SimTK::Transform, SimTK::Vec3;

namespace {

Vec3 vector(const Numbers3& a) { return {a[0], a[1], a[2]}; }
SimTK::Rotation rotation(const Numbers9& R) {
  return {SimTK::Mat33(R[0], R[3], R[6], R[1], R[4], R[7], R[2], R[5], R[8]), true};
}
Transform transform(const SimbodyFrame& frame) { return {rotation(frame.axes), vector(frame.origin)}; }

}  // namespace

struct SimbodyTree::Parts {
  SimTK::MultibodySystem system;
  SimTK::SimbodyMatterSubsystem matter{system};
  SimTK::GeneralForceSubsystem forces{system};
  std::vector<SimTK::MobilizedBodyIndex> bodies;
  SimTK::State state;
  SimTK::Vector q, u;

  /// What accelerate() sets.
  void keep() { q = state.getQ(), u = state.getU(); }
  MobilizedBody& body(int index) {
    return index < 0 ? static_cast<MobilizedBody&>(matter.updGround()) : matter.updMobilizedBody(bodies[index]);
  }
};

SimbodyTree::SimbodyTree(const Numbers3& gravity) : parts_(std::make_unique<Parts>()) {
  parts_->forces.setNumberOfThreads(1);  // else they are woken in every call
  SimTK::Force::Gravity(parts_->forces, parts_->matter, vector(gravity));
}
SimbodyTree::~SimbodyTree() = default;

void SimbodyTree::add_body(int parent, Joint joint, const SimbodyFrame& on_parent, const SimbodyMass& m) {
  const auto& I = m.inertia;
  const SimTK::Body::Rigid body(
      SimTK::MassProperties(m.mass, vector(m.com), SimTK::Inertia(I[0], I[1], I[2], I[3], I[4], I[5])));
  MobilizedBody& p = parts_->body(parent);
  const Transform frame = transform(on_parent), same;
  const auto add = [&](const MobilizedBody& added) { parts_->bodies.push_back(added.getMobilizedBodyIndex()); };
  switch (joint) {
    case Joint::revolute: return add(MobilizedBody::Pin(p, frame, body, same));
    case Joint::spherical: return add(MobilizedBody::Ball(p, frame, body, same));
    case Joint::free: return add(MobilizedBody::Free(p, frame, body, same));
    case Joint::fixed: return add(MobilizedBody::Weld(p, frame, body, same));
    case Joint::prismatic: break;
  }
  // Simbody's sliders slide along x
  const Transform turned(SimTK::Rotation(SimTK::Mat33(0, 1, 0, 0, 0, 1, 1, 0, 0), true));
  add(MobilizedBody::Slider(p, frame * turned, body, turned));
}

void SimbodyTree::add_ball(int a, const Numbers3& point_a, int b, const Numbers3& point_b) {
  SimTK::Constraint::Ball(parts_->body(a), vector(point_a), parts_->body(b), vector(point_b));
}
void SimbodyTree::add_weld(int a, const SimbodyFrame& frame_a, int b, const SimbodyFrame& frame_b) {
  SimTK::Constraint::Weld(parts_->body(a), transform(frame_a), parts_->body(b), transform(frame_b));
}

void SimbodyTree::finish() {
  parts_->system.realizeTopology();
  parts_->state = parts_->system.getDefaultState();
  parts_->system.realizeModel(parts_->state);
  parts_->keep();
}

void SimbodyTree::set_coordinate(int body, double q, double v) {
  parts_->body(body).setOneQ(parts_->state, 0, q);
  parts_->body(body).setOneU(parts_->state, 0, v);
  parts_->keep();
}
void SimbodyTree::set_rotation(int body, const Numbers9& R, const Numbers3& angular) {
  parts_->body(body).setQToFitRotation(parts_->state, rotation(R));
  parts_->body(body).setUToFitAngularVelocity(parts_->state, vector(angular));
  parts_->keep();
}
void SimbodyTree::set_translation(int body, const Numbers3& position, const Numbers3& linear) {
  parts_->body(body).setQToFitTranslation(parts_->state, vector(position));
  parts_->body(body).setUToFitLinearVelocity(parts_->state, vector(linear));
  parts_->keep();
}

void SimbodyTree::accelerate() {
  parts_->state.updQ() = parts_->q;
  parts_->state.updU() = parts_->u;
  parts_->system.realize(parts_->state, SimTK::Stage::Acceleration);
}
double SimbodyTree::acceleration(int body, int coordinate) const {
  return parts_->body(body).getOneUDot(parts_->state, coordinate);
}

std::string SimbodyTree::version() {
  int major = 0, minor = 0, build = 0;
  SimTK_version_simbody(&major, &minor, &build);
  return std::to_string(major) + "." + std::to_string(minor) + (build > 0 ? "." + std::to_string(build) : "");
}

}  // namespace lanc::peers
