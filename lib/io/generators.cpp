#include "lib/io/generators.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <map>

#include "lib/io/draw_space.h"
#include "lib/io/four_bars.h"
#include "lib/io/random_loops.h"
#include "lib/io/random_tree.h"

namespace lanc {
namespace {

constexpr int most_random_loops = 1000;  // every row is compared with every other
constexpr int most_bodies = 2'000'000;   // about 3 GB with the specification

constexpr GeneratorInfo table[] = {
    {"chain", "chain:N[:joint=KIND][:seed=S][:gravity=G]",
     "N equal bodies in series, joint axes x, y, z, x, ... in turn (default: revolute)"},
    {"tree", "tree:N[:branching=B][:joint=KIND][:seed=S][:gravity=G]",
     "N bodies of the chain as a complete tree, body i on body (i-2)/B + 1 (default: B = 2)"},
    {"star", "star:N[:joint=KIND][:seed=S][:gravity=G]",
     "N bodies of the chain, the first on the ground, all others on the first"},
    {"random", "random:N[:seed=S][:kinds=A,B,...][:massless=no][:driven=no][:forces=no][:gravity=G]",
     "N bodies hung together at random: all joint kinds, massless bodies, prescribed motions, springs"},
    {"random-loops",
     "random-loops:N[:seed=S][:redundant=any|none|parallel|bennett|duplicate][:kinds=A,B,...][:massless=no][:driven=no]"
     "[:forces=no][:gravity=G]",
     "a random tree with N loops closed at random, all closure kinds; loops that are redundant because hinges are "
     "parallel, as Bennett linkages, or because a closure is there twice"},
    {"four-bar-ladder", "four-bar-ladder:N[:angle=A][:rate=R][:cut=point|hinge|weld][:gravity=G]",
     "N four-bars side by side on the ground: 2N + 1 rods of 1 m and 1 kg in the x-z plane, uprights A from the "
     "vertical "
     "(default 0.7 rad) turning at R (default 1 rad/s); closures: points at the tips (3 rows, 1 redundant), or welds "
     "in "
     "the middle of the uprights (6 rows, 3 redundant)"},
    {"four-bar-chain", "four-bar-chain:N[:angle=A][:rate=R][:cut=point|hinge|weld][:gravity=G]",
     "N four-bars in series, each on the coupler of the one before; options as four-bar-ladder"},
    {"four-bar-tree", "four-bar-tree:N[:branching=B][:angle=A][:rate=R][:cut=point|hinge|weld][:gravity=G]",
     "N four-bars as a complete tree, number i on the coupler of number (i-2)/B + 1 (default: B = 2); options as "
     "four-bar-ladder"},
    {"four-bar-nest", "four-bar-nest:N[:angle=A][:rate=R][:cut=point|hinge|weld][:gravity=G]",
     "N four-bars inside one another: N + 1 uprights under one coupler of N m; options as four-bar-ladder"},
    {"polygon", "polygon:N[:cut=point|hinge|weld][:gravity=G]",
     "one loop of N rods of 1 m and 1 kg: all sides but one of a regular polygon, at rest"},
};

[[noreturn]] void fail(std::string_view argument, const std::string& what) {
  throw InputError(fmt::format("model '{}': {}", argument, what));
}

/// The argument taken apart: size, and options that must all be asked for.
class Arguments {
 public:
  Arguments(std::string_view argument, const GeneratorInfo& info) : argument_(argument), usage_(info.usage) {
    std::vector<std::string_view> parts;
    for (std::string_view rest = argument;;) {
      const size_t colon = rest.find(':');
      parts.push_back(rest.substr(0, colon));
      if (colon == rest.npos) break;
      rest.remove_prefix(colon + 1);
    }
    if (parts.size() < 2) fail(argument, fmt::format("the number of bodies is missing; use {}", usage_));
    const auto n = whole<long long>(parts[1], true);
    if (!n) fail(argument, fmt::format("'{}' is not a number of bodies; use {}", parts[1], usage_));
    if (*n < 1 || *n > most_bodies)
      fail(argument, fmt::format("{} bodies; give a number from 1 to {}", parts[1], most_bodies));
    bodies = static_cast<int>(*n);
    for (size_t k = 2; k < parts.size(); ++k) {
      const size_t equals = parts[k].find('=');
      if (equals == parts[k].npos)
        fail(argument, fmt::format("'{}' is not of the form key=value; use {}", parts[k], usage_));
      if (!options_.emplace(parts[k].substr(0, equals), parts[k].substr(equals + 1)).second)
        fail(argument, fmt::format("option '{}' is given twice; keep one", parts[k].substr(0, equals)));
    }
  }

