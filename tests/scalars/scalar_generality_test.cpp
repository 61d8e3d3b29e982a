// The kinematics, `recursive` and `composite` must stay open for SIMD packs and dual numbers. A scalar that offers
// nothing but + − × ÷ sin cos sqrt compiles only as long as they compare nothing and call no decomposition.
#include <gtest/gtest.h>

#include <cstdlib>
#include <type_traits>

#include "formulations/composite/composite.h"
#include "formulations/recursive/recursive.h"
#include "lib/formulation/formulation.cpp"       // NOLINT: the templates, for one more scalar
#include "lib/formulation/tree_formulation.cpp"  // NOLINT
#include "lib/io/generators.h"
#include "lib/system/equations.cpp"  // NOLINT
#include "lib/system/evaluator.cpp"  // NOLINT

namespace lanc {
namespace {

class Bare {
 public:
  Bare() = default;
  explicit Bare(double value) : value_(value) {}
  double value() const { return value_; }
  Bare operator-() const { return Bare(-value_); }
  Bare& operator+=(Bare b) { return *this = *this + b; }
  Bare& operator-=(Bare b) { return *this = *this - b; }
  Bare& operator*=(Bare b) { return *this = *this * b; }
  friend Bare operator+(Bare a, Bare b) { return Bare(a.value_ + b.value_); }
  friend Bare operator-(Bare a, Bare b) { return Bare(a.value_ - b.value_); }
  friend Bare operator*(Bare a, Bare b) { return Bare(a.value_ * b.value_); }
  friend Bare operator/(Bare a, Bare b) { return Bare(a.value_ / b.value_); }
  friend Bare sqrt(Bare a) { return Bare(std::sqrt(a.value_)); }
  friend Bare sin(Bare a) { return Bare(std::sin(a.value_)); }
  friend Bare cos(Bare a) { return Bare(std::cos(a.value_)); }

 private:
  double value_ = 0;
};

}  // namespace

// The rank of closure conditions is decided on numbers that can be compared; a tree has none.
template <>
struct ClosureRank<Bare>::Work {};
template <>
ClosureRank<Bare>::ClosureRank(const Model&) {}
template <>
ClosureRank<Bare>::~ClosureRank() = default;
template <>
[[maybe_unused]] const ClosureDecision& ClosureRank<Bare>::decision() const {
  std::abort();
}

namespace {

template <class Kind>
Solution<Bare> solve_bare(const Mechanism& mechanism) {
  Evaluator<Bare> evaluator(mechanism.model);
  Kind formulation(mechanism.model);
  Solution<Bare> solution(mechanism.model);
  State<Bare> state{mechanism.state.t, {}, {}};
  for (const double q : mechanism.state.q) state.q.emplace_back(q);
  for (const double v : mechanism.state.v) state.v.emplace_back(v);
  const System<Bare>& system = evaluator.system(state);
  formulation.assemble(system);
  EXPECT_TRUE(formulation.factorise(system).usable());
  formulation.substitute(system, system.rhs, solution);
  return solution;
}

TEST(ScalarGenerality, KinematicsRecursiveAndCompositeNeedNothingButArithmeticSineCosineAndRoot) {
  for (const char* argument : {"chain:8", "tree:7:joint=spherical", "random:30:seed=5"}) {
    const Mechanism mechanism = *generate(argument);
    Evaluator<double> evaluator(mechanism.model);
    Solution<double> expected(mechanism.model);
    ASSERT_TRUE(find_formulation("recursive")
                    ->create_double(mechanism.model)
                    ->solve(evaluator.system(mechanism.state), expected)
                    .usable());
    const Solution<Bare> recursive = solve_bare<Recursive<Bare>>(mechanism);
    const Solution<Bare> composite = solve_bare<Composite<Bare>>(mechanism);
    double size = 0;
    for (const double a : expected.vdot) size = std::max(size, std::abs(a));
    for (int k = 0; k < mechanism.model.nv(); ++k) {
      EXPECT_NEAR(recursive.vdot[k].value(), expected.vdot[k], 1e-9 * size) << argument;
      EXPECT_NEAR(composite.vdot[k].value(), expected.vdot[k], 1e-9 * size) << argument;
    }
  }
}

/// Kinematics and recursion on packs, every lane with velocities of its own, against double one by one.
template <class P>
double largest_error(const Mechanism& m) {
  Evaluator<P> evaluator(m.model);
  Recursion<P> recursion(m.model);
  Solution<P> solution(m.model);
  State<P> state{m.state.t, {m.state.q.begin(), m.state.q.end()}, {m.state.v.begin(), m.state.v.end()}};
  for (P& v : state.v)
    for (int lane = 0; lane < P::lanes; ++lane) v.set(lane, v[lane] * (lane + 1) / P::lanes);
  const System<P>& system = evaluator.system(state);
  recursion.factorise(system);
  recursion.substitute(system, system.rhs, solution);
  Evaluator<double> one(m.model);
  Solution<double> exact(m.model);
  const auto formulation = find_formulation("recursive")->create_double(m.model);
  double worst = 0;
  for (int lane = 0; lane < P::lanes; ++lane) {
    State<double> alone = m.state;
    for (double& v : alone.v) v *= (lane + 1.0) / P::lanes;
    EXPECT_TRUE(formulation->solve(one.system(alone), exact).usable());
    double size = 0, error = 0;
    for (int k = 0; k < m.model.nv(); ++k) {
      size = std::max(size, std::abs(exact.vdot[k]));
      error = std::max(error, std::abs(solution.vdot[k][lane] - exact.vdot[k]));
    }
    worst = std::max(worst, error / size);
  }
  return worst;
}

TEST(ScalarGenerality, packs_of_every_width_and_of_single_precision_run_the_same_sources) {
  for (const char* argument : {"chain:8", "tree:7:joint=spherical", "random:12:seed=4"}) {
    const Mechanism m = *generate(argument);
    EXPECT_LT((largest_error<Pack<double, 8>>(m)), 1e-11) << argument;
    EXPECT_LT((largest_error<Pack<double, 4>>(m)), 1e-11) << argument;
    EXPECT_LT((largest_error<Pack<float, 16>>(m)), 2e-3) << argument;
    EXPECT_LT((largest_error<Pack<float, 8>>(m)), 2e-3) << argument;
  }
}

}  // namespace
}  // namespace lanc
