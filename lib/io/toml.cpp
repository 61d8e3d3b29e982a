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
  // Read before they are written down: a comma initialiser that an exception leaves half filled stops the program.
  const double xy = tensor.number("xy"), xz = tensor.number("xz"), yz = tensor.number("yz");
  const Eigen::Vector3d diagonal(tensor.number("xx"), tensor.number("yy"), tensor.number("zz"));
  Eigen::Matrix3d I;
  I << diagonal.x(), xy, xz, xy, diagonal.y(), yz, xz, yz, diagonal.z();
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

void refuse_cut_joint(const TomlTable& state, std::string_view joint, const toml::node& node,
                      const GraphRecord& graph) {
  for (const LoopCut& cut : graph.cuts)
    if (cut.joint == joint)
      state.fail(node, fmt::format("joint {} has no coordinates, its loop is cut there; give those of the loop's other "
                                   "joints, or set cut = false at this one",
                                   in_quotes(joint)));
}

/// [state.q] or [state.v]: a number or an array per joint, into the joint's coordinates of `all`.
void read_coordinates_by_joint(const TomlTable& state, std::string_view key, const Model& model,
                               const GraphRecord& graph, std::vector<double>& all) {
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
    if (found == index.end()) {
      refuse_cut_joint(state, joint.str(), node, graph);
      state.unknown_key(joint, names);
    }
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

State<double> read_state(const TomlTable& document, const Model& model, const GraphRecord& graph) {
  State<double> state = neutral_state(model);
  if (!document.find("state")) return state;
  static constexpr std::string_view keys[] = {"t", "q", "v"};
  const TomlTable table(document.table("state"), document.file(), "state", keys);
  state.t = table.number("t");
  read_coordinates_by_joint(table, "q", model, graph, state.q);
  read_coordinates_by_joint(table, "v", model, graph, state.v);
  try {
    return with_reversed_joints(model, graph, checked_state(model, std::move(state)));
  } catch (const InputError& error) {
    table.fail(table.find("q") ? *table.find("q") : *document.find("state"), error.what());
  }
}

/// All [[joint]]s into spec.joints; when they form a graph they are returned, too.
std::vector<GraphJointSpec> read_joints(const TomlTable& document, ModelSpec& spec) {
  const std::vector<const toml::table*> tables = document.tables("joint");
  std::vector<GraphJointSpec> graph;
  const bool is_graph = !tables.empty() && is_of_graph(*tables[0]);
  for (const toml::table* table : tables) {
    if (is_of_graph(*table) != is_graph)
      document.fail(*table, fmt::format("{} is given by {}, but {} by {}; give all joints of a file in the same way",
                                        label("joint", *tables[0]), is_graph ? "body_a and body_b" : "parent and body",
                                        label("joint", *table), is_graph ? "parent and body" : "body_a and body_b"));
    if (is_graph) graph.push_back(read_graph_joint(*table, document.file()));
    spec.joints.push_back(is_graph ? graph.back().joint : read_joint(*table, document.file()));
  }
  return graph;
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
  std::vector<GraphJointSpec> graph = read_joints(document, spec);
  for (const toml::table* table : document.tables("closure")) spec.closures.push_back(read_closure(*table, name));
  for (const toml::table* table : document.tables("coupler"))
    spec.couplers.push_back(read_coupler(*table, name, spec.joints));
  for (const toml::table* table : document.tables("spring")) spec.springs.push_back(read_spring(*table, name));
  for (const toml::table* table : document.tables("wrench")) spec.wrenches.push_back(read_wrench(*table, name));
  if (spec.bodies.empty()) throw InputError(spec.place, "the model has no body; add a [[body]] and its [[joint]]");
  GraphRecord record;
  if (!graph.empty()) {
    spec.joints.clear();
    CutGraph cut = cut_loops({std::move(spec), std::move(graph)});
    spec = std::move(cut.model), record = std::move(cut.record);
  }
  Model model = Model::build(std::move(spec));
  State<double> state = read_state(document, model, record);
  return {std::move(model), std::move(state), std::move(record)};
}

Mechanism load_toml(const std::string& path) { return load_toml_text(read_model_file(path), path); }

}  // namespace lanc