  int bodies = 0;

  std::optional<std::string_view> text(std::string_view key) {
    const auto found = options_.find(key);
    if (found == options_.end()) return std::nullopt;
    const std::string_view value = found->second;
    options_.erase(found);
    return value;
  }
  std::uint64_t seed() {
    const auto value = text("seed");
    if (!value) return 1;
    const auto seed = whole<std::uint64_t>(*value);
    if (!seed) fail(argument_, fmt::format("seed '{}' is not a whole number from 0 to 2^64 - 1", *value));
    return *seed;
  }
  int branching() {
    const auto value = text("branching");
    if (!value) return 2;
    const auto branching = whole<int>(*value);
    if (!branching || *branching < 1)
      fail(argument_, fmt::format("branching '{}' is not a whole number of 1 or more", *value));
    return *branching;
  }
  double number(std::string_view key, double preset, const char* example) {
    const auto value = text(key);
    if (!value) return preset;
    double x = 0;
    const auto [end, error] = std::from_chars(value->data(), value->data() + value->size(), x);
    if (error != std::errc() || end != value->data() + value->size() || !std::isfinite(x))
      fail(argument_, fmt::format("{} '{}' is not a number, such as {}", key, *value, example));
    return x;
  }
  /// m/s², downward.
  double gravity() { return number("gravity", 9.81, "9.81 or 0 (m/s^2)"); }
  /// Index of one of some words; the first is the default.
  int word(std::string_view key, const std::vector<std::string_view>& words) {
    const auto value = text(key);
    const auto found = value ? std::find(words.begin(), words.end(), *value) : words.begin();
    if (found == words.end())
      fail(argument_,
           fmt::format("{}={}; write {}={}", key, *value, key, fmt::join(words, fmt::format(" or {}=", key))));
    return static_cast<int>(found - words.begin());
  }
  bool yes(std::string_view key) { return word(key, {"yes", "no"}) == 0; }
  JointKind kind(std::string_view name) const {
    if (const auto kind = find_joint_kind(name)) return *kind;
    std::vector<std::string_view> names;
    for (unsigned char k = 0; k < joint_kinds; ++k) names.push_back(JointKind{k}.traits().name);
    fail(argument_, fmt::format("there is no joint '{}'; choose from {}", name, fmt::join(names, ", ")));
  }
  /// One kind, or with "mixed" all that move, in turn.
  std::vector<JointKind> joint() {
    const std::string_view name = text("joint").value_or("revolute");
    if (name != "mixed") return {kind(name)};
    std::vector<JointKind> kinds = all_kinds();
    std::erase_if(kinds, [](JointKind k) { return k.traits().nv == 0; });
    return kinds;
  }
  std::vector<JointKind> kinds() {
    const auto value = text("kinds");
    if (!value) return all_kinds();
    std::vector<JointKind> result;
    for (std::string_view rest = *value;;) {
      const size_t comma = rest.find(',');
      result.push_back(kind(rest.substr(0, comma)));
      if (comma == rest.npos) return result;
      rest.remove_prefix(comma + 1);
    }
  }
  /// To be called when every option has been asked for.
  void require_all_used() const {
    if (!options_.empty())
      fail(argument_, fmt::format("there is no option '{}'; use {}", options_.begin()->first, usage_));
  }

 private:
  /// A whole number; one too large for the type is its largest value where the caller has a bound of its own.
  template <class Integer>
  static std::optional<Integer> whole(std::string_view text, bool bounded = false) {
    Integer value{};
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (bounded && error == std::errc::result_out_of_range && text[0] != '-')
      return std::numeric_limits<Integer>::max();
    if (error != std::errc() || end != text.data() + text.size()) return std::nullopt;
    return value;
  }
  static std::vector<JointKind> all_kinds() {
    std::vector<JointKind> kinds(joint_kinds);
    for (unsigned char k = 0; k < joint_kinds; ++k) kinds[k] = {k};
    return kinds;
  }

