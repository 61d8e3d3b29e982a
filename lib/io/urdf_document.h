// The part of a URDF file that bears on dynamics, checked element by element. Private to lib/io.
//
// urdfdom drops a link's inertia without a word when one of its numbers cannot be read, takes the first of repeated
// elements, and knows no line numbers. So the XML is checked here first (TinyXML-2), and urdfdom gets a clean copy
// without visuals, collision shapes and vendors' extensions.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "lib/model/error.h"

namespace lanc {

struct UrdfDocument {
  struct LinkItem {
    std::string name;
    Place place;
    bool has_inertia = false;
    bool allow_nonphysical_inertia = false;  // our attribute of <inertial>; other programs ignore it
  };
  struct JointItem {
    std::string name, parent, child;
    Place place;
    Place mimic_place = {};  // where it has a <mimic>
  };
  std::string name;
  std::vector<LinkItem> links;  // in the order of the file
  std::vector<JointItem> joints;
  int root = -1;      // index of the link no joint carries
  std::string clean;  // for urdfdom
};

/// Throws InputError with file and line for broken XML and for every element or number that urdfdom would misread.
UrdfDocument read_urdf_document(std::string_view text, const std::string& file);

}  // namespace lanc
