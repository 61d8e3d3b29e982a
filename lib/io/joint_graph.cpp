#include "lib/io/joint_graph.h"

#include <fmt/format.h>

#include <algorithm>
#include <deque>
#include <numeric>
#include <unordered_map>
#include <unordered_set>

#include "lib/io/joint_reversal.h"
#include "lib/io/text.h"
#include "lib/model/validate.h"

namespace lanc {
namespace {

constexpr int most_joints_named = 50;  // of one loop, so that many long loops do not fill the memory
constexpr int most_joints_told = 8;    // in a message

/// `inner` is given in `outer`.
Placement operator*(const Placement& outer, const Placement& inner) {
  return {outer.rotation * inner.rotation, outer.rotation * inner.position + outer.position};
}

Placement inverse(const Placement& p) { return {p.rotation.transpose(), -(p.rotation.transpose() * p.position)}; }

std::string in_words(const std::string& body) { return body.empty() ? std::string("ground") : in_quotes(body); }
std::string who(const JointSpec& joint) { return "joint " + in_quotes(joint.name); }

std::string listed(const std::vector<std::string>& names) {
  std::string text;
  const int count = static_cast<int>(names.size());
  for (int k = 0; k < count; ++k) {
    if (k >= most_joints_told - 1 && k + 1 < count && count > most_joints_told) {
      if (k == most_joints_told - 1) text += ", …";
      continue;
    }
    text += (k == 0 ? "" : ", ") + names[k];
  }
  return text;
}

int conditions(const JointSpec& joint) { return joint.motion ? 6 : 6 - joint.kind.traits().nv; }

/// What of the joint only a joint of the tree can have; empty when nothing.
std::string needs_coordinates(const JointSpec& joint, bool coupled) {
  for (const CoordinateSpec& c : joint.coordinates) {
    if (c.stiffness != 0) return "a spring";
    if (c.damping != 0) return "damping";
    if (c.friction_positive != 0 || c.friction_negative != 0) return "friction";
    if (c.torque != 0) return "a torque";
    if (c.armature != 0) return "an armature";
  }
  for (const auto& limit : joint.limits)
    if (limit) return "limits";
  return coupled ? "a coupler" : "";
}

/// Sets of connected vertices.
class Components {
 public:
  explicit Components(int size) : parent_(size) { std::iota(parent_.begin(), parent_.end(), 0); }
  int root(int i) {
    while (parent_[i] != i) i = parent_[i] = parent_[parent_[i]];
    return i;
  }
  bool join(int i, int j) {
    const int a = root(i), b = root(j);
    parent_[std::max(a, b)] = std::min(a, b);
    return a != b;
  }

 private:
  std::vector<int> parent_;
};

/// Cuts a graph; one use. Vertex 0 is ground, vertex i + 1 body i.
class Cutter {
 public:
  explicit Cutter(GraphSpec graph)
      : graph_(std::move(graph)),
        vertices_(static_cast<int>(graph_.model.bodies.size()) + 1),
        in_tree_(graph_.joints.size(), false) {}

  CutGraph cut() {
    check();
    choose_tree();
    root_at(0);
    check_connected();
    CutGraph result;
    result.record = record();
    build_tree(result);
    return result;
  }

 private:
  struct Edge {
    int a, b;
    std::string needs;  // what keeps it in the tree
  };

  int count() const { return static_cast<int>(graph_.joints.size()); }
  const JointSpec& joint(int j) const { return graph_.joints[j].joint; }

  int vertex(const std::string& body, const Place& place, const std::string& whose) const {
    if (body.empty()) return 0;
    const auto found = index_.find(body);
    if (found == index_.end())
      throw InputError(place,
                       fmt::format("{}: there is no body {}; define it or mend the name", whose, in_quotes(body)));
    return found->second;
  }

