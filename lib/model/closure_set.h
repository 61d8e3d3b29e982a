// The closures of a model, brought into the joint axes of their bodies, and their rows numbered.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "lib/model/spec.h"

namespace lanc {

/// A closure between frame A on `body_a` and frame B on `body_b`, in joint axes of the bodies (world axes for ground).
struct Closure {
  ClosureKind kind;
  int body_a, body_b;
  Mat3<double> axes_a, axes_b;
  Vec3<double> point_a, point_b;
  double pitch = 0;   // m/rad
  double length = 0;  // m
  int motion = -1;    // index among the closure motions, or −1
  int row = 0;        // of its first condition

  /// What it demands: a prescribed joint leaves no freedom.
  const Conditions& conditions() const {
    const ClosureTraits& traits = kind.traits();
    return motion >= 0 && !traits.has_length ? joints::Fixed::traits.closure : traits.conditions;
  }
};

/// Σ factor q = offset + motion(t).
struct Coupler {
  struct Term {
    int q, v;
    double factor;
  };
  std::vector<Term> terms;
  double offset = 0;
  int motion = -1;
  int row = 0;
};

/// All closures of a model. Rows: those of the closures in the order of the specification, then one per coupler.
struct ClosureSet {
  std::vector<Closure> closures;
  std::vector<Coupler> couplers;
  std::vector<std::shared_ptr<const PrescribedMotion>> motions;
  std::vector<std::string> row_names;  // closure.axis
  std::vector<bool> row_is_length;     // value in m (a coupler: in the unit of its largest term)
  int body_rows = 0;                   // rows on bodies; the couplers' follow
  int rows() const { return static_cast<int>(row_names.size()); }
};

/// What closures need to know of the tree.
struct TreeForClosures {
  /// Index of a body, `ground` for an empty name; throws InputError when there is none.
  std::function<int(const std::string& name, const Place& place, const std::string& who)> body;
  /// Rotation from the user's body axes to joint axes.
  std::function<Mat3<double>(int body)> joint_axes;
  /// Coordinate of a joint for a coupler; throws InputError.
  std::function<Coupler::Term(const CouplerSpec::Term&, const Place& place, const std::string& who)> coordinate;
  /// Whether that velocity is a length per second.
  std::function<bool(int v)> is_translation;
};

/// Validates. Throws InputError naming the thing, its place and the mend.
ClosureSet build_closures(const ModelSpec& spec, const TreeForClosures& tree);

}  // namespace lanc
