// The one list of joint kinds. A new joint is a file in this folder and its name here.
#pragma once

#include <optional>
#include <span>
#include <tuple>

#include "lib/model/joints/cylindrical.h"
#include "lib/model/joints/fixed.h"
#include "lib/model/joints/free.h"
#include "lib/model/joints/helical.h"
#include "lib/model/joints/planar.h"
#include "lib/model/joints/prismatic.h"
#include "lib/model/joints/revolute.h"
#include "lib/model/joints/spherical.h"
#include "lib/model/joints/universal.h"

namespace lanc {

using JointList = std::tuple<joints::Fixed, joints::Revolute, joints::Prismatic, joints::Helical, joints::Cylindrical,
                             joints::Universal, joints::Planar, joints::Spherical, joints::Free>;
constexpr int joint_kinds = std::tuple_size_v<JointList>;

/// Makes an array with make.operator()<Joint>() for every joint kind: a dispatch table, indexed by JointKind::index.
template <class Make>
constexpr auto for_each_joint_kind(Make make) {
  return []<class... Joint>(Make m, std::tuple<Joint...>*) { return std::array{m.template operator()<Joint>()...}; }(
             make, static_cast<JointList*>(nullptr));
}

/// One of the joint kinds, as a value.
struct JointKind {
  unsigned char index = 0;

  const JointTraits& traits() const {
    static constexpr auto table = for_each_joint_kind([]<class Joint>() { return &Joint::traits; });
    return *table[index];
  }
  friend bool operator==(JointKind, JointKind) = default;
};

inline std::optional<JointKind> find_joint_kind(std::string_view name) {
  for (unsigned char k = 0; k < joint_kinds; ++k)
    if (JointKind{k}.traits().name == name) return JointKind{k};
  return std::nullopt;
}

/// eq. 1, β̇ = H(β) η, for one joint.
template <class S>
void coordinate_rate(JointKind kind, const S* q, const S* v, S* qdot) {
  static constexpr auto table = for_each_joint_kind([]<class Joint>() {
    return +[](const S* x, const S* y, S* rate) {
      if constexpr (Joint::traits.quaternion >= 0)
        Joint::rate(x, y, rate);
      else
        for (int i = 0; i < Joint::traits.nq; ++i) rate[i] = y[i];
    };
  });
  table[kind.index](q, v, qdot);
}

}  // namespace lanc