  std::string_view argument_, usage_;
  std::map<std::string_view, std::string_view> options_;
};

/// The body all regular generators are made of.
BodySpec standard_body() {
  BodySpec body;
  body.mass = 1;
  body.com = {0.01, -0.02, 0.1};
  body.inertia << 4.5e-3, 2e-4, -1e-4,  //
      2e-4, 3.5e-3, 3e-4,               //
      -1e-4, 3e-4, 2e-3;
  return body;
}

/// n standard bodies, body i on body parent(i) (counted from 0; ground is −1): joints `kinds` in turn, axes x, y, z, x,
/// ... in turn, each joint 0.2 m along z from the origin of its predecessor.
template <class Parent>
ModelSpec regular(int n, const std::vector<JointKind>& kinds, Parent parent) {
  ModelSpec spec;
  spec.bodies.assign(n, standard_body());
  spec.joints.resize(n);
  for (int i = 0; i < n; ++i) {
    const std::string number = std::to_string(i + 1);
    spec.bodies[i].name = "b" + number;
    JointSpec& joint = spec.joints[i];
    joint.name = "j" + number;
    joint.body = spec.bodies[i].name;
    joint.kind = kinds[i % kinds.size()];
    if (const int p = parent(i); p != ground) joint.parent = spec.bodies[p].name;
    joint.frame.position = {0, 0, 0.2};
    const JointTraits& traits = joint.kind.traits();
    if (traits.axes != JointAxes::none) joint.axis = Eigen::Vector3d::Unit(i % 3);
    if (traits.axes == JointAxes::two) joint.axis2 = Eigen::Vector3d::Unit((i + 1) % 3);
    if (traits.has_pitch) joint.pitch = 0.1;
  }
  return spec;
}

/// Everything but their number.
RandomTreeOptions random_options(Arguments& arguments) {
  RandomTreeOptions options;
  options.kinds = arguments.kinds();
  options.massless = arguments.yes("massless");
  options.driven = arguments.yes("driven");
  options.forces = arguments.yes("forces");
  return options;
}

ModelSpec random(Arguments& arguments, Draw& draw) {
  RandomTreeOptions options = random_options(arguments);
  options.bodies = arguments.bodies;
  arguments.require_all_used();
  return random_tree(options, draw);
}

Mechanism random_loops(Arguments& arguments, const ModelSpec& frame, Draw& draw) {
  RandomLoopsOptions options;
  options.loops = arguments.bodies;
  if (options.loops > most_random_loops)
    fail(frame.name, fmt::format("{} loops; give a number from 1 to {}", options.loops, most_random_loops));
  options.tree = random_options(arguments);
  options.cause = RedundancyCause(arguments.word("redundant", {"any", "none", "parallel", "bennett", "duplicate"}));
  arguments.require_all_used();
  return random_loops(options, frame, draw);
}

ModelSpec regular(std::string_view name, Arguments& arguments) {
  const int branching = name == "tree" ? arguments.branching() : 1;
  const std::vector<JointKind> kinds = arguments.joint();
  arguments.require_all_used();
  if (name == "star") return regular(arguments.bodies, kinds, [](int i) { return i == 0 ? ground : 0; });
  return regular(arguments.bodies, kinds, [branching](int i) { return i == 0 ? ground : (i - 1) / branching; });
}

}  // namespace

std::span<const GeneratorInfo> generators() { return table; }

std::optional<Mechanism> generate(std::string_view argument) {
  const std::string_view name = argument.substr(0, argument.find(':'));
  const auto info = std::find_if(std::begin(table), std::end(table), [&](const auto& g) { return g.name == name; });
  if (info == std::end(table)) return std::nullopt;
  Arguments arguments(argument, *info);
  const double gravity = arguments.gravity();
  if (name.starts_with("four-bar") || name == "polygon") {
    FourBarOptions options{.loops = arguments.bodies, .gravity = gravity};
    if (name != "polygon") {
      options.angle = arguments.number("angle", options.angle, "0.7 (rad)");
      options.rate = arguments.number("rate", options.rate, "1 (rad/s)");
    }
    if (name == "four-bar-tree") options.branching = arguments.branching();
    options.cut = FourBarOptions::Cut(arguments.word("cut", {"point", "hinge", "weld"}));
    arguments.require_all_used();
    const auto make = name == "four-bar-ladder"  ? four_bar_ladder
                      : name == "four-bar-chain" ? four_bar_chain
                      : name == "four-bar-tree"  ? four_bar_tree
                      : name == "four-bar-nest"  ? four_bar_nest
                                                 : polygon;
    return make(options, std::string(argument));
  }
  Draw draw(arguments.seed());
  if (name == "random-loops") {
    ModelSpec frame;
    frame.name = argument;
    frame.gravity = {0, 0, -gravity};
    return random_loops(arguments, frame, draw);
  }
  ModelSpec spec = name == "random" ? random(arguments, draw) : regular(name, arguments);
  spec.name = argument;
  spec.gravity = {0, 0, -gravity};
  const Model model = Model::build(std::move(spec));
  return Mechanism{model, draw_state(model, draw)};
}

}  // namespace lanc