  void check() {
    if (!graph_.model.joints.empty())
      throw InputError(graph_.model.place, "a graph of joints and joints of a tree at once; give one of them");
    for (int i = 1; i < vertices_; ++i) {
      const BodySpec& body = graph_.model.bodies[i - 1];
      if (!index_.emplace(body.name, i).second)
        throw InputError(body.place, fmt::format("two bodies are called {}; rename one", in_quotes(body.name)));
      validate(body);
    }
    std::unordered_set<std::string_view> coupled, names;
    for (const CouplerSpec& coupler : graph_.model.couplers)
      for (const CouplerSpec::Term& term : coupler.terms) coupled.insert(term.joint);
    for (const GraphJointSpec& g : graph_.joints) {
      validate(g.joint);
      JointSpec other_end = g.joint;
      other_end.frame = g.frame_b;
      validate(other_end);
      const Place& place = g.joint.place;
      if (!names.insert(g.joint.name).second)
        throw InputError(place, fmt::format("two joints are called {}; rename one", in_quotes(g.joint.name)));
      Edge edge{vertex(g.joint.parent, place, who(g.joint)), vertex(g.joint.body, place, who(g.joint)), {}};
      if (edge.a == edge.b)
        throw InputError(place, fmt::format("{}: it connects {} to itself; a joint needs two bodies, or a body and "
                                            "ground",
                                            who(g.joint), in_words(g.joint.body)));
      edge.needs = needs_coordinates(g.joint, coupled.count(g.joint.name) > 0);
      if (g.cut.value_or(false) && !edge.needs.empty())
        throw InputError(place,
                         fmt::format("{}: it is cut, and a joint that is cut has no coordinates, but it has {}; set "
                                     "cut = true at another joint of the loop, or remove {}",
                                     who(g.joint), edge.needs, edge.needs));
      edges_.push_back(std::move(edge));
    }
  }

  /// 0: demanded by the user; 1: needed; then by conditions.
  int rank(int j) const {
    if (graph_.joints[j].cut) return 0;
    if (!edges_[j].needs.empty()) return 1;
    return 2 + 6 - conditions(joint(j));
  }

  /// Kruskal's algorithm.
  void choose_tree() {
    std::vector<int> order;
    for (int j = 0; j < count(); ++j)
      if (!graph_.joints[j].cut.value_or(false)) order.push_back(j);
    std::stable_sort(order.begin(), order.end(), [&](int i, int j) { return rank(i) < rank(j); });
    Components components(vertices_);
    for (const int j : order) {
      if (components.join(edges_[j].a, edges_[j].b))
        in_tree_[j] = true;
      else if (rank(j) < 2)
        throw_uncuttable_loop(j);
    }
  }

  [[noreturn]] void throw_uncuttable_loop(int j) {
    root_at(edges_[j].b);
    const std::vector<std::string> loop = loop_of(j);
    std::string why = "they have cut = false";
    if (rank(j) == 1)
      why = fmt::format("they have cut = false, or need coordinates ({} has {})", in_quotes(joint(j).name),
                        edges_[j].needs);
    throw InputError(
        joint(j).place,
        fmt::format("{}: it closes the loop ({}), in which no joint may be cut: {}; let one of them be cut, "
                    "or remove what needs coordinates from one",
                    who(joint(j)), listed(loop), why));
  }

  /// Fills carrier_ and depth_ of what the chosen joints connect to `root`, in the order of the joints.
  void root_at(int root) {
    std::vector<std::vector<int>> at(vertices_);
    for (int j = 0; j < count(); ++j)
      if (in_tree_[j]) at[edges_[j].a].push_back(j), at[edges_[j].b].push_back(j);
    carrier_.assign(vertices_, -1);
    depth_.assign(vertices_, -1);
    depth_[root] = 0;
    for (std::deque<int> queue{root}; !queue.empty(); queue.pop_front()) {
      const int from = queue.front();
      for (const int j : at[from]) {
        const int to = other_end(j, from);
        if (depth_[to] >= 0) continue;
        depth_[to] = depth_[from] + 1;
        carrier_[to] = j;
        queue.push_back(to);
      }
    }
  }

  int other_end(int j, int vertex) const { return edges_[j].a == vertex ? edges_[j].b : edges_[j].a; }

