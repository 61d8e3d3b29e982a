// A mechanism as a graph of joints: loops are found, and cut where the fewest closure conditions arise.
//
// In a tree every body hangs on one joint, and its axes are those of that joint's frame. In a graph any number of
// joints may end at a body, whose axes are its own; each joint says where it sits on both of its bodies.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "lib/model/model.h"

namespace lanc {

/// A joint between body a (`joint.parent`) and body b (`joint.body`); either may be ground (empty). `joint.frame` is
/// frame A, in own axes of body a. Coordinates are those of b against a, whichever of them turns out the predecessor.
struct GraphJointSpec {
  JointSpec joint;
  Placement frame_b;        // in own axes of body b; coincides with A at zero position
  std::optional<bool> cut;  // true: it becomes a closure; false: it stays in the tree; else the loader decides
};

struct GraphSpec {
  /// All but the joints, in own axes of the bodies: com and inertia, points of springs, frames of closures. Wrenches
  /// are about the origins of own axes.
  ModelSpec model;
  std::vector<GraphJointSpec> joints;
};

/// A joint that was cut, so that a loop became a tree and a closure.
struct LoopCut {
  std::string joint;
  JointKind kind;
  int conditions = 0;             // closure rows it became
  bool demanded = false;          // by the user
  std::vector<std::string> loop;  // joints of the loop, beginning with the cut one; of a long one both ends, and "…"
};

/// What became of a graph.
struct GraphRecord {
  std::vector<LoopCut> cuts;
  /// Joints whose body b became the predecessor, of kinds whose coordinates change thereby: those of a model and its
  /// states are the ones of a against b (lib/io/joint_reversal.h).
  std::vector<std::string> reversed;
};

struct CutGraph {
  ModelSpec model;
  GraphRecord record;
};

/// The tree with the largest sum of conditions 6 − f (prescribed joints: 6), so that every loop is cut at a joint of
/// its fewest. Joints that need coordinates (springs, dampers, friction, torques, armatures, limits, couplers) are cut
/// never, those with cut = false neither; of equal ones the later in the list, so that whoever writes the list decides.
/// Bodies keep their order; each body's axes become those of the joint that carries it. Closures of cut joints have the
/// joints' names and precede those of the specification. A cut free joint demands nothing, and vanishes.
/// Throws InputError naming place, thing and mend. O(joints log joints). Tested by tests/io/joint_graph_test.cpp.
CutGraph cut_loops(GraphSpec graph);

/// A state whose coordinates are those of b against a for all joints, in the coordinates of the model.
State<double> with_reversed_joints(const Model& model, const GraphRecord& record, State<double> state);

/// "loop (crank_pin, rod_end, slide, shaft) is cut at 'rod_end' (spherical, 3 conditions)".
std::string to_text(const LoopCut& cut);

}  // namespace lanc
