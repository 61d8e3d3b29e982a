// From a model argument of the command line to a mechanism: a file (TOML, URDF) or a generator.
#pragma once

#include <string>
#include <string_view>

#include "lib/io/joint_graph.h"
#include "lib/model/model.h"

namespace lanc {

/// A model together with the state it comes with.
struct Mechanism {
  Model model;
  State<double> state;
  GraphRecord graph = {};  // which loops were cut where, when it was given as a graph of joints
};

/// `argument` is a file (*.toml, *.urdf, or anything with a path separator or an extension) or a generator with options
/// after colons, such as "chain:10:joint=spherical" (lib/io/generators.h). Throws InputError with place and mend.
Mechanism load_mechanism(const std::string& argument);

/// Native format (data/models/README.md). Throws InputError with file, line and column. Tested by tests/io.
Mechanism load_toml(const std::string& path);
/// The same from memory; `name` stands for the file in messages.
Mechanism load_toml_text(std::string_view text, const std::string& name);

/// URDF by urdfdom (data/models/README.md says how it is read). Throws InputError with file and line; `mimic`
/// becomes a coupler. Tested by tests/io.
Mechanism load_urdf(const std::string& path);
/// The same from memory; `name` stands for the file in messages.
Mechanism load_urdf_text(std::string_view text, const std::string& name);

}  // namespace lanc
