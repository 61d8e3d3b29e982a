#include "experiments/peers/plan.h"

#include <algorithm>
#include <cmath>
#include <filesystem>

namespace lanc::peers {
namespace {

constexpr auto forward = Task::forward, inverse = Task::inverse;

constexpr MandatoryPeer mandatory[] = {
    {"bullet", forward},    {"dart", forward},      {"dart", inverse},       {"mujoco", forward},
    {"mujoco", inverse},    {"simbody", forward},   {"orocos-kdl", forward}, {"orocos-kdl", inverse},
    {"pinocchio", forward}, {"pinocchio", inverse}, {"rbdl", forward},       {"rbdl", inverse},
};

/// A bound of one of ours against a peer on the same model.
constexpr Bound against(std::string_view ours, std::string_view peer, std::string_view model, double limit) {
  return {{ours, forward, model}, {peer, forward, model}, limit};
}
constexpr Bound cheaper(std::string_view model) {
  return {{our_inverse, inverse, model}, {"recursive", forward, model}, 0.55};
}

constexpr std::string_view loops = "recursive-loops";

constexpr Bound all_bounds[] = {
    against("recursive", "bullet", "chain:6", 0.30),
    against("recursive", "bullet", "humanoid", 0.30),
    against("recursive", "bullet", "chain:32", 0.25),
    against("recursive", "bullet", "chain:100", 0.25),
    against("recursive", "bullet", "tree:63", 0.25),
    against("composite", "mujoco", "chain:6", 0.35),
    against("composite", "mujoco", "humanoid", 0.35),
    against("composite", "mujoco", "chain:100", 0.6),
    against("composite", "mujoco", "tree:1023", 0.6),
    cheaper("chain:6"),
    cheaper("humanoid"),
    cheaper("chain:32"),
    cheaper("chain:100"),
    cheaper("tree:63"),
    against(loops, "mujoco", "four-bar-ladder:1", 0.35),
    against(loops, "mujoco", "four-bar-ladder:10", 0.45),
    against(loops, "mujoco", "four-bar-ladder:100", 0.5),
    {{loops, forward, "four-bar-ladder:1000"}, {loops, forward, "four-bar-ladder:10"}, 1.1, 100},
    {{loops, forward, "four-bar-ladder:10:cut=weld"}, {loops, forward, "four-bar-ladder:10"}, 2.5},
    {{loops, forward, "four-bar-ladder:100:cut=weld"}, {loops, forward, "four-bar-ladder:100"}, 2.5},
    {{loops, forward, "four-bar-chain:10"}, {loops, forward, "four-bar-ladder:10"}, 2.5},
    {{loops, forward, "four-bar-chain:100"}, {loops, forward, "four-bar-ladder:100"}, 2.5},
};

constexpr ErrorBound all_error_bounds[] = {
    {{loops, forward, "four-bar-ladder:1"}, 1e-12},
    {{loops, forward, "four-bar-ladder:10"}, 1e-12},
    {{loops, forward, "four-bar-ladder:100"}, 1e-12},
    {{loops, forward, "four-bar-ladder:1000"}, 1e-12},
};

}  // namespace

std::vector<std::string> default_models(bool quick) {
  const std::string humanoid = LANC_DATA_DIR "/models/robots/humanoid.toml";
  if (quick) return {"chain:6", "tree:63", humanoid, "four-bar-ladder:1", "four-bar-ladder:10"};
  return {"chain:1",
          "chain:6",
          "chain:12",
          "chain:32",
          "chain:100",
          "chain:1000",
          "tree:63",
          "tree:1023",
          humanoid,
          "four-bar-ladder:1",
          "four-bar-ladder:10",
          "four-bar-ladder:100",
          "four-bar-ladder:1000",
          "four-bar-ladder:1:cut=weld",
          "four-bar-ladder:10:cut=weld",
          "four-bar-ladder:100:cut=weld",
          "four-bar-chain:1",
          "four-bar-chain:10",
          "four-bar-chain:100"};
}

std::string short_name(const std::string& model) {
  return model.find('/') == std::string::npos ? model : std::filesystem::path(model).stem().string();
}

std::span<const MandatoryPeer> mandatory_peers() { return mandatory; }

bool ours_alone(const Model& model) { return model.closures().rows() > 1000; }

std::span<const Bound> bounds() { return all_bounds; }
std::span<const ErrorBound> error_bounds() { return all_error_bounds; }

bool has_bound(std::string_view formulation) {
  return std::any_of(std::begin(all_bounds), std::end(all_bounds),
                     [&](const Bound& b) { return b.ours.who == formulation; });
}

std::vector<double> closed_form(const std::string& name, const Model& model, const State<double>& state) {
  if (!name.starts_with("four-bar-ladder:")) return {};
  // Uprights: θ̈ = g ((N+1)/2 + N) sin θ / ((N+1)/3 + N) at any speed; couplers turn back by as much, and have q = −θ.
  const auto loops = static_cast<double>(model.closures().closures.size());
  const double g = -model.gravity().z, factor = g * ((loops + 1) / 2 + loops) / ((loops + 1) / 3 + loops);
  std::vector<double> vdot;
  for (const double q : state.q) vdot.push_back(factor * std::sin(q));
  return vdot;
}

}  // namespace lanc::peers
