#pragma once

#include <pybind11/pybind11.h>

namespace sheaf {

/// Adds the class Image.
void add_images(pybind11::module_& m);

}  // namespace sheaf
