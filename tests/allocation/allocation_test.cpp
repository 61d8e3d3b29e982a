// Nothing allocates after binding: a counting operator new in this program alone.
#include <gtest/gtest.h>

#include <atomic>
#include <cstdlib>
#include <fstream>
#include <new>
#include <string>

#include "lib/derivatives/forward_derivatives.h"
#include "lib/formulation/formulation.h"
#include "lib/system/equations.h"
#include "lib/system/evaluator.h"
#include "tests/support/zoo.h"

namespace {
std::atomic<long> allocations{0};

void* counted(std::size_t size, std::size_t alignment) {
  ++allocations;
  const std::size_t rounded = (size + alignment - 1) / alignment * alignment;
  if (void* p = std::aligned_alloc(alignment, rounded == 0 ? alignment : rounded)) return p;
  throw std::bad_alloc();
}
}  // namespace

// not inlined: g++ would then miss that every new of this program is one of these
[[gnu::noinline]] void* operator new(std::size_t size) { return counted(size, alignof(std::max_align_t)); }
[[gnu::noinline]] void* operator new[](std::size_t size) { return counted(size, alignof(std::max_align_t)); }
[[gnu::noinline]] void* operator new(std::size_t size, std::align_val_t a) {
  return counted(size, static_cast<std::size_t>(a));
}
[[gnu::noinline]] void* operator new[](std::size_t size, std::align_val_t a) {
  return counted(size, static_cast<std::size_t>(a));
}
[[gnu::noinline]] void operator delete(void* p) noexcept { std::free(p); }
[[gnu::noinline]] void operator delete[](void* p) noexcept { std::free(p); }
[[gnu::noinline]] void operator delete(void* p, std::size_t) noexcept { std::free(p); }
[[gnu::noinline]] void operator delete[](void* p, std::size_t) noexcept { std::free(p); }
[[gnu::noinline]] void operator delete(void* p, std::align_val_t) noexcept { std::free(p); }
[[gnu::noinline]] void operator delete[](void* p, std::align_val_t) noexcept { std::free(p); }
[[gnu::noinline]] void operator delete(void* p, std::size_t, std::align_val_t) noexcept { std::free(p); }
[[gnu::noinline]] void operator delete[](void* p, std::size_t, std::align_val_t) noexcept { std::free(p); }

namespace lanc::test {
namespace {

/// A formulation whose README says so may allocate inside its library: a section "Allocates in solve" that does not
/// begin with "Nothing".
bool may_allocate(const FormulationInfo& info) {
  std::ifstream file(std::string(LANC_SOURCE_DIR) + "/formulations/" + std::string(info.name) + "/README.md");
  const std::string text{std::istreambuf_iterator<char>(file), {}}, section = "**Allocates in solve.** ";
  const std::size_t at = text.find(section);
  return at != std::string::npos && text.compare(at + section.size(), 7, "Nothing") != 0;
}

bool has_formula(const Model& model) {
  for (const JointSpec& joint : model.spec().joints)
    if (joint.motion &&
        (std::holds_alternative<Formula>(*joint.motion) || std::holds_alternative<SplineTable>(*joint.motion)))
      return true;
  return false;
}

TEST(Allocation, the_guard_sees_allocations) {
  const long before = allocations;
  std::vector<int>* grown = new std::vector<int>(100);
  EXPECT_EQ(allocations - before, 2);
  delete grown;
}

TEST(Allocation, the_evaluator_allocates_nothing_after_binding) {
  for (const Case& c : small_zoo()) {
    if (has_formula(c.model)) continue;  // motions by formula or table use a stack of their own
    Evaluator<double> evaluator(c.model);
    const long before = allocations;
    evaluator.system(c.state, c.loads);
    evaluator.positions();
    evaluator.twists();
    EXPECT_EQ(allocations - before, 0) << c.name;
  }
}

TEST(Allocation, analytic_derivatives_allocate_nothing_after_binding) {
  for (const Case& c : small_zoo()) {
    Evaluator<double> evaluator(c.model);
    const System<double>& system = evaluator.system(c.state, c.loads);
    Solution<double> solution(c.model);
    if (!find_formulation("recursive")->create_double(c.model)->solve(system, solution).usable()) continue;
    AnalyticDerivatives derivatives(c.model);
    const long before = allocations;
    const Outcome outcome = derivatives.at(evaluator, system, c.state, c.loads, solution);
    if (outcome.usable()) EXPECT_EQ(allocations - before, 0) << c.name;
  }
}

TEST(Allocation, no_formulation_allocates_in_solve_after_binding) {
  for (const Case& c : small_zoo()) {
    Evaluator<double> evaluator(c.model);
    const System<double>& system = evaluator.system(c.state, c.loads);
    for (const FormulationInfo& info : formulations()) {
      if (!info.create_double || info.objection(c.model) || may_allocate(info)) continue;
      const auto formulation = info.create_double(c.model);
      Solution<double> solution(c.model);
      for (int call = 0; call < 2; ++call) {
        const long before = allocations;
        const Outcome outcome = formulation->solve(system, solution);
        if (outcome.usable()) EXPECT_EQ(allocations - before, 0) << info.name << " on " << c.name << ", call " << call;
      }
    }
  }
}

}  // namespace
}  // namespace lanc::test
