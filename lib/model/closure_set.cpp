#include "lib/model/closure_set.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <unordered_set>

#include "lib/model/validate.h"
#include "lib/spatial/eigen.h"

namespace lanc {
namespace {

constexpr double most_factor_ratio = 1e12;

int add_motion(const std::optional<MotionSpec>& motion, const Place& place, const std::string& who, ClosureSet& set) {
  if (!motion) return -1;
  try {
    set.motions.push_back(PrescribedMotion::create(*motion));
  } catch (const InputError& error) {
    throw InputError(place, who + ": " + error.what());
  }
  return static_cast<int>(set.motions.size()) - 1;
}

Closure closure(const ClosureSpec& spec, const TreeForClosures& tree, ClosureSet& set) {
  const std::string who = "closure '" + spec.name + "'";
  Closure result;
  result.kind = spec.kind;
  result.body_a = tree.body(spec.body_a, spec.place, who);
  result.body_b = tree.body(spec.body_b, spec.place, who);
  const Eigen::Matrix3d axes = closure_axes(spec);
  const Eigen::Matrix3d to_a = to_eigen(tree.joint_axes(result.body_a)),
                        to_b = to_eigen(tree.joint_axes(result.body_b));
  result.axes_a = from_eigen(Eigen::Matrix3d(to_a * spec.frame_a.rotation * axes));
  result.axes_b = from_eigen(Eigen::Matrix3d(to_b * spec.frame_b.rotation * axes));
  result.point_a = from_eigen(Eigen::Vector3d(to_a * spec.frame_a.position));
  result.point_b = from_eigen(Eigen::Vector3d(to_b * spec.frame_b.position));
  result.pitch = spec.pitch;
  result.length = spec.length;
  result.motion = add_motion(spec.motion, spec.place, who, set);
  result.row = set.rows();
  const Conditions& conditions = result.conditions();
  for (int k = 0; k < conditions.count; ++k) {
    set.row_names.push_back(fmt::format("{}.{}", spec.name, conditions.rows[k].name));
    set.row_is_length.push_back(conditions.rows[k].is_length());
  }
  return result;
}

Coupler coupler(const CouplerSpec& spec, const TreeForClosures& tree, ClosureSet& set) {
  const std::string who = "coupler '" + spec.name + "'";
  Coupler result;
  std::unordered_set<int> met;
  double smallest = std::numeric_limits<double>::infinity(), largest = 0;
  for (const CouplerSpec::Term& term : spec.terms) {
    result.terms.push_back(tree.coordinate(term, spec.place, who));
    if (!met.insert(result.terms.back().v).second)
      throw InputError(spec.place, fmt::format("{}: a coordinate of joint '{}' is named twice; add up its factors", who,
                                               term.joint));
    smallest = std::min(smallest, std::abs(term.factor)), largest = std::max(largest, std::abs(term.factor));
  }
  if (largest > most_factor_ratio * smallest)
    throw InputError(spec.place, fmt::format("{}: factors from {:.3g} to {:.3g} leave no digits; mend them", who,
                                             smallest, largest));
  result.offset = spec.offset;
  result.motion = add_motion(spec.motion, spec.place, who, set);
  result.row = set.rows();
  set.row_names.push_back(spec.name + ".ratio");
  set.row_is_length.push_back(tree.is_translation(result.terms[0].v));
  return result;
}

template <class Item>
void check_names(const std::vector<Item>& items, std::unordered_set<std::string>& names) {
  for (const Item& item : items)
    if (!names.insert(item.name).second)
      throw InputError(item.place, fmt::format("two closures are called '{}'; rename one", item.name));
}

}  // namespace

ClosureSet build_closures(const ModelSpec& spec, const TreeForClosures& tree) {
  ClosureSet set;
  std::unordered_set<std::string> names;
  for (const ClosureSpec& c : spec.closures) validate(c);
  for (const CouplerSpec& c : spec.couplers) validate(c);
  check_names(spec.closures, names);
  check_names(spec.couplers, names);
  for (const ClosureSpec& c : spec.closures) set.closures.push_back(closure(c, tree, set));
  set.body_rows = set.rows();
  for (const CouplerSpec& c : spec.couplers) set.couplers.push_back(coupler(c, tree, set));
  return set;
}

}  // namespace lanc
