#include "lib/derivatives/motion_derivatives.h"

#include <algorithm>

#include "lib/model/coordinates.h"
#include "lib/system/equations.h"

namespace lanc {

Differentiator::Differentiator(const Model& model, const Loads<double>& loads)
    : model_(model),
      loads_(cast<D>(loads)),
      evaluator_(model),
      solution_(model),
      rates_(model.nq()),
      tau_(model.nv()),
      acceleration_(model.closures().rows()) {}

/// Dense: explicit integrators never ask for derivatives, and may follow 10⁵ bodies.
void Differentiator::allocate() {
  const int columns = model_.nq() + model_.nv(), rows = model_.closures().rows();
  result_.coordinate_rate.resize(model_.nq(), columns);
  result_.balance.resize(model_.nv(), columns);
  for (Eigen::MatrixXd* m : {&result_.position, &result_.velocity, &result_.acceleration}) m->resize(rows, columns);
}

void Differentiator::evaluate(State<D> state) {
  normalise(model_, state.q.data());
  coordinate_rates(model_, state.q.data(), state.v.data(), rates_.data());
  system_ = &evaluator_.system(state, loads_);
  inverse_dynamics(*system_, solution_, tau_);
  if (model_.has_closures()) closure_accelerations(*system_, system_->rhs, solution_, acceleration_);
}

void Differentiator::store(int first, int count) {
  for (int lane = 0; lane < count; ++lane) {
    const int c = first + lane;
    for (int k = 0; k < model_.nq(); ++k) result_.coordinate_rate(k, c) = rates_[k].d[lane];
    for (int k = 0; k < model_.nv(); ++k) result_.balance(k, c) = tau_[k].d[lane];
    for (int k = 0; k < model_.closures().rows(); ++k) {
      result_.position(k, c) = system_->closure_rows[k].g.d[lane];
      result_.velocity(k, c) = system_->closure_rows[k].rate.d[lane];
      result_.acceleration(k, c) = acceleration_[k].d[lane];
    }
  }
}

const MotionDerivatives& Differentiator::at(const State<double>& state, const std::vector<double>& vdot,
                                            const std::vector<double>& lambda) {
  const int nq = model_.nq(), columns = nq + model_.nv();
  std::copy(vdot.begin(), vdot.end(), solution_.vdot.begin());
  std::copy(lambda.begin(), lambda.end(), solution_.lambda.begin());
  if (result_.balance.cols() != columns) allocate();
  for (int first = 0; first < columns; first += lanes) {
    const int count = std::min(lanes, columns - first);
    State<D> seeded = cast<D>(state);
    for (int lane = 0; lane < count; ++lane) {
      const int c = first + lane;
      (c < nq ? seeded.q[c] : seeded.v[c - nq]).d[lane] = 1;
    }
    evaluate(std::move(seeded));
    store(first, count);
  }
  return result_;
}

}  // namespace lanc
