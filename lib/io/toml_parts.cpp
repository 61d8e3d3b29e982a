#include "lib/io/toml_parts.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "lib/io/text.h"

namespace lanc {

std::string label(std::string_view what, const toml::table& table) {
  const auto* name = table.get_as<std::string>("name");
  return name ? fmt::format("{} {}", what, in_quotes(name->get())) : fmt::format("a {}", what);
}

std::string body_or_ground(const TomlTable& table, std::string_view key) {
  if (!table.find(key)) return {};
  std::string name = table.name(key);
  return name == "ground" ? std::string() : name;
}

void unknown_type(const TomlTable& table, std::string_view what, const std::string& type,
                  std::span<const std::string_view> names) {
  const std::string mend = did_you_mean(type, names);
  table.fail(*table.find("type"),
             fmt::format("unknown {} type {}{}", what, in_quotes(type),
                         mend.empty() ? fmt::format("; one of {}", fmt::join(names, ", ")) : mend));
}

Eigen::Matrix3d read_rotation(const TomlTable& joint, const std::string& suffix) {
  const toml::node *quaternion = joint.find("quaternion" + suffix), *rpy = joint.find("rpy" + suffix);
  if (quaternion && rpy) joint.fail(*rpy, "quaternion and rpy both give the orientation; keep one of them");
  if (rpy) {
    const Eigen::Vector3d a = joint.vector("rpy" + suffix);
    using Eigen::AngleAxisd, Eigen::Vector3d;
    return (AngleAxisd(a.z(), Vector3d::UnitZ()) * AngleAxisd(a.y(), Vector3d::UnitY()) *
            AngleAxisd(a.x(), Vector3d::UnitX()))
        .toRotationMatrix();
  }
  if (!quaternion) return Eigen::Matrix3d::Identity();
  const std::vector<double> e = joint.numbers("quaternion" + suffix);
  if (e.size() != 4) joint.fail(*quaternion, fmt::format("quaternion needs 4 numbers [w, x, y, z], not {}", e.size()));
  const Eigen::Quaterniond q(e[0], e[1], e[2], e[3]);
  if (!(std::abs(q.norm() - 1) <= 1e-6))
    joint.fail(*quaternion, fmt::format("the quaternion has length {:.9g}, not 1; normalise it", q.norm()));
  return q.normalized().toRotationMatrix();
}

Placement read_placement(const TomlTable& table, const std::string& suffix) {
  return {read_rotation(table, suffix), table.vector("position" + suffix)};
}

MotionSpec read_motion(const TomlTable& joint) {
  static constexpr std::string_view types[] = {"constant-speed", "polynomial", "sine", "spline", "expression"};
  static constexpr std::string_view speed_keys[] = {"type", "start", "rate"},
                                    polynomial_keys[] = {"type", "coefficients"},
                                    sine_keys[] = {"type", "offset", "amplitude", "frequency", "phase"},
                                    spline_keys[] = {"type", "times", "values"}, formula_keys[] = {"type", "formula"};
  static constexpr std::span<const std::string_view> keys[] = {speed_keys, polynomial_keys, sine_keys, spline_keys,
                                                               formula_keys};
  const toml::table& source = joint.table("motion");
  const std::string who = joint.who() + ": motion";
  const auto* word = source.get("type");
  const auto* type = word ? word->as_string() : nullptr;
  const auto found = std::find(std::begin(types), std::end(types), type ? std::string_view(type->get()) : "");
  if (found == std::end(types))
    joint.fail(word ? *word : static_cast<const toml::node&>(source),
               fmt::format("motion needs a type, one of \"{}\"{}", fmt::join(types, "\", \""),
                           type ? did_you_mean(type->get(), types) : ""));
  const auto index = static_cast<std::size_t>(found - std::begin(types));
  const TomlTable motion(source, joint.file(), who, keys[index]);
  const auto required = [&](std::string_view key) {
    if (!motion.find(key)) motion.fail(fmt::format("{} is missing", key));
    return key;
  };
  switch (index) {
    case 0: return ConstantSpeed{motion.number("start"), motion.number(required("rate"))};
    case 1: return Polynomial{motion.numbers(required("coefficients"))};
    case 2:
      return Sine{motion.number("offset"), motion.number(required("amplitude")), motion.number(required("frequency")),
                  motion.number("phase")};
    case 3: return SplineTable{motion.numbers(required("times")), motion.numbers(required("values"))};
    default: return Formula{motion.text(required("formula"))};
  }
}

}  // namespace lanc
