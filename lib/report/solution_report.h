// Solutions of eq. 14 told to programs (JSON) and to people (tables).
#pragma once

#include <nlohmann/json.hpp>

#include "lib/report/table.h"
#include "lib/system/system.h"

namespace lanc {

using Json = nlohmann::ordered_json;

/// null where the number is not finite.
Json json_number(double value);
/// n × 6, angular part first.
Json json_rows(const std::vector<Motion<double>>& accelerations);
Json json_rows(const std::vector<Wrench<double>>& wrenches);
/// Order of velocities, bodies, drives and closure rows.
Json json_names(const Model& model);
/// The document with a line break; bytes that are not UTF-8 (names in files) become U+FFFD.
std::string json_text(const Json& document);

/// Unit of a force that does work on a coordinate of this unit, and of its second derivative.
std::string force_unit(std::string_view coordinate_unit);
std::string acceleration_unit(std::string_view velocity_unit);

/// "Body accelerations", "Joint wrenches" and "Drive forces", each with its heading.
std::string acceleration_table(const Model& model, const std::vector<Motion<double>>& accelerations);
std::string wrench_table(const Model& model, const std::vector<Wrench<double>>& wrenches);
std::string drive_table(const Model& model, const std::vector<double>& forces);

}  // namespace lanc
