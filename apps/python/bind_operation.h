// Operations in Python.
#pragma once

#include "apps/python/arrays.h"

namespace trephine::python {

void bind_operation(py::module_& module);

}  // namespace trephine::python
