// What the readers of the native model format share. Private to lib/io (exposes toml++).
#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "lib/io/joint_graph.h"
#include "lib/io/toml_reader.h"
#include "lib/model/spec.h"

namespace lanc {

/// "body 'upper'" for messages, or "a body" as long as it has no usable name.
std::string label(std::string_view what, const toml::table& table);

/// The name of a body, or nothing for ground: the key is absent or says "ground".
std::string body_or_ground(const TomlTable& table, std::string_view key);

/// Throws the error about the key `type`.
[[noreturn]] void unknown_type(const TomlTable& table, std::string_view what, const std::string& type,
                               std::span<const std::string_view> names);

/// From the keys quaternion or rpy, followed by `suffix`.
Eigen::Matrix3d read_rotation(const TomlTable& table, const std::string& suffix = {});

/// From the keys position, and quaternion or rpy, followed by `suffix`.
Placement read_placement(const TomlTable& table, const std::string& suffix = {});

/// From the key motion, which must be there.
MotionSpec read_motion(const TomlTable& table);

/// [[joint]] of a tree, and of a graph (which a joint with body_a or body_b is of).
bool is_of_graph(const toml::table& joint);
JointSpec read_joint(const toml::table& source, const std::string& file);
GraphJointSpec read_graph_joint(const toml::table& source, const std::string& file);

/// [[closure]] and [[coupler]]; which bodies and joints there are is known to the model's builder, what a joint's
/// coordinates are called to `joints`.
ClosureSpec read_closure(const toml::table& source, const std::string& file);
CouplerSpec read_coupler(const toml::table& source, const std::string& file, const std::vector<JointSpec>& joints);

}  // namespace lanc
