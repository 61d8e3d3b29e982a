#include "lib/integrate/sundials_integrators.h"

#include "lib/integrate/arkode.h"
#include "lib/integrate/cvode.h"
#include "lib/integrate/ida.h"

namespace lanc {

std::vector<IntegratorInfo> sundials_integrators() {
  return {{.name = "erk5",
           .idea = "explicit Runge-Kutta of order 5(4), steps by error estimate",
           .source = "Dormand & Prince 1980; ARKODE",
           .create = &create_erk5},
          {.name = "erk6",
           .idea = "explicit Runge-Kutta of order 6(5), steps by error estimate",
           .source = "Verner 1978; ARKODE",
           .create = &create_erk6},
          {.name = "erk8",
           .idea = "explicit Runge-Kutta of order 8(7), steps by error estimate",
           .source = "Fehlberg 1968; ARKODE",
           .create = &create_erk8},
          {.name = "dirk",
           .idea = "diagonally implicit Runge-Kutta of order 5(4), L-stable, steps by error estimate",
           .source = "Kennedy & Carpenter 2003; ARKODE",
           .implicit = true,
           .create = &create_dirk},
          {.name = "adams",
           .idea = "Adams-Moulton, order 1 to 12, functional iteration",
           .source = "Hindmarsh et al. 2005; CVODE",
           .memory = true,
           .create = &create_adams},
          {.name = "bdf",
           .idea = "backward differentiation, order 1 to 5",
           .source = "Hindmarsh et al. 2005; CVODE",
           .implicit = true,
           .memory = true,
           .create = &create_bdf},
          {.name = "ida",
           .idea = "BDF for the stabilised index-2 equations with all closure conditions",
           .source = "Gear, Gupta & Leimkuhler 1985, J. Comput. Appl. Math. 12-13, 77-90; IDA",
           .implicit = true,
           .memory = true,
           .holds_closures = true,
           .create = &create_ida}};
}

}  // namespace lanc
