// ModuleExport: a module in a shared library of its own, which programs load at run time
// (docs/how-to/add-a-module.md).
#pragma once

#include "sim/api/module.h"

namespace trephine::sim {

/// Version of trephine. A library is loaded by programs of the version that it was built against.
inline constexpr const char* k_version = "0.1.0";

/// Revision of the interface of modules. It increases with every change of sim/api, within a version, that
/// leaves the sizes below unchanged.
inline constexpr std::uint64_t k_module_revision = 2;
/// Layout of the interface of modules: its revision, and the sizes of the objects that both sides share.
inline constexpr std::uint64_t k_module_layout = [] {
  std::uint64_t layout = k_module_revision;
  for (const std::size_t size :
       {sizeof(Value), sizeof(Field), sizeof(Schema), sizeof(InstrumentType), sizeof(InstrumentInput),
        sizeof(JobType), sizeof(JobInput), sizeof(OperationState), sizeof(Event), sizeof(Command),
        sizeof(Overlay), sizeof(ModuleWork), sizeof(ModuleReaction), sizeof(haptics::TouchScene),
        sizeof(haptics::ServoRecord), sizeof(volume::Volume)})
    layout = 1'000'003 * layout + size;
  return layout;
}();

/// Returned by the one function that the library exports:
///
///     extern "C" const trephine::sim::ModuleExport* trephine_module() {
///       static const MyModule module;
///       static const trephine::sim::ModuleExport result(module);
///       return &result;
///     }
///
/// The first two members have the same offsets in all versions, so that any program can check them.
struct ModuleExport {
  explicit ModuleExport(const Module& exported) : module(&exported) {}
  std::uint64_t layout = k_module_layout;
  const char* version = k_version;
  const Module* module;  ///< valid until the program ends
};
/// Name of that function, and its type.
inline constexpr const char* k_module_symbol = "trephine_module";
using ModuleFunction = const ModuleExport*();

}  // namespace trephine::sim
