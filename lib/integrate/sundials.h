// SUNDIALS' objects, owned; its types appear here and in the files that include this.
// Private to lib/integrate.
#pragma once

#include <nvector/nvector_serial.h>
#include <sundials/sundials_context.h>
#include <sunlinsol/sunlinsol_dense.h>
#include <sunmatrix/sunmatrix_dense.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <new>
#include <string>
#include <type_traits>

namespace lanc::sundials {

struct DeleteContext {
  void operator()(SUNContext context) const { SUNContext_Free(&context); }
};
struct DeleteVector {
  void operator()(N_Vector v) const { N_VDestroy(v); }
};
struct DeleteMatrix {
  void operator()(SUNMatrix m) const { SUNMatDestroy(m); }
};
struct DeleteLinearSolver {
  void operator()(SUNLinearSolver s) const { SUNLinSolFree(s); }
};
using Context = std::unique_ptr<std::remove_pointer_t<SUNContext>, DeleteContext>;
using Vector = std::unique_ptr<std::remove_pointer_t<N_Vector>, DeleteVector>;
using Matrix = std::unique_ptr<std::remove_pointer_t<SUNMatrix>, DeleteMatrix>;
using LinearSolver = std::unique_ptr<std::remove_pointer_t<SUNLinearSolver>, DeleteLinearSolver>;

template <class T>
T needed(T pointer) {
  if (!pointer) throw std::bad_alloc();
  return pointer;
}

inline Context make_context() {
  SUNContext context = nullptr;
  SUNContext_Create(nullptr, &context);
  return Context(needed(context));
}
inline Vector make_vector(const Context& context, int size) {
  return Vector(needed(N_VNew_Serial(size, context.get())));
}
inline double* data(N_Vector v) { return N_VGetArrayPointer(v); }

/// The dense matrix and linear solver of Newton's method.
struct Newton {
  Matrix matrix;
  LinearSolver solver;
  Newton(const Context& context, const Vector& y, int size)
      : matrix(needed(SUNDenseMatrix(size, size, context.get()))),
        solver(needed(SUNLinSol_Dense(y.get(), matrix.get(), context.get()))) {}
};

/// Keeps the last complaint instead of writing it on stderr; for the ...SetErrHandlerFn functions, `user` the string.
inline void keep_message(int /*code*/, const char* /*module*/, const char* /*function*/, char* message, void* user) {
  *static_cast<std::string*>(user) = message;
}

/// SUNDIALS' norm is a mean over all numbers of y; a single one in a large mechanism must count as much as in a small
/// one.
inline double of_single_numbers(double tolerance, int size) {
  return std::max(tolerance / std::sqrt(static_cast<double>(size)), 1e-15);
}

constexpr long most_steps = 2000000000;  // nobody but the user ends a run

}  // namespace lanc::sundials
