// How many random cases a test takes.
#pragma once

#include <algorithm>

#include "lib/report/sidecar.h"

namespace lanc::test {

/// `all` of them; a tenth under sanitizers, where each takes ten times as long.
inline int cases(int all) { return build_info().sanitized ? std::max(1, all / 10) : all; }

}  // namespace lanc::test
