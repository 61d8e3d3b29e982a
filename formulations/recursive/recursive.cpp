#include "formulations/recursive/recursive.h"

#include "lib/formulation/pack_kernel.h"

namespace lanc {

template class Recursive<double>;
template class Recursive<long double>;
template class Recursive<Count>;

namespace {
const Registration registration(
    {.name = "recursive",
     .idea = "eq. 18: eliminate body by body from the leaves to the root, then substitute back",
     .source = "lecture, eq. 18; Featherstone 1983; Brandl, Johanni & Otter 1986",
     .recursive = true,
     .create_double = create<Recursive<double>, double>,
     .create_long_double = create<Recursive<long double>, long double>,
     .create_count = create<Recursive<Count>, Count>,
     .create_kernel = create_kernel<Recursion<NativePack>, NativePack>});
}  // namespace

}  // namespace lanc
