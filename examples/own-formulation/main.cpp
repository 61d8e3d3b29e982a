// A formulation from outside the tree: eq. 14 as it stands, by Eigen's sparse LU; compared with all that lanc has.
#include <Eigen/SparseLU>
#include <cmath>
#include <cstdio>

#include "lib/lanc.h"

namespace {

class EigenLu final : public lanc::Formulation<double> {
 public:
  explicit EigenLu(const lanc::Model& model) : Formulation(model), eq14_(model) { lu_.analyzePattern(view()); }

  void assemble(const lanc::System<double>& system) override { eq14_.refill(system); }

  lanc::Outcome factorise(const lanc::System<double>&) override {
    lu_.factorize(view());
    if (lu_.info() != Eigen::Success) return {lanc::Status::singular, lu_.lastErrorMessage()};
    return {};
  }

  void substitute(const lanc::System<double>&, const lanc::RightHandSide<double>& rhs,
                  lanc::Solution<double>& solution) override {
    eq14_.scatter(rhs, b_);
    const Eigen::VectorXd x = lu_.solve(Eigen::VectorXd::Map(b_.data(), eq14_.size()));
    eq14_.gather({x.begin(), x.end()}, solution);
  }

 private:
  using Matrix = Eigen::SparseMatrix<double>;

  Eigen::Map<const Matrix> view() const {
    return {eq14_.size(),          eq14_.size(),        eq14_.nonzeros(),
            eq14_.starts().data(), eq14_.rows().data(), eq14_.values().data()};
  }

  lanc::Eq14Matrix<double> eq14_;
  Eigen::SparseLU<Matrix> lu_;
  std::vector<double> b_ = std::vector<double>(eq14_.size());
};

const lanc::Registration registration({.name = "eigen-lu",
                                       .idea = "eq. 14 as it stands, sparse LU of Eigen",
                                       .source = "Eigen",
                                       .create_double = lanc::create<EigenLu, double>});

}  // namespace

int main(int argc, char** argv) try {
  const lanc::Mechanism mechanism = lanc::load_mechanism(argc > 1 ? argv[1] : "chain:10:joint=spherical");
  lanc::PhaseTimer reference(lanc::find_formulation("recursive")->create_double, mechanism.model, mechanism.state);
  std::printf("%-16s %-12s %15s %12s %9s %8s\n", "formulation", "status", "backward error", "difference", "flops",
              "us");
  for (const lanc::FormulationInfo& info : lanc::formulations()) {
    if (const auto why = info.objection(mechanism.model)) {
      std::printf("%-16s %s\n", info.name.data(), why->c_str());
      continue;
    }
    lanc::PhaseTimer own(info.create_double, mechanism.model, mechanism.state);
    double difference = 0;
    for (int k = 0; k < mechanism.model.nv(); ++k)
      difference = std::max(difference, std::abs(own.solution().vdot[k] - reference.solution().vdot[k]));
    const double error = lanc::backward_error(own.system(), own.solution()).componentwise;
    const double seconds = own.repetition().back().value;  // rows by phase; the last is the total
    std::printf("%-16s %-12s %15.1e %12.1e", info.name.data(), to_string(own.outcome().status).data(), error,
                difference);
    if (info.create_count) {
      const lanc::PhaseCounts flops = lanc::count_phases(info, mechanism.model, mechanism.state);
      std::printf(" %9lld",
                  static_cast<long long>((flops.assemble.flops() + flops.factorise.flops() + flops.solve.flops())));
    } else {
      std::printf(" %9s", "");
    }
    std::printf(" %8.2f\n", 1e6 * seconds);
  }
} catch (const lanc::InputError& error) {
  std::fprintf(stderr, "%s\n", error.what());
  return 1;
}
