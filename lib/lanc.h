// Everything a program of one's own needs: models, coefficients of eq. 14, formulations, what they cost.
#pragma once

#include "lib/derivatives/forward_derivatives.h"
#include "lib/formulation/batch.h"
#include "lib/formulation/formulation.h"
#include "lib/io/generators.h"
#include "lib/io/joint_graph.h"
#include "lib/io/mechanism.h"
#include "lib/model/error.h"
#include "lib/model/model.h"
#include "lib/report/phases.h"
#include "lib/system/eq14_matrix.h"
#include "lib/system/equations.h"
#include "lib/system/evaluator.h"