  /// Joint j, which is not in the tree, and those from its body b back to its body a.
  std::vector<std::string> loop_of(int j) const {
    std::vector<std::string> from_b = {joint(j).name}, from_a;
    int a = edges_[j].a, b = edges_[j].b;
    const auto climb = [&](int& vertex, std::vector<std::string>& names) {
      names.push_back(joint(carrier_[vertex]).name);
      vertex = other_end(carrier_[vertex], vertex);
    };
    while (a != b && static_cast<int>(from_a.size() + from_b.size()) < most_joints_named) {
      if (depth_[b] >= depth_[a])
        climb(b, from_b);
      else
        climb(a, from_a);
    }
    if (a != b) from_b.push_back("…");
    from_b.insert(from_b.end(), from_a.rbegin(), from_a.rend());
    return from_b;
  }

  void check_connected() const {
    std::vector<std::string> lost;
    for (int i = 1; i < vertices_; ++i)
      if (depth_[i] < 0) lost.push_back(graph_.model.bodies[i - 1].name);
    if (lost.empty()) return;
    for (int j = 0; j < count(); ++j)
      if (!in_tree_[j] && (depth_[edges_[j].a] < 0) != (depth_[edges_[j].b] < 0))
        throw InputError(joint(j).place,
                         fmt::format("{}: it is cut, and then nothing connects {} ({}) to ground; remove cut = true "
                                     "here or at another joint of the loop",
                                     who(joint(j)), lost.size() == 1 ? "a body" : "bodies", listed(lost)));
    const BodySpec& body = graph_.model.bodies[*index_of_first_lost() - 1];
    throw InputError(
        body.place,
        fmt::format("body {} is not connected to ground{}; add a joint to ground, of type free where "
                    "nothing holds it",
                    in_quotes(body.name), lost.size() == 1 ? "" : fmt::format(" (nor are all of {})", listed(lost))));
  }

  std::optional<int> index_of_first_lost() const {
    for (int i = 1; i < vertices_; ++i)
      if (depth_[i] < 0) return i;
    return std::nullopt;
  }

  GraphRecord record() const {
    GraphRecord record;
    for (int j = 0; j < count(); ++j) {
      if (!in_tree_[j])
        record.cuts.push_back(
            {joint(j).name, joint(j).kind, conditions(joint(j)), graph_.joints[j].cut.has_value(), loop_of(j)});
      else if (is_reversed(j) && reversal_changes_coordinates(joint(j).kind))
        record.reversed.push_back(joint(j).name);
    }
    return record;
  }

  /// Body b is the predecessor.
  bool is_reversed(int j) const { return carrier_[edges_[j].a] == j; }

  void build_tree(CutGraph& result) {
    std::vector<Placement> own(vertices_);  // own axes in axes of the tree
    for (int i = 1; i < vertices_; ++i) {
      const GraphJointSpec& g = graph_.joints[carrier_[i]];
      own[i] = inverse(is_reversed(carrier_[i]) ? g.joint.frame : g.frame_b);
    }
    ModelSpec& model = graph_.model;
    for (int i = 1; i < vertices_; ++i) {
      const GraphJointSpec& g = graph_.joints[carrier_[i]];
      JointSpec joint = is_reversed(carrier_[i]) ? reversed(g.joint, g.frame_b) : g.joint;
      joint.frame = own[vertex(joint.parent, joint.place, {})] * joint.frame;
      model.joints.push_back(std::move(joint));
      move(model.bodies[i - 1], own[i]);
    }
    add_closures(model, own);
    for (PointSpringSpec& s : model.springs) {
      const std::string whose = "spring " + in_quotes(s.name);
      move(s.point_a, own[vertex(s.body_a, s.place, whose)]);
      move(s.point_b, own[vertex(s.body_b, s.place, whose)]);
    }
    for (const WrenchSpec& wrench : model.wrenches) check_wrench(wrench, own);
    for (CouplerSpec& coupler : model.couplers) turn(coupler, result.record);
    result.model = std::move(model);
  }

  static void move(Eigen::Vector3d& point, const Placement& own) { point = own.rotation * point + own.position; }

  static void move(BodySpec& body, const Placement& own) {
    move(body.com, own);
    const Eigen::Matrix3d I = own.rotation * body.inertia * own.rotation.transpose();
    body.inertia = (I + I.transpose()) / 2;  // exactly symmetric after the rotation
  }

