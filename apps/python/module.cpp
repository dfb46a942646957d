// Entry point of the Python module.
#include "apps/python/bind_operation.h"
#include "apps/python/bind_scan.h"

PYBIND11_MODULE(_core, module) {
  using namespace trephine::python;
  module.doc() = "Volumetric surgical simulation: touch, drill and image scans.";
  module.attr("__version__") = TREPHINE_VERSION;
  register_error(module);
  bind_scan(module);
  bind_operation(module);
}
