// Exports the eraser from a shared library of its own.
#include "modules/eraser/eraser.h"
#include "sim/api/module_export.h"

extern "C" const trephine::sim::ModuleExport* trephine_module() {
  static const trephine::eraser::EraserModule module;
  static const trephine::sim::ModuleExport result(module);
  return &result;
}
