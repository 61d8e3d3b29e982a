#include "tests/support/fuzzed_loops.h"

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "lib/closure/assembly.h"
#include "lib/formulation/formulation.h"
#include "lib/io/mechanism.h"
#include "lib/system/evaluator.h"
#include "tests/support/closed_reference.h"
#include "tests/support/loop_cases.h"
#include "tests/support/tolerance.h"

namespace lanc::test {
namespace {

/// 10 to a power drawn between two exponents.
double magnitude(Random& random, double lowest, double highest) {
  return std::pow(10.0, random.uniform(lowest, highest));
}

const std::vector<std::string>& linkages() {
  static const std::vector<std::string> files = [] {
    std::vector<std::string> list;
    for (const auto& entry : std::filesystem::directory_iterator(LANC_SOURCE_DIR "/data/models/linkages"))
      if (entry.path().extension() == ".toml") list.push_back(entry.path().string());
    std::sort(list.begin(), list.end());
    return list;
  }();
  return files;
}

Case of_generator(const std::string& argument) {
  const Mechanism m = load_mechanism(argument);
  return {argument, m.model, m.state, {}};
}

Case whole(Random& random, std::uint64_t seed) {
  const auto pick = [&](const std::vector<Case>& cases) { return cases[random.below(static_cast<int>(cases.size()))]; };
  const auto number = [&](int n) { return std::to_string(1 + random.below(n)); };
  switch (random.below(8)) {
    case 0:
    case 1:
    case 2: return of_generator("random-loops:" + number(4) + ":seed=" + std::to_string(seed));
    case 3:
    case 4: return tangle(seed, 1 + random.below(4));
    case 5: {
      const char* cuts[] = {"point", "hinge", "weld"};
      const double angles[] = {0, 1.5707963267948966, random.uniform(-3, 3)};
      return of_generator(std::string("four-bar-") + (random.chance(0.5) ? "ladder:" : "chain:") + number(5) +
                          ":cut=" + cuts[random.below(3)] + ":angle=" + std::to_string(angles[random.below(3)]) +
                          ":rate=" + std::to_string(random.uniform(-2, 2)));
    }
    case 6: return of_generator(linkages()[random.below(static_cast<int>(linkages().size()))]);
    default: {
      static const std::vector<Case> closed = closed_loops(), held = held_by_loops();
      return random.chance(0.7) ? pick(closed) : pick(held);
    }
  }
}

void lighten(Random& random, ModelSpec& spec) {
  BodySpec& body = spec.bodies[random.below(static_cast<int>(spec.bodies.size()))];
  const double factor = random.chance(0.3) ? 0 : magnitude(random, -16, 0);
  body.mass *= factor, body.inertia *= factor;
}

void double_closure(Random& random, ModelSpec& spec) {
  if (spec.closures.empty()) return;
  ClosureSpec again = spec.closures[random.below(static_cast<int>(spec.closures.size()))];
  again.name += "_again";
  if (random.chance(0.6)) again.frame_b.position += magnitude(random, -16, -3) * random.direction();
  if (random.chance(0.2) && again.kind.traits().can_be_driven() && again.motion)
    again.motion = ConstantSpeed{0, random.uniform(-1, 1)};  // contradicts it
  spec.closures.push_back(std::move(again));
}

/// Positions near the state's; Euler parameters stay normalised.
void move_positions(Random& random, Case& c, double size) {
  for (double& q : c.state.q) q += size * random.uniform(-1, 1);
  for (const Link& link : c.model.links()) {
    if (link.kind.traits().quaternion < 0 || link.nq == 0) continue;
    double* p = &c.state.q[link.q + link.kind.traits().quaternion];
    const double norm = std::sqrt(p[0] * p[0] + p[1] * p[1] + p[2] * p[2] + p[3] * p[3]);
    for (int k = 0; k < 4; ++k) p[k] /= norm;
  }
}

void assemble_if_possible(Case& c) {
  AssemblyOptions options;
  options.starts = 2, options.steps = 60;
  AssemblyResult positions = assemble(c.model, c.state, options);
  if (!positions.assembled()) return;
  VelocityResult velocities = consistent_velocities(c.model, std::move(positions.state));
  c.state = std::move(velocities.state);
}

/// The largest |g| and |Gη + γ̄|, rows that are lengths in units of the model's.
double violation(const System<long double>& system) {
  const Model& model = system.model;
  long double worst = 0;
  for (int k = 0; k < model.closures().rows(); ++k) {
    const auto& row = system.closure_rows[k];
    const double unit = model.closures().row_is_length[k] ? model.length() : 1;
    worst = std::max({worst, std::abs(row.g) / unit, std::abs(row.rate) / unit});
  }
  return static_cast<double>(worst);
}

/// Why an answer with status solved or redundant is wrong; empty when it is right.
std::string fault(const System<long double>& wide, const ClosedReference& reference, const Outcome& outcome,
                  const Solution<double>& solution, double& worst) {
  constexpr double promised = 1e-6;
  const Model& model = wide.model;
  const auto number = [](double x) { return std::to_string(std::log10(x)); };
  if (violation(wide) > 10 * promised) return "the state violates conditions: lg " + number(violation(wide));
  if (reference.contradiction > 10 * promised) return "conditions contradict one another";
  if (!std::isfinite(reference.kernel_condition)) return "there is no one answer";
  if (outcome.rank != reference.rank)
    return "rank " + std::to_string(outcome.rank) + " instead of " + std::to_string(reference.rank);
  Norms size = sizes(wide, reference.solution);
  // loads that balance leave accelerations of rounding errors: measured by what the loads would do to the masses
  double mass = 0;
  for (const BodySpec& body : model.spec().bodies) mass = std::max(mass, body.mass);
  if (mass > 0) size.acceleration = size.vdot = std::max(size.acceleration, size.wrench / mass);
  const Norms error = relative(difference(model, solution, reference.solution), size);
  const double reaction = reaction_error(reference, solution, model) / size.wrench;
  const double largest = std::max({error.vdot, error.acceleration, size.wrench > 0 ? reaction : 0});
  const double allowed = std::clamp(epsilon * reference.kernel_condition, promised, 1e-4);
  if (largest <= allowed) {
    worst = std::max(worst, largest);
    return {};
  }
  return "errors lg " + number(error.vdot) + " of vdot, " + number(error.acceleration) + " of accelerations, " +
         number(reaction) + " of reactions; condition lg " + number(reference.kernel_condition);
}

}  // namespace

Case fuzzed_loops(std::uint64_t seed) {
  Random random(seed);
  Case c = whole(random, seed);
  ModelSpec spec = c.model.spec();
  bool damaged = false;
  const auto perhaps = [&](double probability) { return random.chance(probability) && (damaged = true); };
  if (perhaps(0.2)) lighten(random, spec);
  if (perhaps(0.2)) double_closure(random, spec);
  if (perhaps(0.1)) spec.gravity.setZero();
  if (damaged) c.model = Model::build(std::move(spec));
  if (random.chance(0.1)) c.state = neutral_state(c.model);
  if (random.chance(0.4)) c.loads = random_loads(random, c.model);
  if (random.chance(0.5)) move_positions(random, c, 0.3), assemble_if_possible(c);
  if (random.chance(0.15)) move_positions(random, c, magnitude(random, -16, -3));
  return c;
}

void judge_fuzzed_loops(std::uint64_t seed, FuzzTally& tally) {
  ++tally.mechanisms;
  std::optional<Case> drawn;
  try {
    drawn = fuzzed_loops(seed);
  } catch (const InputError&) {
    ++tally.refused;
    return;
  }
  const Case& c = *drawn;
  const System<long double> wide = system_in_long_double(c);
  std::optional<ClosedReference> reference;
  Evaluator<double> evaluator(c.model);
  const System<double>& system = evaluator.system(c.state, c.loads);
  for (const FormulationInfo& info : formulations()) {
    if (!info.create_double) continue;
    Status status = Status::objection;
    if (!info.objection(c.model)) {
      Solution<double> solution(c.model);
      const Outcome outcome = info.create_double(c.model)->solve(system, solution);
      status = outcome.status;
      if (outcome.usable()) {
        if (!reference) reference = solve_closed_naively(wide);
        if (const std::string why = fault(wide, *reference, outcome, solution, tally.worst); !why.empty())
          tally.wrong.push_back("seed " + std::to_string(seed) + " (" + c.name + "), " + std::string(info.name) + ", " +
                                std::string(to_string(status)) + ": " + why);
      }
    }
    ++tally.statuses[std::string(info.name) + " " + std::string(to_string(status))];
  }
}

}  // namespace lanc::test
