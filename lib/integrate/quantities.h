// What can be told of an instant of a motion, by name: the columns of trajectories, of stop conditions, of references.
#pragma once

#include <string>
#include <vector>

#include "lib/integrate/simulation.h"

namespace lanc {

/// A point of a body whose path is of interest.
struct TracedPoint {
  std::string name;
  int body;             // or ground
  Vec3<double> offset;  // from the body's reference point, in the body's axes as the model file has them
};

/// "NAME=BODY:x,y,z". Throws InputError with the mend. Tested by tests/integrate/quantities_test.cpp.
TracedPoint read_point(const Model& model, const std::string& text);

struct Quantity {
  std::string name;
  double value = 0;
  std::string unit;
};

/// Which quantities are wanted beside coordinates, points, energies, violations and rank.
struct QuantityChoice {
  std::vector<TracedPoint> points;
  bool accelerations = false, reactions = false, multipliers = false, bodies = false;
};

/// Names: q.<position>, v.<velocity>, vdot.<velocity>; <point>.x .y .z .vx .. .ax ..; <joint>.fx .. .mx ..: the joint's
/// wrench on its body at the body's reference point, world axes; <body>.wx .. .alphax ..; lambda.<row>; drive.<joint>;
/// energy.kinetic, energy.potential, energy, work, energy_drift; violation.position, .velocity, .acceleration; rank,
/// sigma, choice_condition.
class Quantities {
 public:
  Quantities(const Model& model, QuantityChoice choice);
  std::vector<Quantity> at(const Instant& instant);

 private:
  void add_points(const Instant& instant, std::vector<Quantity>& list);
  void add_bodies(const Instant& instant, std::vector<Quantity>& list);

  Model model_;
  QuantityChoice choice_;
  Evaluator<double> evaluator_;
  std::vector<std::string> positions_, velocities_, drives_;
};

/// The value of that name. Throws InputError with the nearest names when there is none.
double value_of(const std::vector<Quantity>& list, const std::string& name);

}  // namespace lanc
