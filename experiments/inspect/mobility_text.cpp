// Loops and mobility as a mechanical engineer reads them.
#include <fmt/format.h>

#include "experiments/inspect/mechanism_report.h"

namespace lanc {
namespace {

std::string verdict_text(const Mobility& m) {
  switch (m.verdict) {
    case Verdict::regular: return m.closure_rows == 0 ? "regular: a tree" : "regular: every closure condition counts";
    case Verdict::overconstrained:
      return fmt::format(
          "overconstrained: {} conditions are redundant in every configuration{}; statically indeterminate",
          m.redundant(), m.finite_mobility > 0 ? ", and it moves all the same" : "");
    case Verdict::singular:
      return fmt::format(
          "singular configuration: rank {} here, {} in neighbouring configurations; branches of motion may "
          "cross",
          m.rank, m.generic_rank);
    case Verdict::shaky: return "shaky: it gives way to first order, and cannot move";
  }
  return {};
}

std::string unique_components(const std::array<bool, 6>& unique) {
  constexpr const char* names[] = {"mx", "my", "mz", "fx", "fy", "fz"};
  std::string open;
  for (int c = 0; c < 6; ++c)
    if (!unique[c]) open += (open.empty() ? "" : ", ") + std::string(names[c]);
  return open.empty() ? "unique" : "not unique: " + open;
}

std::string loop_table(const Model& model, const Mobility& m) {
  TextTable table({"closure", "type", "from", "to", "condition", "redundant", "reaction"}, 7);
  const auto row = [&](const std::string& name, const std::string& type, const std::string& a, const std::string& b,
                       int k) {
    const bool dependent = std::binary_search(m.redundant_rows.begin(), m.redundant_rows.end(), k);
    const bool removable = std::binary_search(m.removable_rows.begin(), m.removable_rows.end(), k);
    table.row({name, type, a, b, model.closures().row_names[k],
               removable   ? "yes, removable"
               : dependent ? "yes, with others"
                           : "no",
               m.unique_row[k] ? "unique" : "not unique"});
  };
  for (std::size_t i = 0; i < model.spec().closures.size(); ++i) {
    const ClosureSpec& spec = model.spec().closures[i];
    const Closure& c = model.closures().closures[i];
    for (int k = 0; k < c.conditions().count; ++k)
      row(k == 0 ? spec.name : "",
          k == 0 ? std::string(spec.kind.traits().name) + (spec.motion ? ", prescribed" : "") : "",
          k == 0 ? named(spec.body_a) : "", k == 0 ? named(spec.body_b) : "", c.row + k);
  }
  for (std::size_t i = 0; i < model.spec().couplers.size(); ++i)
    row(model.spec().couplers[i].name, "coupler", "", "", model.closures().couplers[i].row);
  return "\nClosures (conditions that cut loops are closed by)\n" + table.text();
}

std::string graph_text(const GraphRecord& graph) {
  std::string text;
  for (const LoopCut& cut : graph.cuts) text += to_text(cut) + "\n";
  if (!text.empty()) text = "\nLoops of the graph of joints\n" + text;
  if (!graph.reversed.empty())
    text += fmt::format("\nIn the tree body_b of these joints carries body_a, which changes their coordinates: {}\n",
                        fmt::join(graph.reversed, ", "));
  return text;
}

}  // namespace

std::string mobility_text(const MechanismReport& report) {
  const Model& model = report.input.model;
  const Mobility& m = report.mobility;
  TextTable table({"count", "meaning", "value"}, 2);
  const auto row = [&](const char* what, int value, const std::string& meaning) {
    table.row({what, meaning, std::to_string(value)});
  };
  row("velocities", m.velocities, "freedoms of the joints of the tree");
  if (m.closure_rows > 0) {
    row("closure conditions", m.closure_rows, "of the joints that close loops");
    row("Grübler-Kutzbach", m.grubler, "mobility if all conditions were independent");
    row("rank here", m.rank,
        fmt::format("independent conditions; singular values {:.2e} and, next, {:.2e}", m.sigma, m.next_sigma));
    row("rank on the branch", m.generic_rank, fmt::format("largest met on {} walks along the motion", m.walks));
    row("redundant", m.redundant(), "conditions that follow from others here");
  }
  row("mobility here", m.mobility, "to first order");
  row("finite mobility", m.finite_mobility, "of real motions");
  std::string text = "\nMobility\n" + table.text() + "Verdict: " + verdict_text(m) + "\n";
  if (report.absolute)
    text += fmt::format("In absolute coordinates: {} coordinates, {} conditions of all joints, rank {}, redundant {}\n",
                        m.absolute_coordinates, m.absolute_rows, m.absolute_rank, m.redundant());
  text += graph_text(report.input.graph);
  if (m.closure_rows == 0) return text;
  if (m.position_violation > 1e-9)
    text +=
        fmt::format("The state violates the closure conditions by {:.1e} (scaled): ranks mean little; use --assemble\n",
                    m.position_violation);
  text += loop_table(model, m);
  TextTable reactions({"joint", "reaction"}, 2);
  bool all = true;
  for (int i = 0; i < model.bodies(); ++i) {
    const std::string unique = unique_components(m.unique[i]);
    all = all && unique == "unique";
    reactions.row({model.spec().joints[i].name, unique});
  }
  return text + (all ? "\nAll joint reactions are unique\n" : "\nJoint reactions (world axes)\n" + reactions.text());
}

}  // namespace lanc
