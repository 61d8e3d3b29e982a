// What is asked: models, the peers that must occur for each, and the bounds that ratios are held against. Data only.
#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "experiments/peers/peer.h"
#include "lib/model/model.h"

namespace lanc::peers {

/// Our inverse dynamics in the column `formulation`.
constexpr std::string_view our_inverse = "inverse-dynamics";

/// Model arguments of the default run, and of the quick one.
std::vector<std::string> default_models(bool quick);
/// What tables and CSV call a model: a file's name without folder and ending.
std::string short_name(const std::string& model);

/// A peer that has a row for every model, also where it is not compiled.
struct MandatoryPeer {
  std::string_view name;
  Task task;
};
std::span<const MandatoryPeer> mandatory_peers();
/// Models without peers: exact ones take minutes on them.
bool ours_alone(const Model& model);

/// The time of one side on one model.
struct Side {
  std::string_view who;  // formulation or peer
  Task task;
  std::string_view model;
};

/// time(ours) / time(other) ≤ limit; of two sizes of the same model the exponent of time in the size instead.
struct Bound {
  Side ours, other;
  double limit;
  double sizes = 0;  // quotient of the sizes; the limit is that of the exponent
};
std::span<const Bound> bounds();
/// Largest error of a formulation against the closed form, relative.
struct ErrorBound {
  Side ours;
  double limit;
};
std::span<const ErrorBound> error_bounds();
/// Whether a bound speaks of this formulation.
bool has_bound(std::string_view formulation);

/// Accelerations of a ladder of four-bars at this state by its closed form; empty for other models.
std::vector<double> closed_form(const std::string& name, const Model& model, const State<double>& state);

}  // namespace lanc::peers
