// A library that exports a module of another version. Programs refuse to load it.
#include "sim/api/module_export.h"

namespace {

class OldModule final : public trephine::sim::Module {
 public:
  std::string_view name() const noexcept override { return "old"; }
};

}  // namespace

extern "C" const trephine::sim::ModuleExport* trephine_module() {
  static const OldModule module;
  static const trephine::sim::ModuleExport result = [] {
    trephine::sim::ModuleExport old(module);
    old.version = "0.0.9";
    return old;
  }();
  return &result;
}
