// What closes a loop, said as data: a closure kind is a list of scalar conditions between two frames.
//
// A sits on body a (the predecessor of a secondary joint), B on body b. A condition is one row of g = 0; its exact
// derivatives G, γ̄ and γ̿ are taken in one place (lib/system/closure_rows.h), for whatever list a kind consists of.
#pragma once

#include <array>
#include <string_view>

namespace lanc {

enum class ConditionKind : unsigned char {
  along,          // e_i^A · (p_B − p_A) = 0, m: B's origin is not displaced along axis i of A
  perpendicular,  // e_i^A · e_j^B = 0: two axes stay at right angles
  turn,           // ½ (e_k^A · e_j^B − e_j^A · e_k^B) = 0, (i, j, k) cyclic: the sine of a turn about axis i
  distance,       // |p_B − p_A| − length = 0, m
  screw           // sin(travel / pitch − angle) = 0, travel and angle along and about z: the thread of a screw
};

/// One scalar closure condition. `i` and `j` number axes: x, y, z = 0, 1, 2.
struct Condition {
  ConditionKind kind = ConditionKind::along;
  unsigned char i = 0, j = 0;
  std::string_view name;  // of the row, after the closure's: "hinge.x"

  /// Its value is a length (m), so that the row is scaled by the model's; otherwise a pure number.
  bool is_length() const { return kind == ConditionKind::along || kind == ConditionKind::distance; }
};

/// The conditions of a closure kind.
struct Conditions {
  int count = 0;
  std::array<Condition, 6> rows{};
  /// Axes of A and B that must point the same way: `perpendicular` and `turn` rows also vanish half a turn away, and
  /// such a flipped assembly is another mechanism. "z", "xyz", or none.
  std::string_view aligned = {};

  /// Whether a row is about the place of B's origin along an axis of A.
  constexpr bool has_along() const {
    for (int k = 0; k < count; ++k)
      if (rows[k].kind == ConditionKind::along || rows[k].kind == ConditionKind::screw) return true;
    return false;
  }
  /// Whether all are, so that nothing turns on B's axes.
  constexpr bool only_along() const {
    for (int k = 0; k < count; ++k)
      if (rows[k].kind != ConditionKind::along) return false;
    return true;
  }
};

// The rows joints are made of.
namespace conditions {
constexpr Condition x{ConditionKind::along, 0, 0, "x"}, y{ConditionKind::along, 1, 0, "y"},
    z{ConditionKind::along, 2, 0, "z"};
constexpr Condition turn_x{ConditionKind::turn, 0, 0, "rx"}, turn_y{ConditionKind::turn, 1, 0, "ry"},
    turn_z{ConditionKind::turn, 2, 0, "rz"};
/// z of B stays parallel to z of A: no turn about x, none about y.
constexpr Condition tilt_x{ConditionKind::perpendicular, 1, 2, "rx"}, tilt_y{ConditionKind::perpendicular, 0, 2, "ry"};
}  // namespace conditions

}  // namespace lanc
