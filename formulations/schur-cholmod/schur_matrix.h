// The Schur complement S = G M⁻¹ Gᵀ of eq. 14 in maximal coordinates, G the implicit conditions of all joints.
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <span>

#include "lib/system/system.h"

namespace lanc {

/// Joint i lets d_i = â_i − B_ip â_p − ā^rel_i be C_i η̇_i. With K_i an orthonormal basis of the wrenches that do no
/// work (C_iᵀ K_i = 0) and P_i the dual of C_i (C_iᵀ P_i = 1, P_iᵀ = C_i⁺):
///
///   f̂_i = K_i λ_i + P_i φ_i,  φ_i = C_iᵀ f̂_i = τ_i − A_i η̇_i,  K_iᵀ d_i = 0,  P_iᵀ d_i = η̇_i
///
/// Freedoms without armature have φ = τ, known. One with armature A joins the unknowns, its row P_iᵀ d_i + φ/A = τ/A.
/// With W_i = [K_i, P_i of armature], μ_i = (λ_i, φ_i), â = M⁻¹ (loads + Gᵀ μ): S μ = b, S = G M⁻¹ Gᵀ + diag(0, 1/A),
/// G_i = W_iᵀ on body i and −W_iᵀ B_ip on its parent. Joints meeting at a body are coupled with each other, so body
/// with k joints makes a dense block of k; joints leaf to root are a perfect elimination order, without fill.
///
/// A closure is a set of conditions more, on the bodies it acts on: its rows G_s join G, its λ the unknowns, after all
/// joints, which fills. Rows that depend on others are replaced by λ = 0. A coupler is one on P_iᵀ d_i, so it acts by
/// P_i on a body and by −B_ipᵀ P_i on its parent; φ of a freedom with armature holds what the coupler adds to τ, hence
/// Σ f η̇ with η̇ = (τ + f λ − φ)/A there.
///
/// Allocates in the constructor only. S: double, long double, Count.
template <class S>
class SchurMatrix {
 public:
  explicit SchurMatrix(const Model& model);

  /// Entries of the upper triangle of S; with closures an upper bound.
  static std::int64_t count_nonzeros(const Model& model);

  /// The values of S at another state; per closure row, whether it counts (ClosureDecision::independent).
  void refill(const System<S>& system, std::span<const char> counts);
  /// b for a right-hand side of eq. 14; keeps what gather() needs.
  void scatter(const System<S>& system, const RightHandSide<S>& rhs, std::vector<S>& b);
  /// η̇, â and f̂ from μ, for the right-hand side of the last scatter().
  void gather(const System<S>& system, const RightHandSide<S>& rhs, const std::vector<S>& mu, Solution<S>& solution);

  /// Upper triangle of S by columns, joints leaf to root.
  int size() const { return static_cast<int>(starts_.size()) - 1; }
  const std::vector<int>& starts() const { return starts_; }
  const std::vector<int>& rows() const { return rows_; }
  const std::vector<S>& values() const { return values_; }

  /// Least pivot of the elimination of M_i relative to the diagonal entry it is what is left of: the factor by which
  /// inverting M_i may magnify rounding errors, whatever the units.
  double inertia_quality(int body) const { return bodies_[body].quality; }
  int start(int joint) const { return joints_[joint].start; }
  int unknowns(int joint) const { return joints_[joint].size; }
  /// Value of S at (k, k).
  const S& diagonal(int k) const { return values_[starts_[k + 1] - 1]; }

 private:
  struct Body {  // M⁻¹: about the centre of mass, J_c = L D Lᵀ
    Vec3<S> c;
    S inverse_mass;
    S l21, l31, l32;
    Vec3<S> inverse_d;
    double quality = 1;

    void invert(const RigidInertia<S>& M);
    Motion<S> times(const Wrench<S>& f) const;
  };
  struct Joint {
    int start = 0, size = 0;           // of μ_i in the matrix
    int first = 0;                     // of W_i in w_
    int coupled = 0, coupled_end = 0;  // in couplings_: the joints further to the root that meet it at its parent
    int own_offset = 0;                // of the diagonal block in its columns
    int column = 0;                    // where its first column starts in values_
  };
  struct Coupling {
    int joint, offset;  // rows of the one joint in the columns of the other
  };

  /// A closure row on one of the bodies it acts on.
  struct End {
    int row, body;
    enum class What : unsigned char { a, b, coordinate, coordinate_of_child } what;
    int velocity = -1;  // of a coupler
    double factor = 0;
  };
  /// An end meets something else that acts on its body: zᵀ w goes into the slot.
  struct Meeting {
    enum class With : unsigned char { joint, joint_of_child, closure } with;
    int end, other;  // index in w_, in y_, or another end
    int slot = 0;
  };
  /// A coupler's row on a freedom with armature.
  struct Geared {
    int row, velocity;
    double factor;
    int slot = 0;  // of λ with φ
  };
  using Column = std::map<int, std::vector<Meeting>>;  // by row of the matrix

  void build();
  void append_closures();
  void find_ends();
  int armature_unknown(int velocity) const;
  void refill_closures(const System<S>& system);
  void scatter_closures(const RightHandSide<S>& rhs, std::vector<S>& b) const;
  void joint_bases(const System<S>& system, int i);

  Model model_;
  std::vector<Body> bodies_;
  std::vector<Joint> joints_;
  std::vector<Coupling> couplings_;
  std::vector<Wrench<S>> w_, y_;         // W_i; −B_ipᵀ W_i
  std::vector<Motion<S>> z_;             // M_p⁻¹ y
  std::vector<Wrench<S>> p_;             // P_i, one per velocity
  std::vector<Wrench<S>> load_, known_;  // loads of the bodies, P τ of the joints
  std::vector<Motion<S>> free_;          // M⁻¹ load
  int closure_start_ = 0;                // of the first closure row in the matrix
  std::vector<End> ends_;
  std::vector<Wrench<S>> end_w_;  // G_s
  std::vector<Motion<S>> end_z_;  // M⁻¹ G_sᵀ
  std::vector<Geared> geared_;
  std::vector<Meeting> meetings_;
  std::vector<char> counts_;
  std::vector<int> starts_, rows_;
  std::vector<S> values_;
};

extern template class SchurMatrix<double>;
extern template class SchurMatrix<long double>;
extern template class SchurMatrix<Count>;

}  // namespace lanc
