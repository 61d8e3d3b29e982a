#include "experiments/peers/tables.h"

#include <fmt/format.h>

#include <cmath>
#include <map>
#include <set>
#include <tuple>

#include "experiments/peers/contest.h"
#include "experiments/peers/peer.h"
#include "experiments/peers/plan.h"
#include "lib/report/crossing.h"
#include "lib/report/sidecar.h"
#include "lib/report/table.h"

namespace lanc::peers {
namespace {

/// What the rows say of one side on one model.
struct Result {
  std::vector<double> times;
  double difference = std::nan(""), error = std::nan("");
  std::string status;
  double seconds() const { return median(times); }  // NaN without times
};

using Key = std::tuple<std::string, std::string, std::string>;  // model, task, who
std::map<Key, Result> results(const std::vector<Row>& rows, std::vector<Key>& order) {
  std::map<Key, Result> all;
  for (const auto& [cell, m] : rows) {
    if (m.phase != "total") continue;
    const Key key{cell.model, cell.parameters, cell.formulation};
    const auto [found, fresh] = all.try_emplace(key);
    if (fresh) order.push_back(key);
    Result& result = found->second;
    result.status = m.status;
    if (m.metric == "time") result.times.push_back(m.value);
    if (m.metric == "difference") result.difference = m.value;
    if (m.metric == "error") result.error = m.value;
  }
  return all;
}

bool is_peer(const std::string& who) {
  for (const MandatoryPeer& peer : mandatory_peers())
    if (peer.name == who) return true;
  for (const PeerInfo& peer : registered_peers())
    if (peer.name == who) return true;
  return false;
}

std::string scientific(double value) { return std::isnan(value) ? "-" : fmt::format("{:.0e}", value); }

}  // namespace

void print_times(std::FILE* out, const std::vector<Row>& rows) {
  std::vector<Key> order;
  const auto all = results(rows, order);
  std::set<std::string> ours;
  for (const Key& key : order)
    if (const std::string& who = std::get<2>(key); !is_peer(who)) ours.insert(who);
  std::map<std::pair<std::string, std::string>, double> fastest;  // of ours
  for (const auto& [key, result] : all) {
    if (!ours.count(std::get<2>(key)) || result.times.empty()) continue;
    const auto [found, fresh] = fastest.try_emplace({std::get<0>(key), std::get<1>(key)}, result.seconds());
    if (!fresh) found->second = std::min(found->second, result.seconds());
  }
  TextTable table({"model", "task", "side", "µs", "our fastest / it", "difference", "error", "status"}, 3);
  std::set<std::string> absent;
  std::map<std::string, std::set<std::string>> objections;
  for (const Key& key : order) {
    const auto& [model, task, who] = key;
    const Result& result = all.at(key);
    if (result.status == missing) absent.insert(who);
    if (result.status == to_string(Status::objection)) objections[who].insert(model);
    if (result.status == missing || result.status == to_string(Status::objection)) continue;
    const double seconds = result.seconds();
    const bool timed = !result.times.empty();
    const auto best = fastest.find({model, task});
    table.row({model, task.substr(task.find('=') + 1), who, timed ? fmt::format("{:.3f}", 1e6 * seconds) : "-",
               timed && !ours.count(who) && best != fastest.end() ? fmt::format("{:.3f}", best->second / seconds) : "-",
               scientific(result.difference), scientific(result.error), result.status});
  }
  fmt::print(out, "\nMedian times of one evaluation, kinematics included\n{}", table.text(1000));
  for (const auto& [who, models] : objections)
    fmt::print(out, "{} cannot take, or not all that is asked of: {}\n", who, fmt::join(models, ", "));
  if (!absent.empty()) fmt::print(out, "Not compiled in (rows `missing` in the CSV): {}\n", fmt::join(absent, ", "));
}

void print_bounds(std::FILE* out, const std::vector<Row>& rows) {
  std::vector<Key> order;
  const auto all = results(rows, order);
  const auto of = [&](const Side& side) {
    const auto found = all.find({std::string(side.model), parameters(side.task), std::string(side.who)});
    return found == all.end() ? Result() : found->second;
  };
  std::set<std::string, std::less<>> run;
  for (const Key& key : order) run.insert(std::get<0>(key));
  TextTable table({"bound", "limit", "measured", ""}, 1);
  const auto add = [&](const std::string& what, double limit, double measured, const char* format) {
    const auto text = [&](double value) { return fmt::format(fmt::runtime(format), value); };
    const bool there = !std::isnan(measured);
    table.row({what, text(limit), there ? text(measured) : "-",
               !there              ? "not measured"
               : measured <= limit ? "holds"
                                   : "does not hold"});
  };
  for (const Bound& bound : bounds()) {
    if (!run.count(bound.ours.model) || !run.count(bound.other.model)) continue;
    const double ratio = of(bound.ours).seconds() / of(bound.other).seconds();
    const bool same_model = bound.ours.model == bound.other.model, same_side = bound.ours.who == bound.other.who;
    add(fmt::format("{}{}{}{}, {}{}{}", bound.sizes > 0 ? "exponent of " : "", bound.ours.who, same_side ? "" : " / ",
                    same_side ? "" : bound.other.who, bound.ours.model, same_model ? "" : " / ",
                    same_model ? "" : bound.other.model),
        bound.limit, bound.sizes > 0 ? std::log(ratio) / std::log(bound.sizes) : ratio, "{:.3f}");
  }
  for (const ErrorBound& bound : error_bounds())
    if (run.count(bound.ours.model))
      add(fmt::format("error of {}, {}", bound.ours.who, bound.ours.model), bound.limit, of(bound.ours).error,
          "{:.0e}");
  if (!table.empty()) fmt::print(out, "\nBounds on ratios of times, and on errors\n{}", table.text());
}

void print_builds(std::FILE* out) {
  const BuildInfo build = build_info();
  fmt::print(out, "\nours: {}, {}\n", build.compiler, build.flags);
  for (const PeerInfo& peer : registered_peers())
    fmt::print(out, "{} {}, {}: as its package was built; {}\n", peer.name, peer.version, to_string(peer.task),
               peer.computes);
  fmt::print(out, "processor: {}\n", processor());
}

}  // namespace lanc::peers
