// What a run says in the end: times side by side, and the bounds with what was measured beside them.
#pragma once

#include <cstdio>
#include <vector>

#include "lib/report/report.h"

namespace lanc::peers {

/// Per model and task: median times of all sides, ratio of our fastest to each peer, difference or error.
void print_times(std::FILE* out, const std::vector<Row>& rows);
/// Every bound whose models were run.
void print_bounds(std::FILE* out, const std::vector<Row>& rows);
/// Compilers, flags and versions of both sides, and the processor.
void print_builds(std::FILE* out);

}  // namespace lanc::peers
