// Operation counts, by running the formulations on Count.
#include <gtest/gtest.h>

#include <cstdio>

#include "lib/formulation/formulation.h"
#include "lib/system/evaluator.h"
#include "tests/support/random_model.h"

namespace lanc::test {
namespace {

struct Flops {
  long kinematics = 0, factorise = 0, substitute = 0;  // assemble belongs to factorise here
  long total() const { return kinematics + factorise + substitute; }
};

/// Revolute chain with arbitrary frames and inertias, moving.
Case revolute_chain(int bodies) {
  Features features;
  features.prescribed = features.singular_inertias = features.dissipation = features.springs = features.wrenches =
      features.armature = false;
  features.only_joint = "revolute";
  ModelSpec spec = random_spec(12, bodies, features);
  for (int i = 1; i < bodies; ++i) spec.joints[i].parent = spec.bodies[i - 1].name;
  Case c{"chain", Model::build(spec), {}, {}};
  Random random(1);
  c.state = random_state(random, c.model);
  return c;
}

Flops count(const FormulationInfo& info, const Case& c) {
  Evaluator<Count> evaluator(c.model);
  const auto formulation = info.create_count(c.model);
  Solution<Count> solution(c.model);
  const State<Count> state = cast<Count>(c.state);
  const Tally start = Count::tally();
  const System<Count>& system = evaluator.system(state);
  const Tally kinematics = Count::tally();
  formulation->assemble(system);
  EXPECT_TRUE(formulation->factorise(system).usable());
  const Tally factorised = Count::tally();
  formulation->substitute(system, system.rhs, solution);
  const Tally end = Count::tally();
  return {static_cast<long>((kinematics - start).flops()), static_cast<long>((factorised - kinematics).flops()),
          static_cast<long>((end - factorised).flops())};
}

TEST(Flops, of_recursive_on_a_revolute_chain_are_linear_in_n_and_at_most_700_a_body) {
  const FormulationInfo& recursive = *find_formulation("recursive");
  const auto total = [&](int n) { return count(recursive, revolute_chain(n)); };
  const Flops step = {total(9).kinematics - total(8).kinematics, total(9).factorise - total(8).factorise,
                      total(9).substitute - total(8).substitute};
  std::printf("flops a body: kinematics %ld, factorise %ld, substitute %ld, together %ld\n", step.kinematics,
              step.factorise, step.substitute, step.total());
  EXPECT_GT(step.total(), 300) << "too few to have done the work: is everything counted?";
  EXPECT_LE(step.total(), 700);
  for (const int n : {2, 8, 32, 128, 512}) {
    EXPECT_EQ(total(n + 1).total() - total(n).total(), step.total()) << "not linear at n = " << n;
    EXPECT_LE(total(n).total(), 700L * n);
  }
}

TEST(Flops, of_every_formulation_of_our_own_are_those_of_the_state_before) {
  const Case c = revolute_chain(20);
  for (const FormulationInfo& info : formulations()) {
    if (!info.create_count || info.objection(c.model)) continue;
    Case other = c;
    for (double& q : other.state.q) q += 0.3;
    const Flops a = count(info, c), b = count(info, other);
    EXPECT_EQ(a.kinematics, b.kinematics) << info.name;
    EXPECT_EQ(a.factorise, b.factorise) << info.name;
    EXPECT_EQ(a.substitute, b.substitute) << info.name;
    EXPECT_GT(a.factorise, 0) << info.name;
  }
}

TEST(Flops, of_every_other_formulation_exceed_those_of_recursive_on_a_long_chain) {
  const Case c = revolute_chain(64);
  const long recursive = count(*find_formulation("recursive"), c).total();
  for (const FormulationInfo& info : formulations())
    if (info.create_count && !info.recursive && !info.objection(c.model))
      EXPECT_GT(count(info, c).total(), recursive) << info.name;
}

}  // namespace
}  // namespace lanc::test
