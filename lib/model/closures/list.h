// The one list of closure kinds: every joint kind that takes freedoms away, and the closures that are no joints. A new
// closure kind is an entry of `own_closures`; a new joint brings its conditions in its own file.
#pragma once

#include <optional>
#include <span>
#include <string_view>

#include "lib/model/joints/list.h"

namespace lanc {

struct ClosureTraits {
  std::string_view name;
  Conditions conditions;
  JointAxes axes = JointAxes::none;
  bool has_pitch = false, has_length = false;
  std::optional<JointKind> joint;  // the joint kind that stands behind it

  /// Its motion can be prescribed: the length, or the coordinate of a joint with one freedom. A prescribed joint has
  /// the conditions of a fixed one, the frame A being moved by the motion.
  bool can_be_driven() const { return has_length || (joint && joint->traits().nv == 1); }
};

namespace closures {
constexpr ClosureTraits own_closures[] = {
    {.name = "point-on-line",  // the line is `axis` through A
     .conditions = {2, {conditions::x, conditions::y}},
     .axes = JointAxes::one},
    {.name = "point-on-plane",  // `axis` is the normal of the plane through A
     .conditions = {1, {conditions::z}},
     .axes = JointAxes::one},
    {.name = "point-on-point", .conditions = {3, {conditions::x, conditions::y, conditions::z}}},
    {.name = "distance", .conditions = {1, {Condition{ConditionKind::distance, 0, 0, "length"}}}, .has_length = true},
    {.name = "equal-orientation",
     .conditions = {3, {conditions::turn_x, conditions::turn_y, conditions::turn_z}, "xyz"}},
};

constexpr auto all_closures = [] {
  std::array<ClosureTraits, joint_kinds - 1 + std::size(own_closures)> list;
  std::size_t next = 0;
  const auto joints = for_each_joint_kind([]<class Joint>() { return Joint::traits; });
  for (unsigned char k = 0; k < joint_kinds; ++k)
    if (joints[k].closure.count > 0)
      list[next++] = {joints[k].name, joints[k].closure, joints[k].axes, joints[k].has_pitch, false, JointKind{k}};
  for (const ClosureTraits& own : own_closures) list[next++] = own;
  return list;
}();
}  // namespace closures

/// One of the closure kinds, as a value.
struct ClosureKind {
  unsigned char index = 0;

  const ClosureTraits& traits() const { return closures::all_closures[index]; }
  friend bool operator==(ClosureKind, ClosureKind) = default;
};

inline std::optional<ClosureKind> find_closure_kind(std::string_view name) {
  for (unsigned char k = 0; k < closures::all_closures.size(); ++k)
    if (ClosureKind{k}.traits().name == name) return ClosureKind{k};
  return std::nullopt;
}

}  // namespace lanc
