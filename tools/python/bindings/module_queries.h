// Queries of compiled scenes for the module: rays and BSDFs.
#pragma once

#include <pybind11/pybind11.h>

namespace sheaf {

/// Adds the functions trace, evaluate_bsdf and sample_bsdf.
void add_queries(pybind11::module_& m);

}  // namespace sheaf
