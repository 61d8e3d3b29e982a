#include "formulations/recursive-loops/elimination_plan.h"

#include <algorithm>
#include <stdexcept>
#include <utility>

#include "formulations/recursive-loops/quotient_graph.h"

namespace lanc {
namespace {

using Set = QuotientGraph::Set;

/// Runs the elimination and writes down what the numeric one does. Two passes: places in the Delassus matrix and in the
/// columns of a body are known only when it is known what they ever meet.
class Planner {
 public:
  Planner(const Model& model, EliminationRule rule, EliminationPlan& plan)
      : model_(model), plan_(plan), graph_(model, rule) {}
  void run(double most_operations);

 private:
  void lay_out_columns();
  void lay_out_blocks();
  int block_of(int first, int second) const;
  void write_body(int i);
  void write_closure(int c);
  Range write_meetings(const Set& around, const std::vector<int>& places);
  int column_at(int body, int closure) const;
  int strips(int closure) const { return graph_.closure(closure).rows / plan_.width; }
  Attachment attachment(int closure, int column, int block, int left);

  const Model& model_;
  EliminationPlan& plan_;
  QuotientGraph graph_;
  std::vector<int> order_;
  std::vector<Set> body_around_, closure_around_;  // closures met when eliminated
  std::vector<int> frontier_, position_;           // per closure: the body left, the step it goes
  std::vector<Set> columns_of_;                    // per body: closures in the order of its columns
  std::vector<char> touched_;                      // per body: something was handed to its inertia
  std::vector<char> columns_touched_, blocks_touched_;
  std::vector<int> first_column_;  // per body
  std::vector<int> block_;         // per closure, of it with itself
};

void Planner::run(double most_operations) {
  body_around_.resize(model_.bodies());
  closure_around_.resize(graph_.closures());
  frontier_.assign(graph_.closures(), -1);
  position_.assign(graph_.closures(), -1);
  double operations = 0;  // at least
  for (int node = 0; graph_.next(node);) {
    const double met = graph_.degree(node);
    operations += met * met;
    if (operations > most_operations) {
      plan_.operations = std::numeric_limits<double>::infinity();
      return;
    }
    if (node >= 0) {
      body_around_[node] = graph_.body(node).closures;
      graph_.eliminate_body(node);
    } else {
      const int c = -1 - node;
      closure_around_[c] = graph_.closure(c).closures;
      if (!graph_.closure(c).bodies.empty()) frontier_[c] = graph_.closure(c).bodies.front();
      position_[c] = static_cast<int>(order_.size());
      graph_.eliminate_closure(c);
    }
    order_.push_back(node);
  }
  touched_.resize(model_.bodies());
  lay_out_columns();
  lay_out_blocks();
  for (const int node : order_) {
    if (node >= 0)
      write_body(node);
    else
      write_closure(-1 - node);
  }
}

/// On each body first the closures it meets when it is eliminated, then those that go before it.
void Planner::lay_out_columns() {
  columns_of_.resize(model_.bodies());
  first_column_.resize(model_.bodies());
  for (const int i : order_) {
    if (i < 0) continue;
    Set& columns = columns_of_[i] = body_around_[i];
    const auto alive = static_cast<std::ptrdiff_t>(columns.size());
    for (const int c : graph_.body(i).met)
      if (!std::binary_search(columns.begin(), columns.begin() + alive, c)) columns.push_back(c);
    first_column_[i] = plan_.columns;
    for (const int c : columns) plan_.columns += strips(c);
  }
  columns_touched_.resize(plan_.columns);
  const ClosureSet& set = model_.closures();
  for (int c = 0; c < static_cast<int>(set.closures.size()); ++c) {
    const Closure& closure = set.closures[c];
    const auto column = [&](int body) {
      if (body == ground) return -1;
      const int at = column_at(body, c);
      columns_touched_[at] = true;
      return at;
    };
    plan_.ends.push_back({closure.row / plan_.width, strips(c), closure.body_a, closure.body_b, column(closure.body_a),
                          column(closure.body_b)});
  }
}

int Planner::column_at(int body, int closure) const {
  int column = first_column_[body];
  for (const int c : columns_of_[body]) {
    if (c == closure) break;
    column += strips(c);
  }
  return column;
}

/// The blocks of a closure with itself and with those it meets stand one behind the other.
void Planner::lay_out_blocks() {
  block_.resize(graph_.closures());
  for (const int node : order_) {
    if (node >= 0) continue;
    const int c = -1 - node, rows = graph_.closure(c).rows;
    block_[c] = plan_.delassus;
    plan_.delassus += rows * strips(c);
    for (const int d : closure_around_[c]) plan_.delassus += rows * strips(d);
  }
  blocks_touched_.resize(plan_.delassus);
}

/// `first` goes before `second`, or is it.
int Planner::block_of(int first, int second) const {
  const int rows = graph_.closure(first).rows;
  int block = block_[first];
  if (first == second) return block;
  block += rows * strips(first);
  for (const int d : closure_around_[first]) {
    if (d == second) break;
    block += rows * strips(d);
  }
  return block;
}

/// `left`: the body that is left, or the ground.
Attachment Planner::attachment(int closure, int column, int block, int left) {
  const int to = left < 0 ? -1 : column_at(left, closure);
  const bool first = to >= 0 && !std::exchange(columns_touched_[to], true);
  return {graph_.closure(closure).row / plan_.width, strips(closure), column, block, to, first};
}

/// All pairs of closures around a node; `places`: columns or blocks of the step.
Range Planner::write_meetings(const Set& around, const std::vector<int>& places) {
  Range range{static_cast<int>(plan_.meetings.size()), 0};
  for (std::size_t a = 0; a < around.size(); ++a)
    for (std::size_t b = a; b < around.size(); ++b) {
      const bool swap = position_[around[a]] > position_[around[b]];
      const std::size_t first = swap ? b : a, second = swap ? a : b;
      const int c = around[first], d = around[second];
      const int block = block_of(c, d);
      const bool untouched = !std::exchange(blocks_touched_[block], true);
      plan_.meetings.push_back({places[first], places[second], strips(c), strips(d), block, untouched});
    }
  range.end = static_cast<int>(plan_.meetings.size());
  return range;
}

void Planner::write_body(int i) {
  const Link& link = model_.link(i);
  BodyStep step{.body = i, .parent = link.parent, .v = link.v, .nv = link.nv, .first_column = first_column_[i]};
  step.columns = 0;
  step.attachments.begin = static_cast<int>(plan_.attachments.size());
  std::vector<int> columns;
  for (const int c : body_around_[i]) {
    columns.push_back(step.columns);
    plan_.attachments.push_back(attachment(c, step.columns, -1, link.parent));
    step.columns += strips(c);
  }
  step.attachments.end = static_cast<int>(plan_.attachments.size());
  step.untouched = !touched_[i];
  if (link.parent != ground) step.first_to_parent = !std::exchange(touched_[link.parent], true);
  step.meetings = write_meetings(body_around_[i], columns);
  const int rows = step.columns * plan_.width;
  plan_.operations += 180 + rows * (18.0 + link.nv * (17 + rows));
  step.terms.begin = static_cast<int>(plan_.terms.size());
  const ClosureSet& set = model_.closures();
  for (std::size_t at = 0; at < body_around_[i].size(); ++at) {
    const int coupler = body_around_[i][at] - static_cast<int>(set.closures.size());
    if (coupler < 0) continue;
    for (const Coupler::Term& term : set.couplers[coupler].terms)
      if (model_.body_of_velocity(term.v) == i)
        plan_.terms.push_back({term.v - link.v, columns[at], set.couplers[coupler].row, term.factor});
  }
  step.terms.end = static_cast<int>(plan_.terms.size());
  step.responses = plan_.responses;
  plan_.responses += link.nv * step.columns;
  plan_.most_responses = std::max(plan_.most_responses, link.nv * step.columns);
  plan_.order.push_back(static_cast<int>(plan_.bodies.size()));
  plan_.bodies.push_back(step);
}

void Planner::write_closure(int c) {
  const auto& closure = graph_.closure(c);
  const int body = frontier_[c], m = closure.rows;
  ClosureStep step{.strip = closure.row / plan_.width,
                   .strips = strips(c),
                   .block = block_[c],
                   .weights = plan_.weights,
                   .body = body,
                   .first_column = body < 0 ? -1 : column_at(body, c)};
  plan_.weights += m * strips(c);
  if (body >= 0) step.first_to_body = !std::exchange(touched_[body], true);
  step.attachments.begin = static_cast<int>(plan_.attachments.size());
  std::vector<int> blocks;
  int columns = m;
  for (const int d : closure_around_[c]) {
    blocks.push_back(block_of(c, d));
    plan_.attachments.push_back(attachment(d, -1, blocks.back(), body));
    columns += graph_.closure(d).rows;
  }
  step.attachments.end = static_cast<int>(plan_.attachments.size());
  step.meetings = write_meetings(closure_around_[c], blocks);
  plan_.operations += m * columns * (2.0 * m + columns + (body < 0 ? 0 : 12)) + (body < 0 ? 0 : 42 * m);
  plan_.order.push_back(-1 - static_cast<int>(plan_.closures.size()));
  plan_.closures.push_back(step);
}

}  // namespace

EliminationPlan::EliminationPlan(const Model& model, int strip_width, EliminationRule rule, double most_operations)
    : width(strip_width) {
  if (width != 1 && width != rows_each(model))
    throw std::logic_error("a strip of several rows must be a whole closure");
  Planner(model, rule, *this).run(most_operations);
}

int rows_each(const Model& model) {
  const ClosureSet& set = model.closures();
  if (set.closures.empty()) return set.couplers.empty() ? 0 : 1;
  const int rows = set.closures.front().conditions().count;
  const auto as_many = [&](const Closure& c) { return c.conditions().count == rows; };
  return (set.couplers.empty() || rows == 1) && std::all_of(set.closures.begin(), set.closures.end(), as_many) ? rows
                                                                                                               : 0;
}

}  // namespace lanc
