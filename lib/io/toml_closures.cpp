// [[closure]] and [[coupler]] of the native model format; data/models/README.md describes them for users.
#include <fmt/format.h>

#include <algorithm>

#include "lib/io/text.h"
#include "lib/io/toml_parts.h"

namespace lanc {
namespace {

std::vector<std::string> position_names(const JointKind kind) {
  const JointTraits& traits = kind.traits();
  return {traits.q_names.begin(), traits.q_names.begin() + traits.nq};
}

/// "joint" or "joint.coordinate" into the term's joint and coordinate. A name that has a dot of its own and is that of
/// a joint is the joint's.
void read_coordinate(const TomlTable& table, const toml::node& node, const std::vector<JointSpec>& joints,
                     CouplerSpec::Term& term) {
  const auto called = [&](const std::string& name) {
    return std::find_if(joints.begin(), joints.end(), [&](const JointSpec& j) { return j.name == name; });
  };
  term.joint = node.as_string()->get();
  if (const auto joint = called(term.joint); joint != joints.end()) {
    if (joint->kind.traits().nq > 1)
      table.fail(node, fmt::format("joint {} has several coordinates; write for example '{}.{}'", in_quotes(term.joint),
                                   term.joint, position_names(joint->kind)[0]));
    return;
  }
  const std::size_t dot = term.joint.rfind('.');
  if (dot == std::string::npos) return;
  const std::string coordinate = term.joint.substr(dot + 1);
  const auto joint = called(term.joint.substr(0, dot));
  if (joint == joints.end()) return;
  term.joint.resize(dot);
  const std::vector<std::string> known = position_names(joint->kind);
  const auto found = std::find(known.begin(), known.end(), coordinate);
  if (found == known.end())
    table.fail(node, known.empty() ? fmt::format("joint {} has no coordinate to couple", in_quotes(term.joint))
                                   : fmt::format("joint {} has no coordinate {}; it has {}", in_quotes(term.joint),
                                                 in_quotes(coordinate), fmt::join(known, ", ")));
  term.coordinate = static_cast<int>(found - known.begin());
}

}  // namespace

ClosureSpec read_closure(const toml::table& source, const std::string& file) {
  static constexpr std::string_view keys[] = {"name",       "type",  "body_a", "body_b",       "position_a",
                                              "position_b", "rpy_a", "rpy_b",  "quaternion_a", "quaternion_b",
                                              "axis",       "axis2", "pitch",  "length",       "motion"};
  const TomlTable table(source, file, label("closure", source), keys);
  ClosureSpec closure;
  closure.place = table.place();
  closure.name = table.name("name");
  const std::string type = table.name("type");
  const std::optional<ClosureKind> kind = find_closure_kind(type);
  if (!kind) {
    std::vector<std::string_view> names;
    for (const ClosureTraits& traits : closures::all_closures) names.push_back(traits.name);
    unknown_type(table, "closure", type, names);
  }
  closure.kind = *kind;
  closure.body_a = body_or_ground(table, "body_a");
  closure.body_b = body_or_ground(table, "body_b");
  closure.frame_a = read_placement(table, "_a");
  closure.frame_b = read_placement(table, "_b");
  if (table.find("axis")) closure.axis = table.vector("axis");
  if (table.find("axis2")) closure.axis2 = table.vector("axis2");
  closure.pitch = table.number("pitch");
  closure.length = table.number("length");
  if (table.find("motion")) closure.motion = read_motion(table);
  return closure;
}

CouplerSpec read_coupler(const toml::table& source, const std::string& file, const std::vector<JointSpec>& joints) {
  static constexpr std::string_view keys[] = {"name", "coordinates", "factors", "offset", "motion"};
  const TomlTable table(source, file, label("coupler", source), keys);
  CouplerSpec coupler;
  coupler.place = table.place();
  coupler.name = table.name("name");
  const toml::node* node = table.find("coordinates");
  const toml::array* names = node ? node->as_array() : nullptr;
  if (!names) table.fail("coordinates is missing; give an array such as [\"crank\", \"wheel.angle\"]");
  const std::vector<double> factors = table.numbers("factors");
  if (factors.size() != names->size())
    table.fail(*node,
               fmt::format("{} coordinates and {} factors; give one factor each", names->size(), factors.size()));
  for (std::size_t k = 0; k < factors.size(); ++k) {
    const toml::node& name = *names->get(k);
    if (!name.is_string()) table.fail(name, "a coordinate is named by a string: a joint, or joint.coordinate");
    CouplerSpec::Term term{{}, 0, factors[k]};
    read_coordinate(table, name, joints, term);
    coupler.terms.push_back(std::move(term));
  }
  coupler.offset = table.number("offset");
  if (table.find("motion")) coupler.motion = read_motion(table);
  return coupler;
}

}  // namespace lanc
