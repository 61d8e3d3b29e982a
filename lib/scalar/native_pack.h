// A pack as wide as one register of the processor that is compiled for.
// Private to lib and formulations: it differs between objects compiled for different processors.
#pragma once

#include "lib/scalar/pack.h"

namespace lanc {

#if defined(__AVX512F__)
using NativePack = Pack<double, 8>;
#elif defined(__AVX__)
using NativePack = Pack<double, 4>;
#else
using NativePack = Pack<double, 2>;
#endif

}  // namespace lanc
