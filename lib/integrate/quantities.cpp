#include "lib/integrate/quantities.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>

namespace lanc {
namespace {

constexpr std::string_view axes[] = {"x", "y", "z"};

double component(const Vec3<double>& v, int k) { return k == 0 ? v.x : k == 1 ? v.y : v.z; }

void add(std::vector<Quantity>& list, const std::string& stem, const Vec3<double>& v, const char* unit) {
  for (int k = 0; k < 3; ++k) list.push_back({fmt::format("{}{}", stem, axes[k]), component(v, k), unit});
}

}  // namespace

TracedPoint read_point(const Model& model, const std::string& text) {
  const auto wrong = [&](const std::string& why) {
    return InputError(
        fmt::format("point '{}': {}; write NAME=BODY:x,y,z, in m from the body's reference point, in its "
                    "axes",
                    text, why));
  };
  const auto trimmed = [](std::string word) {
    word.erase(0, word.find_first_not_of(" \t"));
    return word.erase(word.find_last_not_of(" \t") + 1);
  };
  const std::size_t equals = text.find('='), colon = text.rfind(':');
  if (equals == text.npos || colon == text.npos || colon < equals) throw wrong("'=' or ':' is missing");
  TracedPoint point{trimmed(text.substr(0, equals)), ground, {0, 0, 0}};
  if (point.name.empty()) throw wrong("the name is missing");
  const std::string body = trimmed(text.substr(equals + 1, colon - equals - 1));
  if (body != "ground") {
    const auto index = model.find_body(body);
    if (!index) throw wrong(fmt::format("there is no body '{}'", body));
    point.body = *index;
  }
  double numbers[3];
  std::size_t at = colon + 1;
  for (int k = 0; k < 3; ++k) {
    const std::size_t end = std::min(text.find(',', at), text.size());
    const std::string word = trimmed(text.substr(std::min(at, text.size()), end - at));
    const auto [last, error] = std::from_chars(word.data(), word.data() + word.size(), numbers[k]);
    if (error != std::errc() || last != word.data() + word.size() || !std::isfinite(numbers[k]))
      throw wrong("three numbers are needed");
    at = end + 1;
  }
  if (at <= text.size()) throw wrong("three numbers are needed");
  point.offset = {numbers[0], numbers[1], numbers[2]};
  return point;
}

Quantities::Quantities(const Model& model, QuantityChoice choice)
    : model_(model),
      choice_(std::move(choice)),
      evaluator_(model),
      positions_(model.position_names()),
      velocities_(model.velocity_names()),
      drives_(model.drive_names()) {}

void Quantities::add_points(const Instant& instant, std::vector<Quantity>& list) {
  for (const TracedPoint& point : choice_.points) {
    Vec3<double> x = point.offset, v{0, 0, 0}, a{0, 0, 0};
    if (point.body != ground) {
      const Vec3<double> arm = evaluator_.body_rotation(point.body) * point.offset;
      const Motion<double>& twist = evaluator_.twists()[point.body];
      const Motion<double>& rate = instant.solution.acceleration[point.body];
      x = evaluator_.positions()[point.body] + arm;
      v = twist.linear + cross(twist.angular, arm);
      a = rate.linear + cross(rate.angular, arm) + cross(twist.angular, cross(twist.angular, arm));
    }
    add(list, point.name + ".", x, "m");
    add(list, point.name + ".v", v, "m/s");
    if (choice_.accelerations) add(list, point.name + ".a", a, "m/s^2");
  }
}

void Quantities::add_bodies(const Instant& instant, std::vector<Quantity>& list) {
  for (int i = 0; i < model_.bodies(); ++i) {
    const std::string& body = model_.spec().bodies[i].name;
    add(list, body + ".w", evaluator_.twists()[i].angular, "rad/s");
    if (choice_.accelerations) add(list, body + ".alpha", instant.solution.acceleration[i].angular, "rad/s^2");
  }
}

std::vector<Quantity> Quantities::at(const Instant& now) {
  std::vector<Quantity> list;
  const State<double>& state = now.point.state;
  evaluator_.system(state);
  evaluator_.positions(), evaluator_.twists();
  for (const Link& link : model_.links()) {
    const JointTraits& traits = link.kind.traits();
    for (int k = 0; k < link.nq; ++k)
      list.push_back({"q." + positions_[link.q + k], state.q[link.q + k], std::string(traits.q_units[k])});
  }
  for (const Link& link : model_.links())
    for (int k = 0; k < link.nv; ++k)
      list.push_back({"v." + velocities_[link.v + k], state.v[link.v + k], std::string(link.kind.traits().v_units[k])});
  if (choice_.accelerations)
    for (const Link& link : model_.links())
      for (int k = 0; k < link.nv; ++k)
        list.push_back({"vdot." + velocities_[link.v + k], now.solution.vdot[link.v + k],
                        link.kind.traits().v_units[k] == "m/s" ? "m/s^2" : "rad/s^2"});
  add_points(now, list);
  if (choice_.bodies) add_bodies(now, list);
  if (choice_.reactions)
    for (int i = 0; i < model_.bodies(); ++i) {
      const std::string& joint = model_.spec().joints[i].name;
      add(list, joint + ".f", now.solution.wrench[i].force, "N");
      add(list, joint + ".m", now.solution.wrench[i].moment, "N m");
    }
  if (choice_.reactions)
    for (int d = 0; d < model_.drives(); ++d)
      list.push_back({"drive." + drives_[d], now.solution.drive_force[d],
                      model_.drive_kind(d) == ColumnKind::translation ? "N" : "N m"});
  if (choice_.multipliers) {
    const ClosureSet& set = model_.closures();
    for (int k = 0; k < set.rows(); ++k)
      list.push_back({"lambda." + set.row_names[k], now.solution.lambda[k], set.row_is_length[k] ? "N" : "N m"});
  }
  list.push_back({"energy.kinetic", now.energy.kinetic, "J"});
  list.push_back({"energy.potential", now.energy.potential, "J"});
  list.push_back({"energy", now.energy.total(), "J"});
  list.push_back({"work", now.point.work, "J"});
  list.push_back({"energy_drift", now.energy_drift, "J"});
  if (model_.has_closures()) {
    list.push_back({"violation.position", now.position_violation, "1"});
    list.push_back({"violation.velocity", now.velocity_violation, "1/s"});
    list.push_back({"violation.acceleration", now.acceleration_violation, "1/s^2"});
    list.push_back({"rank", static_cast<double>(now.outcome.rank), "1"});
    list.push_back({"sigma", now.outcome.sigma, "1"});
    if (std::isfinite(now.choice_condition)) list.push_back({"choice_condition", now.choice_condition, "1"});
  }
  return list;
}

double value_of(const std::vector<Quantity>& list, const std::string& name) {
  const auto found = std::find_if(list.begin(), list.end(), [&](const Quantity& q) { return q.name == name; });
  if (found != list.end()) return found->value;
  std::string near;
  for (const Quantity& q : list)
    if (q.name.find(name.substr(0, name.find('.'))) != std::string::npos && near.size() < 200)
      near += (near.empty() ? "" : ", ") + q.name;
  throw InputError(fmt::format("there is no quantity '{}'{}", name, near.empty() ? "" : "; there are " + near));
}

}  // namespace lanc
