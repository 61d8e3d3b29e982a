#include "lib/closure/branch_map.h"

#include <cmath>

#include "lib/closure/rank.h"
#include "lib/system/evaluator.h"

namespace lanc {
namespace {

/// Where all bodies are: positions in model lengths, and rotations. Blind to turns.
Eigen::VectorXd poses(const Model& model, const State<double>& state) {
  Evaluator<double> evaluator(model);
  evaluator.system(state);
  Eigen::VectorXd x(12 * model.bodies());
  for (int i = 0; i < model.bodies(); ++i) {
    const Mat3<double> R = evaluator.body_rotation(i);
    int k = 12 * i;
    for (const Vec3<double>& part : {evaluator.positions()[i] * (1 / model.length()), R.x, R.y, R.z})
      for (const double value : {part.x, part.y, part.z}) x[k++] = value;
  }
  return x;
}

/// A step that can be done: h, halved until it can.
double possible_step(const BranchTracer& tracer, double h) {
  constexpr int most_halvings = 12;
  for (int k = 0; k <= most_halvings; ++k, h /= 2)
    if (tracer.at(h)) return h;
  return 0;
}

/// Collects crossings, and which of their tangents have been followed.
class Explorer {
 public:
  Explorer(const Model& model, int rank, double h, int most) : model_(model), rank_(rank), h_(h), most_(most) {}

  BranchMap run(const State<double>& start) {
    follow(BranchTracer(model_, start, rank_));
    for (std::size_t c = 0; c < map_.crossings.size(); ++c)
      for (std::size_t k = 0; k < followed_[c].size(); ++k) {
        if (followed_[c][k]) continue;
        followed_[c][k] = true;
        BranchTracer leaving(model_, map_.crossings[c].state, rank_, map_.crossings[c].tangents[k]);
        // a little way off, where the branch is the only one
        if (leaving.advance(0.3 * h_))
          follow(BranchTracer(model_, leaving.here().state, rank_, leaving.here().tangent));
      }
    return std::move(map_);
  }

 private:
  void follow(const BranchTracer& tracer) {
    map_.branches.push_back(follow_round(tracer, h_, most_, [this](const BranchTracer& at, double h) { look(at, h); }));
  }

  /// A crossing lies where σ_r changes its sign.
  void look(const BranchTracer& tracer, double h) {
    const BranchPoint& here = tracer.here();
    const auto next = tracer.at(h);
    if (!next || (here.sigma * next->sigma > 0 && std::abs(next->sigma) > clear_singular_value)) return;
    const bool nearer_here = std::abs(here.sigma) < std::abs(next->sigma);
    const auto crossing = locate_singular_point(model_, nearer_here ? here.state : next->state, rank_);
    if (crossing) mark(*crossing, here.tangent + next->tangent);
  }

  void mark(const SingularPoint& crossing, const Eigen::VectorXd& along) {
    const Eigen::VectorXd x = poses(model_, crossing.state);
    std::size_t c = 0;
    while (c < places_.size() && (places_[c] - x).cwiseAbs().maxCoeff() > 1e-6) ++c;
    if (c == places_.size()) {
      places_.push_back(x);
      map_.crossings.push_back(crossing);
      followed_.emplace_back(crossing.tangents.size(), false);
    }
    std::size_t nearest = 0;
    const auto& tangents = map_.crossings[c].tangents;
    for (std::size_t k = 0; k < tangents.size(); ++k)
      if (std::abs(tangents[k].dot(along)) > std::abs(tangents[nearest].dot(along))) nearest = k;
    if (!tangents.empty()) followed_[c][nearest] = true;
  }

  const Model& model_;
  int rank_;
  double h_;
  int most_;
  BranchMap map_;
  std::vector<Eigen::VectorXd> places_;
  std::vector<std::vector<bool>> followed_;
};

}  // namespace

Branch follow_round(BranchTracer tracer, double h, int most,
                    const std::function<void(const BranchTracer&, double)>& each) {
  Branch branch;
  branch.points.push_back(tracer.here());
  const Model& model = tracer.model();
  const Eigen::VectorXd start = poses(model, tracer.here().state);
  Eigen::VectorXd way;  // of the first step
  // below 0 before the start, above 0 behind it, as far as the bodies are near it
  const auto progress = [&](const BranchPoint& p) { return (poses(model, p.state) - start).dot(way); };
  double last = 0;
  for (int step = 0; step < most; ++step) {
    const double can = possible_step(tracer, h);
    if (can == 0) return branch;
    if (each) each(tracer, can);
    if (step > 2) {
      const auto next = tracer.at(can);
      const double ahead = progress(*next);
      const bool near = (poses(model, next->state) - start).norm() < 2 * way.norm();
      if (near && last < 0 && ahead >= 0) {
        if (auto end = tracer.locate(can, progress)) branch.points.push_back(*std::move(end));
        branch.closed = true;
        return branch;
      }
      last = ahead;
    }
    tracer.advance(can);
    branch.points.push_back(tracer.here());
    if (step == 0) way = poses(model, tracer.here().state) - start;
  }
  return branch;
}

BranchMap map_branches(const Model& model, const State<double>& start, int rank, double h, int most) {
  return Explorer(model, rank, h, most).run(start);
}

}  // namespace lanc
