// [[joint]] of the native model format, of a tree and of a graph; data/models/README.md describes them for users.
#include <fmt/format.h>

#include <array>

#include "lib/io/text.h"
#include "lib/io/toml_parts.h"

namespace lanc {
namespace {

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

/// What the joints of a tree and of a graph have in common.
JointSpec read_common(const TomlTable& table) {
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
  if (table.find("axis")) joint.axis = table.vector("axis");
  if (table.find("axis2")) joint.axis2 = table.vector("axis2");
  joint.pitch = table.number("pitch");
  read_passive(table, joint);
  read_limits(table, joint);
  if (table.find("motion")) joint.motion = read_motion(table);
  return joint;
}

}  // namespace

bool is_of_graph(const toml::table& joint) { return joint.contains("body_a") || joint.contains("body_b"); }

JointSpec read_joint(const toml::table& source, const std::string& file) {
  static constexpr std::string_view keys[] = {
      "name",      "type", "parent",  "body",     "position",       "rpy",    "quaternion", "axis",   "axis2", "pitch",
      "stiffness", "rest", "damping", "friction", "friction_speed", "torque", "armature",   "limits", "motion"};
  const TomlTable table(source, file, label("joint", source), keys);
  JointSpec joint = read_common(table);
  joint.parent = body_or_ground(table, "parent");
  joint.body = table.name("body");
  joint.frame = read_placement(table);
  return joint;
}

GraphJointSpec read_graph_joint(const toml::table& source, const std::string& file) {
  static constexpr std::string_view keys[] = {
      "name",         "type",         "body_a",   "body_b",         "position_a", "position_b", "rpy_a", "rpy_b",
      "quaternion_a", "quaternion_b", "axis",     "axis2",          "pitch",      "stiffness",  "rest",  "damping",
      "friction",     "torque",       "armature", "friction_speed", "limits",     "motion",     "cut"};
  const TomlTable table(source, file, label("joint", source), keys);
  GraphJointSpec result;
  result.joint = read_common(table);
  result.joint.parent = body_or_ground(table, "body_a");
  result.joint.body = body_or_ground(table, "body_b");
  result.joint.frame = read_placement(table, "_a");
  result.frame_b = read_placement(table, "_b");
  if (table.find("cut")) result.cut = table.flag("cut");
  return result;
}

}  // namespace lanc
