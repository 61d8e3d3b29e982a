#include "lib/system/finite.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace lanc {
namespace {

template <class S>
bool usable(const S& x) {
  constexpr double largest = 1e100;
  return std::abs(to_double(x)) < largest;
}

template <class S>
bool usable(const Vec3<S>& a) {
  return usable(a.x) && usable(a.y) && usable(a.z);
}

/// What the joint's own position and motion give: place, inertia in world axes, bias acceleration.
template <class S>
bool motion_usable(const System<S>& system, int body) {
  const auto& b = system.bodies[body];
  const auto& bias = system.rhs.bias[body];
  return usable(b.r) && usable(b.inertia.h) && usable(bias.angular) && usable(bias.linear);
}

template <class S>
bool load_usable(const System<S>& system, int body) {
  return usable(system.rhs.force[body].moment) && usable(system.rhs.force[body].force);
}

template <class S>
bool closure_usable(const System<S>& system, std::size_t k) {
  const auto& row = system.closure_rows[k];
  return usable(row.a.moment) && usable(row.a.force) && usable(row.b.moment) && usable(row.b.force);
}

/// The first spring of which every end that is on a body has a load that cannot be used, or nothing.
template <class S>
const PointSpringSpec* broken_spring(const System<S>& system) {
  const Model& model = system.model;
  const auto broken = [&](int body) { return body == ground || !load_usable(system, body); };
  for (std::size_t k = 0; k < model.springs().size(); ++k)
    if (broken(model.springs()[k].body_a) && broken(model.springs()[k].body_b)) return &model.spec().springs[k];
  return nullptr;
}

}  // namespace

template <class S>
bool finite(const System<S>& system) {
  for (int i = 0; i < system.model.bodies(); ++i)
    if (!motion_usable(system, i) || !load_usable(system, i)) return false;
  for (std::size_t k = 0; k < system.closure_rows.size(); ++k)
    if (!closure_usable(system, k)) return false;
  const auto all_usable = [](const std::vector<S>& numbers) {
    return std::all_of(numbers.begin(), numbers.end(), [](const S& x) { return usable(x); });
  };
  return all_usable(system.rhs.tau) && all_usable(system.rhs.closure);
}

template <class S>
std::string not_finite_because(const System<S>& system) {
  const Model& model = system.model;
  for (int i = 0; i < model.bodies(); ++i) {  // parents first: what is wrong with a body reaches all it carries
    if (motion_usable(system, i)) continue;
    const std::string& joint = model.spec().joints[i].name;
    if (model.link(i).drive >= 0)
      return fmt::format(
          "the prescribed motion of joint '{}' is no finite number at this time, or too large; a table ends, or a "
          "formula has a pole",
          joint);
    return fmt::format(
        "the position or velocity of joint '{}', or of one it hangs on, is no finite number or too large; mend q, v",
        joint);
  }
  if (const PointSpringSpec* spring = broken_spring(system))
    return fmt::format(
        "the force of spring '{}' is no finite number or too large; at length zero it has no direction, unless its "
        "rest_length is zero",
        spring->name);
  for (int i = 0; i < model.bodies(); ++i)
    if (!load_usable(system, i))
      return fmt::format("the load on body '{}' is no finite number or too large; look at its velocity and wrenches",
                         model.spec().bodies[i].name);
  for (int k = 0; k < model.nv(); ++k)
    if (!usable(system.rhs.tau[k]))
      return fmt::format(
          "the force along '{}' is no finite number or too large; look at its tau, spring, damper and friction",
          model.velocity_names()[k]);
  for (std::size_t k = 0; k < system.rhs.closure.size(); ++k)
    if (!usable(system.rhs.closure[k]) || !closure_usable(system, k))
      return fmt::format("the closure condition '{}' is no finite number or too large at this state",
                         model.closures().row_names[k]);
  return {};
}

template bool finite(const System<double>&);
template bool finite(const System<long double>&);
template bool finite(const System<Count>&);
template std::string not_finite_because(const System<double>&);
template std::string not_finite_because(const System<long double>&);
template std::string not_finite_because(const System<Count>&);

}  // namespace lanc
