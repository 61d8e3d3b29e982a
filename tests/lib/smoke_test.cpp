#include <gtest/gtest.h>
#include "lib/formulation/formulation.h"
#include "lib/system/equations.h"
#include "lib/system/evaluator.h"
using namespace lanc;
TEST(Smoke, pendulum) {
  ModelSpec spec;
  spec.gravity = {0, -9.81, 0};
  BodySpec b;
  b.name = "b";
  b.mass = 1;
  b.com = {1.5, 1, 1};
  b.inertia = Eigen::Vector3d(1, 2, 3).asDiagonal();
  spec.bodies.push_back(b);
  JointSpec j;
  j.name = "j";
  j.kind = *find_joint_kind("revolute");
  j.body = "b";
  spec.joints.push_back(j);
  for (int k = 2; k <= 32; ++k) {
    b.name = "b" + std::to_string(k);
    spec.bodies.push_back(b);
    j.name = "j" + std::to_string(k);
    j.parent = spec.bodies[k - 2].name;
    j.body = b.name;
    j.frame.position = {0.1, 0.2, 0.3};
    j.axis = Eigen::Vector3d(k % 2, k % 3, 1);
    spec.joints.push_back(j);
  }
  Model m = Model::build(spec);
  State<double> s = neutral_state(m);
  for (int k = 0; k < m.nv(); ++k) s.q[k] = 0.1 * k, s.v[k] = 0.3 * k - 1;
  Evaluator<double> e(m);
  for (auto& info : formulations()) {
    auto f = info.create_double(m);
    Solution<double> sol(m);
    auto o = f->solve(e.system(s), sol);
    auto be = backward_error(e.system(s), sol);
    std::printf("%s %s %g cw %g nw %g\n", info.name.data(), to_string(o.status).data(), sol.vdot[0], be.componentwise,
                be.normwise);
    std::vector<double> tau;
    auto s2 = sol;
    inverse_dynamics(e.system(s), s2, tau);
    double mx = 0;
    for (double t : tau) mx = std::max(mx, std::abs(t));
    std::printf("tau %g\n", mx);
    EXPECT_LT(be.componentwise, 1e-10);
    auto fc = info.create_count(m);
    Evaluator<Count> ec(m);
    Solution<Count> sc(m);
    auto sC = cast<Count>(s);
    auto t0 = Count::tally();
    auto& sys = ec.system(sC);
    auto t1 = Count::tally();
    fc->assemble(sys);
    (void)fc->factorise(sys);
    auto t2 = Count::tally();
    fc->substitute(sys, sys.rhs, sc);
    auto t3 = Count::tally();
    std::printf("flops kin %g fact %g subst %g per body, trig %g\n", (t1 - t0).flops() / 32., (t2 - t1).flops() / 32.,
                (t3 - t2).flops() / 32., (t1 - t0).trig / 32.);
    auto c0 = std::chrono::steady_clock::now();
    for (int r = 0; r < 20000; ++r) {
      auto& S = e.system(s);
      (void)f->solve(S, sol);
    }
    auto c1 = std::chrono::steady_clock::now();
    for (int r = 0; r < 20000; ++r) {
      e.system(s);
    }
    auto c2 = std::chrono::steady_clock::now();
    std::printf("ns/body total %g kin %g\n", std::chrono::duration<double>(c1 - c0).count() / 20000 / 32 * 1e9,
                std::chrono::duration<double>(c2 - c1).count() / 20000 / 32 * 1e9);
  }
}
