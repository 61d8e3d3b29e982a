#include "lib/closure/alignment.h"

#include <cmath>

namespace lanc {
namespace {

struct Pose {
  Mat3<double> axes;
  Vec3<double> origin;
};

Pose frame(const Evaluator<double>& evaluator, const std::vector<Vec3<double>>& positions, int body,
           const Mat3<double>& axes, const Vec3<double>& point) {
  if (body == ground) return {axes, point};
  const Mat3<double>& R = evaluator.rotation(body);
  return {R * axes, positions[body] + R * point};
}

const Vec3<double>& axis(const Mat3<double>& m, char name) { return name == 'x' ? m.x : name == 'y' ? m.y : m.z; }

/// The cosine whose sine is the screw condition of lib/system/closure_rows.h.
double screw_cosine(const Pose& A, const Pose& B, double pitch) {
  const double cosine = dot(A.axes.x, B.axes.x) + dot(A.axes.y, B.axes.y);
  const double sine = dot(A.axes.y, B.axes.x) - dot(A.axes.x, B.axes.y);
  const double phase = dot(A.axes.z, B.origin - A.origin) / pitch;
  return std::cos(phase) * cosine + std::sin(phase) * sine;
}

bool is_flipped(const Closure& c, const Pose& A, const Pose& B) {
  const Conditions& conditions = c.conditions();
  for (const char name : conditions.aligned)
    if (dot(axis(A.axes, name), axis(B.axes, name)) < 0) return true;
  for (int k = 0; k < conditions.count; ++k)
    if (conditions.rows[k].kind == ConditionKind::screw && screw_cosine(A, B, c.pitch) < 0) return true;
  return false;
}

}  // namespace

std::vector<int> flipped_closures(const Model& model, double t, const Evaluator<double>& evaluator,
                                  const std::vector<Vec3<double>>& positions) {
  std::vector<int> flipped;
  const ClosureSet& set = model.closures();
  for (int i = 0; i < static_cast<int>(set.closures.size()); ++i) {
    const Closure& c = set.closures[i];
    Pose A = frame(evaluator, positions, c.body_a, c.axes_a, c.point_a);
    const Pose B = frame(evaluator, positions, c.body_b, c.axes_b, c.point_b);
    const ClosureTraits& traits = c.kind.traits();
    // a prescribed joint turns frame A; how far it shifts it does not matter here
    if (c.motion >= 0 && traits.joint && traits.joint->traits().columns[0] != ColumnKind::translation)
      A.axes = turned_about_z(A.axes, sine_and_cosine(set.motions[c.motion]->at(t).position));
    if (is_flipped(c, A, B)) flipped.push_back(i);
  }
  return flipped;
}

}  // namespace lanc
