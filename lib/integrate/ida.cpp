#include "lib/integrate/ida.h"

#include <ida/ida.h>

#include "lib/integrate/residual_form.h"
#include "lib/integrate/sundials.h"
#include "lib/model/coordinates.h"

namespace lanc {
namespace {

/// The stabilised index-2 form of Gear, Gupta & Leimkuhler (1985, J. Comput. Appl. Math. 12-13, 77-90), with closure
/// conditions of positions and of velocities both held:
///
///   q̇ = H(q) (η + Gᵀμ),  M̄ η̇ − b − Gᵀλ = 0,  Gη + γ̄ = 0,  g = 0
///
/// Unknowns x = (q, η, work, λ, μ); μ vanishes with the error. Dense Newton's method with exact derivatives.
class Ida : public Stepper {
 public:
  Ida(ResidualForm& form, const StepperOptions& options)
      : form_(form),
        options_(options),
        nq_(form.model().nq()),
        nv_(form.model().nv()),
        scale_(velocity_scale(form.model())),
        context_(sundials::make_context()) {}
  ~Ida() override { IDAFree(&memory_); }

  void start(double t, std::span<const double> y) override {
    t_ = reached_ = t;
    y_.assign(y.begin(), y.end());
    const MotionPoint point = form_.unpack(t, y.data());
    Eigen::VectorXd vdot, lambda;
    started_ = form_.start(point.state, vdot, lambda).usable();
    if (!started_) return;
    rows_ = form_.rows();
    size_ = form_.size() + 2 * rows_;
    const double relative = sundials::of_single_numbers(options_.tolerance, size_);
    for (sundials::Vector* v : {&x_, &xdot_, &kind_, &tolerance_}) *v = sundials::make_vector(context_, size_);
    Vector x = map(x_.get()), xdot = map(xdot_.get()), kind = map(kind_.get()), tolerance = map(tolerance_.get());
    x.setZero(), xdot.setZero();
    std::copy(y.begin(), y.end(), x.begin());
    x.segment(form_.size(), rows_) = lambda;
    coordinate_rates(form_.model(), point.state.q.data(), point.state.v.data(), xdot.data());
    xdot.segment(nq_, nv_) = vdot;
    xdot[nq_ + nv_] = form_.residual(point.state, vdot, lambda).power;
    kind.setOnes();
    kind.tail(2 * rows_).setZero();
    tolerance = relative * Eigen::VectorXd::Ones(size_);
    for (int k = 0; k < form_.size(); ++k) tolerance[k] *= form_.scale()[k];
    // λ and μ are algebraic, and rounding errors over short steps: no part of any test
    constexpr double untested = 1e20;
    tolerance.tail(2 * rows_).setConstant(untested);
    create(relative);
  }

  bool step(double limit) override {
    if (!started_) return message_ = form_.outcome().message, false;
    if (reached_ <= t_) {
      realtype reached = t_;
      if (IDASolve(memory_, limit, &reached, x_.get(), xdot_.get(), IDA_ONE_STEP) < 0) {
        message_ = form_.outcome().usable() ? library_message_ : form_.outcome().message;
        return false;
      }
      reached_ = reached;
      IDAGetNumSteps(memory_, &counts_.steps);
      IDAGetNumErrTestFails(memory_, &counts_.rejected);
      IDAGetNumNonlinSolvIters(memory_, &counts_.newton_iterations);
    }
    t_ = std::min(reached_, limit);
    IDAGetDky(memory_, t_, 0, x_.get());
    const Vector x = map(x_.get());
    y_.assign(x.begin(), x.begin() + form_.size());
    return true;
  }

  double next_step() const override {
    realtype h = 0;
    if (memory_) IDAGetCurrentStep(memory_, &h);
    return h;
  }

 private:
  using Vector = Eigen::Map<Eigen::VectorXd>;
  static Vector map(N_Vector v) { return {sundials::data(v), N_VGetLength(v)}; }

  void create(double relative) {
    if (memory_) IDAFree(&memory_);
    memory_ = sundials::needed(IDACreate(context_.get()));
    IDASetErrHandlerFn(memory_, &sundials::keep_message, &library_message_);
    IDAInit(memory_, &residual, t_, x_.get(), xdot_.get());
    IDASetUserData(memory_, this);
    IDASVtolerances(memory_, relative, tolerance_.get());
    IDASetId(memory_, kind_.get());
    IDASetSuppressAlg(memory_, SUNTRUE);
    IDASetMaxNumSteps(memory_, sundials::most_steps);
    // IDA's own guess is so short at tight tolerances that rounding errors of λ and μ, which grow with its inverse,
    // stop Newton's method; an error test that fails shortens this one
    IDASetInitStep(memory_, options_.first_step > 0 ? options_.first_step : 0.01 * std::sqrt(relative));
    newton_.emplace(context_, x_, size_);
    IDASetLinearSolver(memory_, newton_->solver.get(), newton_->matrix.get());
    IDASetJacFn(memory_, &jacobian);
  }

