// The native model format; data/models/README.md describes it for users.
#include <fmt/format.h>

#include <Eigen/Geometry>
#include <array>
#include <cmath>
#include <filesystem>
#include <unordered_map>

#include "lib/io/mechanism.h"
#include "lib/io/text.h"
#include "lib/io/toml_parts.h"
#include "lib/io/toml_reader.h"

namespace lanc {
namespace {

using Keys = std::span<const std::string_view>;

Eigen::Matrix3d read_inertia(const TomlTable& body) {
  const toml::node* node = body.find("inertia");
  if (!node) return Eigen::Matrix3d::Zero();
  if (node->is_array()) {
    const std::vector<double> diagonal = body.numbers(*node, "inertia");
    if (diagonal.size() != 3)
      body.fail(*node, fmt::format("inertia as an array has 3 numbers [xx, yy, zz], not {}; write a table {{xx = …, yy "
                                   "= …, zz = …, xy = …, xz = …, yz = …}} for a full tensor",
                                   diagonal.size()));
    return Eigen::Vector3d(diagonal[0], diagonal[1], diagonal[2]).asDiagonal();
  }
  static constexpr std::string_view keys[] = {"xx", "yy", "zz", "xy", "xz", "yz"};
  const toml::table& inner = body.table(*node, "inertia");
  const TomlTable tensor(inner, body.file(), body.who() + ": inertia", keys);
  for (const std::string_view key : Keys(keys).first(3))
    if (!tensor.find(key)) tensor.fail(fmt::format("{} is missing; give at least xx, yy and zz", key));
  Eigen::Matrix3d I;
  I << tensor.number("xx"), tensor.number("xy"), tensor.number("xz"),  //
      tensor.number("xy"), tensor.number("yy"), tensor.number("yz"),   //
      tensor.number("xz"), tensor.number("yz"), tensor.number("zz");
  return I;
}

BodySpec read_body(const toml::table& source, const std::string& file) {
  static constexpr std::string_view keys[] = {"name", "mass", "com", "inertia", "allow_nonphysical_inertia"};
  const TomlTable table(source, file, label("body", source), keys);
  BodySpec body;
  body.place = table.place();
  body.name = table.name("name");
  if (body.name == "ground") table.fail("'ground' is the name of the inertial frame; choose another one");
  if (!table.find("mass")) table.fail("mass is missing; add mass = … in kg (0 is legal)");
  body.mass = table.number("mass");
  body.com = table.vector("com");
  body.inertia = read_inertia(table);
  body.allow_nonphysical_inertia = table.flag("allow_nonphysical_inertia");
  return body;
}

/// Calls set(coordinate, entry) for the entry of every velocity coordinate: `key` is a number for a joint of one
/// freedom, an array with one entry per velocity otherwise.
template <class Set>
void read_coordinates(const TomlTable& table, std::string_view key, JointSpec& joint, Set set) {
  const toml::node* node = table.find(key);
  if (!node) return;
  const JointTraits& traits = joint.kind.traits();
  const auto count = static_cast<std::size_t>(traits.nv);
  const toml::array* array = node->as_array();
  if (count == 0) table.fail(*node, fmt::format("a {} joint has no velocity; remove {}", traits.name, key));
  if ((array ? array->size() : 1) != count)
    table.fail(*node, fmt::format("{} needs {} ({}), not {}", key,
                                  count == 1 ? "1 number" : fmt::format("an array of {}", count),
                                  fmt::join(traits.v_names.begin(), traits.v_names.begin() + traits.nv, ", "),
                                  array ? array->size() : 1));
  joint.coordinates.resize(count);
  for (std::size_t k = 0; k < count; ++k) set(joint.coordinates[k], array ? *array->get(k) : *node);
}

void read_friction(const TomlTable& table, CoordinateSpec& c, const toml::node& node) {
  if (node.is_table()) {
    static constexpr std::string_view keys[] = {"positive", "negative"};
    const TomlTable both(*node.as_table(), table.file(), table.who() + ": friction", keys);
    for (const std::string_view key : keys)
      if (!both.find(key)) both.fail(fmt::format("{} is missing; give both directions or a single number", key));
    c.friction_positive = both.number("positive");
    c.friction_negative = both.number("negative");
  } else {
    c.friction_positive = c.friction_negative = table.number(node, "friction");
  }
}

void read_passive(const TomlTable& table, JointSpec& joint) {
  const auto plain = [&](std::string_view key, double CoordinateSpec::*field) {
    read_coordinates(table, key, joint,
                     [&](CoordinateSpec& c, const toml::node& node) { c.*field = table.number(node, key); });
  };
  plain("stiffness", &CoordinateSpec::stiffness);
  plain("rest", &CoordinateSpec::rest);
  plain("damping", &CoordinateSpec::damping);
  plain("friction_speed", &CoordinateSpec::friction_speed);
  plain("torque", &CoordinateSpec::torque);
  plain("armature", &CoordinateSpec::armature);
  read_coordinates(table, "friction", joint,
                   [&](CoordinateSpec& c, const toml::node& node) { read_friction(table, c, node); });
}

/// limits = [lower, upper] for one position coordinate, else one such pair per coordinate, [] for one without limits.
void read_limits(const TomlTable& table, JointSpec& joint) {
  const toml::node* node = table.find("limits");
  if (!node) return;
  const JointTraits& traits = joint.kind.traits();
  const auto pair = [&](const toml::node& entry) -> std::optional<LimitSpec> {
    const std::vector<double> values = table.numbers(entry, "limits");
    if (values.empty()) return std::nullopt;
    if (values.size() != 2) table.fail(entry, fmt::format("a limit is [lower, upper], not {} numbers", values.size()));
    return LimitSpec{values[0], values[1]};
  };
  if (traits.nq == 0) table.fail(*node, fmt::format("a {} joint has no position; remove limits", traits.name));
  if (traits.nq == 1) {
    joint.limits.push_back(pair(*node));
    return;
  }
  const toml::array* array = node->as_array();
  if (!array || array->size() != static_cast<std::size_t>(traits.nq))
    table.fail(*node, fmt::format("limits needs an array of {} pairs [lower, upper], or [] for none, for {}", traits.nq,
                                  fmt::join(traits.q_names.begin(), traits.q_names.begin() + traits.nq, ", ")));
  for (const toml::node& entry : *array) joint.limits.push_back(pair(entry));
}

JointSpec read_joint(const toml::table& source, const std::string& file) {
  static constexpr std::string_view keys[] = {
      "name",      "type", "parent",  "body",     "position",       "rpy",    "quaternion", "axis",   "axis2", "pitch",
      "stiffness", "rest", "damping", "friction", "friction_speed", "torque", "armature",   "limits", "motion"};
  const TomlTable table(source, file, label("joint", source), keys);
  JointSpec joint;
  joint.place = table.place();
  joint.name = table.name("name");
  const std::string type = table.name("type");
  const std::optional<JointKind> kind = find_joint_kind(type);
  if (!kind) {
    std::array<std::string_view, joint_kinds> names;
    for (unsigned char k = 0; k < joint_kinds; ++k) names[k] = JointKind{k}.traits().name;
    unknown_type(table, "joint", type, names);
  }
  joint.kind = *kind;
  joint.parent = body_or_ground(table, "parent");
  joint.body = table.name("body");
  joint.frame.position = table.vector("position");
  joint.frame.rotation = read_rotation(table);
  if (table.find("axis")) joint.axis = table.vector("axis");
  if (table.find("axis2")) joint.axis2 = table.vector("axis2");
  joint.pitch = table.number("pitch");
  read_passive(table, joint);
  read_limits(table, joint);
  if (table.find("motion")) joint.motion = read_motion(table);
  return joint;
}

PointSpringSpec read_spring(const toml::table& source, const std::string& file) {
  static constexpr std::string_view keys[] = {"name",    "body_a",    "body_b",  "point_a",
                                              "point_b", "stiffness", "damping", "rest_length"};
  const TomlTable table(source, file, label("spring", source), keys);
  PointSpringSpec spring;
  spring.place = table.place();
  spring.name = table.name("name");
  spring.body_a = body_or_ground(table, "body_a");
  spring.body_b = body_or_ground(table, "body_b");
  spring.point_a = table.vector("point_a");
  spring.point_b = table.vector("point_b");
  spring.stiffness = table.number("stiffness");
  spring.damping = table.number("damping");
  spring.rest_length = table.number("rest_length");
  return spring;
}

WrenchSpec read_wrench(const toml::table& source, const std::string& file) {
  static constexpr std::string_view keys[] = {"body", "moment", "force"};
  const TomlTable table(source, file, "a wrench", keys);
  WrenchSpec wrench;
  wrench.place = table.place();
  wrench.body = table.name("body");
  if (wrench.body == "ground") table.fail("a wrench on ground moves nothing; name a body");
  wrench.moment = table.vector("moment");
  wrench.force = table.vector("force");
  return wrench;
}

/// [state.q] or [state.v]: a number or an array per joint, into the joint's coordinates of `all`.
void read_coordinates_by_joint(const TomlTable& state, std::string_view key, const Model& model,
                               std::vector<double>& all) {
  const toml::table& source = state.table(key);
  if (source.empty()) return;
  const bool position = key == "q";
  std::unordered_map<std::string_view, int> index;
  std::vector<std::string_view> names;
  for (int i = 0; i < model.bodies(); ++i) {
    names.push_back(model.spec().joints[i].name);
    index.emplace(names.back(), i);
  }
  for (const auto& [joint, node] : source) {
    const auto found = index.find(joint.str());
    if (found == index.end()) state.unknown_key(joint, names);
    const Link& link = model.link(found->second);
    const JointTraits& traits = link.kind.traits();
    const int first = position ? link.q : link.v, count = position ? link.nq : link.nv;
    const std::string who = fmt::format("{} of joint {}", key, in_quotes(joint.str()));
    if (count == 0)
      state.fail(node,
                 fmt::format("{}: it has none{}; remove it", who, link.drive >= 0 ? ": its motion is prescribed" : ""));
    const std::vector<double> values =
        node.is_array() ? state.numbers(node, who) : std::vector<double>{state.number(node, who)};
    if (static_cast<int>(values.size()) != count) {
      const std::string_view* coordinate = position ? traits.q_names.data() : traits.v_names.data();
      state.fail(node, fmt::format("{} needs {} numbers ({}), not {}", who, count,
                                   fmt::join(coordinate, coordinate + count, ", "), values.size()));
    }
    std::copy(values.begin(), values.end(), all.begin() + first);
  }
}

State<double> read_state(const TomlTable& document, const Model& model) {
  State<double> state = neutral_state(model);
  if (!document.find("state")) return state;
  static constexpr std::string_view keys[] = {"t", "q", "v"};
  const TomlTable table(document.table("state"), document.file(), "state", keys);
  state.t = table.number("t");
  read_coordinates_by_joint(table, "q", model, state.q);
  read_coordinates_by_joint(table, "v", model, state.v);
  try {
    return checked_state(model, std::move(state));
  } catch (const InputError& error) {
    table.fail(table.find("q") ? *table.find("q") : *document.find("state"), error.what());
  }
}

}  // namespace

Mechanism load_toml_text(std::string_view text, const std::string& name) {
  static constexpr std::string_view keys[] = {"name",    "gravity", "length", "body",   "joint",
                                              "closure", "coupler", "spring", "wrench", "state"};
  const toml::table source = parse_toml(text, name);
  const TomlTable document(source, name, "model", keys);
  ModelSpec spec;
  spec.place = {name, 1, 1};
  spec.name = document.find("name") ? document.name("name") : std::filesystem::path(name).stem().string();
  spec.gravity = document.vector("gravity");
  if (document.find("length")) spec.length = document.number("length");
  for (const toml::table* table : document.tables("body")) spec.bodies.push_back(read_body(*table, name));
  for (const toml::table* table : document.tables("joint")) spec.joints.push_back(read_joint(*table, name));
  for (const toml::table* table : document.tables("closure")) spec.closures.push_back(read_closure(*table, name));
  for (const toml::table* table : document.tables("coupler"))
    spec.couplers.push_back(read_coupler(*table, name, spec.joints));
  for (const toml::table* table : document.tables("spring")) spec.springs.push_back(read_spring(*table, name));
  for (const toml::table* table : document.tables("wrench")) spec.wrenches.push_back(read_wrench(*table, name));
  if (spec.bodies.empty()) throw InputError(spec.place, "the model has no body; add a [[body]] and its [[joint]]");
  Model model = Model::build(spec);
  State<double> state = read_state(document, model);
  return {std::move(model), std::move(state)};
}

Mechanism load_toml(const std::string& path) { return load_toml_text(read_model_file(path), path); }

}  // namespace lanc
