// From a model argument of the command line to a mechanism: a file (TOML, URDF) or a generator.
#pragma once

#include <string>

#include "lib/model/model.h"

namespace lanc {

/// A model together with the state it comes with.
struct Mechanism {
  Model model;
  State<double> state;
};

/// `argument` is a file (*.toml, *.urdf, or anything with a path separator or an extension) or a generator with options
/// after colons, such as "chain:10:joint=spherical" (lib/io/generators.h). Throws InputError with place and mend.
Mechanism load_mechanism(const std::string& argument);

/// Native format (data/models/README.md). Throws InputError with file, line and column.
Mechanism load_toml(const std::string& path);

/// URDF by urdfdom. Throws InputError; `mimic` is an error that says so.
Mechanism load_urdf(const std::string& path);

}  // namespace lanc
