// Batches: what a state gets among others is what Formulation::solve() gives it alone.
#include "lib/formulation/batch.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <limits>

#include "lib/io/generators.h"
#include "lib/model/error.h"
#include "lib/system/evaluator.h"
#include "tests/support/zoo.h"

namespace lanc::test {
namespace {

/// States about a given one: every coordinate moved a little, Euler parameters normalised again.
struct Cloud {
  BatchStates states;
  std::vector<double> q, v, tau;

  Cloud(const Model& model, const State<double>& about, int count) {
    for (int k = 0; k < count; ++k) {
      State<double> state = about;
      for (std::size_t i = 0; i < state.q.size(); ++i) state.q[i] += 1e-7 * std::sin(1 + 3.0 * k + double(i));
      state = checked_state(model, state);
      for (std::size_t i = 0; i < state.v.size(); ++i) {
        state.v[i] += 0.3 * std::cos(2 + 5.0 * k + double(i));
        tau.push_back(std::sin(4.0 * k - double(i)));
      }
      q.insert(q.end(), state.q.begin(), state.q.end());
      v.insert(v.end(), state.v.begin(), state.v.end());
    }
    states = {about.t, q, v, tau};
  }
};

void expect_answers_of_solve(const Model& model, const FormulationInfo& info, const BatchStates& states,
                             const BatchAnswers& answers, const std::string& who) {
  Evaluator<double> evaluator(model);
  Solution<double> solution(model);
  const auto formulation = info.create_double(model);
  for (std::size_t k = 0; k < answers.status.size(); ++k) {
    const int state = static_cast<int>(k);
    const Outcome alone =
        formulation->solve(evaluator.system(states.state(model, state), states.loads(model, state)), solution);
    ASSERT_EQ(answers.status[k], alone.status) << who << " state " << k;
    if (const auto told = answers.outcome.find(state); told != answers.outcome.end())
      EXPECT_EQ(told->second.message, alone.message) << who << " state " << k;
    else
      EXPECT_EQ(alone.message, "") << who << " state " << k;
    if (!alone.usable()) continue;
    double size = 0, apart = 0;
    for (int i = 0; i < model.nv(); ++i) {
      size = std::max(size, std::abs(solution.vdot[i]));
      apart = std::max(apart, std::abs(solution.vdot[i] - answers.vdot[k * model.nv() + i]));
    }
    EXPECT_LE(apart, 1e-9 * size) << who << " state " << k;
    if (answers.wrench.empty()) continue;
    double force = 0, force_apart = 0, acceleration = 0, acceleration_apart = 0;
    const auto compare = [](const auto& a, const auto& b, double& largest, double& difference) {
      for (int x = 0; x < 3; ++x) {
        largest = std::max(largest, std::abs(a[x]));
        difference = std::max(difference, std::abs(a[x] - b[x]));
      }
    };
    for (int i = 0; i < model.bodies(); ++i) {
      const Wrench<double>&f = solution.wrench[i], &g = answers.wrench[k * model.bodies() + i];
      const Motion<double>&a = solution.acceleration[i], &b = answers.acceleration[k * model.bodies() + i];
      const auto numbers = [](const Vec3<double>& x) { return std::array{x.x, x.y, x.z}; };
      compare(numbers(f.moment), numbers(g.moment), force, force_apart);
      compare(numbers(f.force), numbers(g.force), force, force_apart);
      compare(numbers(a.angular), numbers(b.angular), acceleration, acceleration_apart);
      compare(numbers(a.linear), numbers(b.linear), acceleration, acceleration_apart);
    }
    EXPECT_LE(force_apart, 1e-9 * (1 + force)) << who << " state " << k;
    EXPECT_LE(acceleration_apart, 1e-9 * (1 + acceleration)) << who << " state " << k;
  }
}

TEST(Batch, gives_every_state_of_every_tree_what_solve_gives_it) {
  for (const FormulationInfo& info : formulations()) {
    if (!info.create_kernel) continue;
    for (const Case& c : small_zoo()) {
      if (info.objection(c.model)) continue;
      const Cloud cloud(c.model, c.state, 21);
      for (const int threads : {1, 0})
        for (const bool all_outputs : {true, false}) {
          Batch batch(c.model, info, {threads, all_outputs});
          BatchAnswers answers;
          batch.solve(cloud.states, answers);
          EXPECT_EQ(answers.status.size(), c.model.nv() == 0 ? 0u : 21u);
          EXPECT_EQ(answers.wrench.empty(), !all_outputs || answers.status.empty());
          expect_answers_of_solve(c.model, info, cloud.states, answers, c.name);
        }
    }
  }
}

TEST(Batch, of_regular_states_solves_none_alone) {
  for (const char* argument :
       {"chain:12", "tree:63", "random:40:seed=3", "chain:20:joint=spherical", "tree:7:joint=free", "chain:250",
        "chain:1000", "chain:8:joint=free:gravity=0", "tree:15:joint=free:gravity=0"})
    for (const bool all_outputs : {true, false}) {
      const Mechanism m = *generate(argument);
      const Cloud cloud(m.model, m.state, 21);
      Batch batch(m.model, *find_formulation("recursive"), {1, all_outputs});
      ASSERT_GT(batch.lanes(), 1);
      for (const bool with_tau : {true, false}) {
        const BatchStates states{cloud.states.t, cloud.q, cloud.v,
                                 with_tau ? cloud.states.tau : std::span<const double>{}};
        BatchAnswers answers;
        batch.solve(states, answers);
        EXPECT_TRUE(answers.outcome.empty()) << argument << " " << answers.outcome.size();
        expect_answers_of_solve(m.model, *find_formulation("recursive"), states, answers, argument);
      }
    }
}

TEST(Batch, keeps_a_state_that_cannot_be_solved_to_itself) {
  for (const char* argument : {"chain:9", "random:20:seed=3"}) {
    const Mechanism m = *generate(argument);
    const FormulationInfo& info = *find_formulation("recursive");
    Cloud cloud(m.model, m.state, 19);
    cloud.q[3 * m.model.nq()] = std::numeric_limits<double>::quiet_NaN();
    cloud.v[11 * m.model.nv() + 1] = std::numeric_limits<double>::infinity();
    cloud.tau[17 * m.model.nv()] = std::numeric_limits<double>::quiet_NaN();
    for (const bool all_outputs : {true, false}) {
      Batch batch(m.model, info, {1, all_outputs});
      ASSERT_GT(batch.lanes(), 1);
      BatchAnswers answers;
      batch.solve(cloud.states, answers);
      for (int k = 0; k < 19; ++k)
        EXPECT_EQ(answers.status[k], k == 3 || k == 11 || k == 17 ? Status::not_finite : Status::solved) << k;
      expect_answers_of_solve(m.model, info, cloud.states, answers, argument);
    }
  }
}

TEST(Batch, solves_loops_and_formulations_without_kernels_state_by_state) {
  const Mechanism m = *generate("four-bar-ladder:2:angle=0.7:rate=0.4");
  for (const char* name : {"recursive", "eq14-klu"}) {
    Cloud one(m.model, m.state, 1);
    std::vector<double> q, v;
    for (int k = 0; k < 3; ++k) {
      q.insert(q.end(), m.state.q.begin(), m.state.q.end());
      v.insert(v.end(), m.state.v.begin(), m.state.v.end());
    }
    const BatchStates states{m.state.t, q, v, {}};
    Batch batch(m.model, *find_formulation(name), {0, true});
    EXPECT_EQ(batch.lanes(), 1);
    BatchAnswers answers;
    batch.solve(states, answers);
    expect_answers_of_solve(m.model, *find_formulation(name), states, answers, name);
    EXPECT_EQ(answers.status[2], Status::redundant);
    EXPECT_EQ(answers.outcome.size(), 3u);
    EXPECT_EQ(answers.outcome.at(2).redundant, 2);
  }
}

TEST(Batch, forgets_the_states_of_the_batch_before) {
  const Mechanism m = *generate("chain:9");
  Cloud many(m.model, m.state, 21), few(m.model, m.state, 3);
  many.q[0] = std::numeric_limits<double>::quiet_NaN();
  BatchAnswers answers;
  Batch(m.model, *find_formulation("recursive"), {2, true}).solve(many.states, answers);
  EXPECT_EQ(answers.status[0], Status::not_finite);
  EXPECT_FALSE(answers.outcome.at(0).message.empty());
  EXPECT_EQ(answers.outcome.size(), 1u);
  Batch batch(m.model, *find_formulation("recursive"), {1});
  batch.solve(few.states, answers);
  EXPECT_EQ(answers.status, std::vector<Status>(3, Status::solved));
  EXPECT_TRUE(answers.outcome.empty());
  EXPECT_TRUE(answers.wrench.empty());
  batch.solve({0, {}, {}, {}}, answers);
  EXPECT_TRUE(answers.status.empty() && answers.vdot.empty());
}

TEST(Batch, refuses_what_is_no_whole_number_of_states) {
  const Mechanism m = *generate("chain:3");
  Batch batch(m.model, *find_formulation("recursive"));
  BatchAnswers answers;
  const std::vector<double> three(3), four(4), six(6);
  EXPECT_THROW(batch.solve({0, four, four, {}}, answers), InputError);
  EXPECT_THROW(batch.solve({0, six, three, {}}, answers), InputError);
  EXPECT_THROW(batch.solve({0, three, three, six}, answers), InputError);
  EXPECT_NO_THROW(batch.solve({0, three, three, {}}, answers));
  EXPECT_NO_THROW(batch.solve({0, {}, {}, {}}, answers));
}

}  // namespace
}  // namespace lanc::test