  struct Unknowns {
    MotionPoint point;
    Eigen::VectorXd vdot, lambda, mu;
  };
  Unknowns unknowns(double t, N_Vector x, N_Vector xdot) const {
    const Vector X = map(x), D = map(xdot);
    return {form_.unpack(t, X.data()), D.segment(nq_, nv_), X.segment(form_.size(), rows_), X.tail(rows_)};
  }
  /// (unit²) Gᵀ as velocities, in units of the model's length.
  Eigen::MatrixXd pull(const Eigen::MatrixXd& G) const {
    const Eigen::Map<const Eigen::VectorXd> unit(scale_.data(), nv_);
    return unit.cwiseAbs2().asDiagonal() * G.transpose();
  }

  static int residual(realtype t, N_Vector x, N_Vector xdot, N_Vector result, void* self) {
    Ida& me = *static_cast<Ida*>(self);
    Unknowns u = me.unknowns(t, x, xdot);
    const int nq = me.nq_, nv = me.nv_;
    const MotionResidual& r = me.form_.residual(u.point.state, u.vdot, u.lambda);
    if (!r.balance.allFinite()) return 1;
    Vector F = map(result);
    State<double> pushed = u.point.state;
    Eigen::Map<Eigen::VectorXd>(pushed.v.data(), nv) +=
        me.form_.transposed(u.mu).cwiseProduct(Eigen::Map<const Eigen::VectorXd>(me.scale_.data(), nv).cwiseAbs2());
    Eigen::VectorXd rates(nq);
    coordinate_rates(me.form_.model(), pushed.q.data(), pushed.v.data(), rates.data());
    const Vector D = map(xdot);
    F << D.head(nq) - rates, r.balance, D[nq + nv] - r.power, r.velocity, r.position;
    return 0;
  }

  static int jacobian(realtype t, realtype cj, N_Vector x, N_Vector xdot, N_Vector /*F*/, SUNMatrix matrix, void* self,
                      N_Vector, N_Vector, N_Vector) {
    Ida& me = *static_cast<Ida*>(self);
    const Unknowns u = me.unknowns(t, x, xdot);
    const int nq = me.nq_, nv = me.nv_, rows = me.rows_, w = nq + nv, l = w + 1, m = l + rows;
    (void)me.form_.residual(u.point.state, u.vdot, u.lambda);  // for the mass matrix
    const MotionDerivatives& d = me.form_.derivatives(u.point.state, u.vdot, u.lambda);
    Eigen::Map<Eigen::MatrixXd> J(SM_DATA_D(matrix), me.size_, me.size_);
    const Eigen::MatrixXd G = d.velocity.rightCols(nv), H = d.coordinate_rate.rightCols(nv);
    J.setZero();
    J.topLeftCorner(nq, w) = -d.coordinate_rate;
    J.topLeftCorner(nq, nq).diagonal().array() += cj;
    J.block(0, m, nq, rows) = -H * me.pull(G);
    J.block(nq, 0, nv, w) = d.balance;
    J.block(nq, nq, nv, nv) += cj * me.form_.mass();
    J.block(nq, l, nv, rows) = -G.transpose();
    J(w, w) = cj;
    J.block(l, 0, rows, w) = d.velocity;
    J.block(m, 0, rows, w) = d.position;
    return J.allFinite() ? 0 : 1;
  }

  ResidualForm& form_;
  StepperOptions options_;
  int nq_, nv_, rows_ = 0, size_ = 0;
  std::vector<double> scale_;
  sundials::Context context_;
  void* memory_ = nullptr;
  bool started_ = false;
  double reached_ = 0;
  sundials::Vector x_, xdot_, kind_, tolerance_;
  std::optional<sundials::Newton> newton_;
  std::string library_message_;
};

}  // namespace

std::unique_ptr<Stepper> create_ida(MotionForm& form, const StepperOptions& options) {
  return std::make_unique<Ida>(dynamic_cast<ResidualForm&>(form), options);
}

}  // namespace lanc
