// What is left of a mechanism while bodies and closures are eliminated from it.
// Private to formulations/recursive-loops.
#pragma once

#include <queue>
#include <utility>
#include <vector>

#include "formulations/recursive-loops/elimination_plan.h"

namespace lanc {

/// The graph of what is not eliminated yet. Of what its rule admits the node of least degree goes first.
class QuotientGraph {
 public:
  using Set = std::vector<int>;  // ascending
  struct Body {
    Set closures;  // it meets
    Set met;       // all it ever met
    int children_left = 0;
  };
  struct Closure {
    int row = 0, rows = 0;
    Set bodies, closures;     // it meets
    int velocities_left = 0;  // a coupler's, whose bodies are still there
    bool grounded = false;    // one side of its loop is gone down to the ground
  };

  QuotientGraph(const Model& model, EliminationRule rule);

  /// Nodes that may be eliminated, of least degree first: body i or −1 − closure.
  bool next(int& node);
  void eliminate_body(int i);
  void eliminate_closure(int c);

  /// Rows a node meets.
  int degree(int node) const;

  const Body& body(int i) const { return bodies_[i]; }
  const Closure& closure(int c) const { return closures_[c]; }
  int closures() const { return static_cast<int>(closures_.size()); }

 private:
  void meet(int closure, int body);
  bool admitted(int node) const;
  void consider(int node) {
    if (admitted(node)) queue_.emplace(degree(node), node);
  }

  const Model& model_;
  EliminationRule rule_;
  std::vector<Body> bodies_;
  std::vector<Closure> closures_;
  std::vector<char> body_gone_, closure_gone_;
  std::vector<Set> couplers_on_;  // per body
  std::priority_queue<std::pair<int, int>, std::vector<std::pair<int, int>>, std::greater<>> queue_;
};

}  // namespace lanc