  /// Closures of cut joints, then those of the specification.
  void add_closures(ModelSpec& model, const std::vector<Placement>& own) const {
    std::vector<ClosureSpec> closures;
    for (int j = 0; j < count(); ++j) {
      const std::optional<ClosureKind> kind = find_closure_kind(joint(j).kind.traits().name);
      if (in_tree_[j] || !kind) continue;  // a free joint demands nothing
      const JointSpec& cut = joint(j);
      closures.push_back({cut.name, *kind, cut.parent, cut.body, own[edges_[j].a] * cut.frame,
                          own[edges_[j].b] * graph_.joints[j].frame_b, cut.axis, cut.axis2, cut.pitch, 0, cut.motion,
                          cut.place});
    }
    for (ClosureSpec& c : model.closures) {
      const std::string whose = "closure " + in_quotes(c.name);
      c.frame_a = own[vertex(c.body_a, c.place, whose)] * c.frame_a;
      c.frame_b = own[vertex(c.body_b, c.place, whose)] * c.frame_b;
      closures.push_back(std::move(c));
    }
    model.closures = std::move(closures);
  }

  /// A constant force through a point that is not the reference point has a moment that turns with the body.
  void check_wrench(const WrenchSpec& wrench, const std::vector<Placement>& own) const {
    const int i = vertex(wrench.body, wrench.place, "wrench");
    if (i == 0) throw InputError(wrench.place, "a wrench on ground moves nothing; name a body");
    if (wrench.force.isZero(0) || own[i].position.isZero(0)) return;
    throw InputError(wrench.place,
                     fmt::format("wrench on {}: in a graph its force acts at the origin of the body's own axes, which "
                                 "must be where {}, the joint that carries it, is; put the origin there, or keep "
                                 "another joint with cut = false",
                                 in_quotes(wrench.body), who(joint(carrier_[i]))));
  }

  /// The couplers' coordinates in those of reversed joints.
  void turn(CouplerSpec& coupler, const GraphRecord& record) const {
    for (CouplerSpec::Term& term : coupler.terms) {
      if (std::find(record.reversed.begin(), record.reversed.end(), term.joint) == record.reversed.end()) continue;
      const auto found = std::find_if(graph_.model.joints.begin(), graph_.model.joints.end(),
                                      [&](const JointSpec& j) { return j.name == term.joint; });
      term.coordinate = reversed_coordinate(found->kind, term.coordinate);
      if (term.coordinate < 0)
        throw InputError(coupler.place,
                         fmt::format("coupler {}: in the tree body {} of {} became the successor, and its x and y are "
                                     "coordinates no more; exchange its body_a and body_b",
                                     in_quotes(coupler.name), in_words(found->body), who(*found)));
    }
  }

  GraphSpec graph_;
  int vertices_;
  std::unordered_map<std::string, int> index_;
  std::vector<Edge> edges_;
  std::vector<bool> in_tree_;
  std::vector<int> carrier_, depth_;  // per vertex: joint towards the root, −1 at the root and where there is none
};

}  // namespace

CutGraph cut_loops(GraphSpec graph) { return Cutter(std::move(graph)).cut(); }

State<double> with_reversed_joints(const Model& model, const GraphRecord& record, State<double> state) {
  if (record.reversed.empty()) return state;
  const std::unordered_set<std::string_view> names(record.reversed.begin(), record.reversed.end());
  for (int i = 0; i < model.bodies(); ++i) {
    const Link& link = model.link(i);
    if (names.count(model.spec().joints[i].name) > 0 && link.nv > 0)
      reverse_coordinates(link.kind, state.q.data() + link.q, state.v.data() + link.v);
  }
  return state;
}

std::string to_text(const LoopCut& cut) {
  return fmt::format("loop ({}) is cut at {} ({}, {} conditions{})", listed(cut.loop), in_quotes(cut.joint),
                     cut.kind.traits().name, cut.conditions, cut.demanded ? ", as the model says" : "");
}

}  // namespace lanc
