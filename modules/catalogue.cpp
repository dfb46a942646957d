#include "modules/catalogue.h"

#include <dlfcn.h>
#include <filesystem>
#include <memory>
#include <tuple>

#include "modules/all_modules.h"
#include "sim/api/module_export.h"

namespace trephine::modules {

namespace {

template <class... Modules>
sim::Catalogue catalogue_of(ModuleList<Modules...>) {
  static const std::tuple<Modules...> all;
  return std::apply(
      [](const auto&... modules) { return sim::Catalogue(std::vector<const sim::Module*>{&modules...}); },
      all);
}

/// Returns the program's only list of modules, in which sessions, scripts and panels find the types of
/// commands. add_module() may extend it only before other threads use it.
sim::Catalogue& all_modules() {
  static sim::Catalogue all = catalogue_of(AllModules());
  return all;
}

/// Returns the reason why the dynamic linker failed, without the folder of the library.
std::string linker_error(const std::filesystem::path& path) {
  const char* reported = dlerror();
  std::string text = reported ? reported : "unknown reason";
  if (const std::size_t at = text.find(path.string()); at != std::string::npos)
    text.replace(at, path.string().size(), path.filename().string());
  return text;
}

std::string built_against(const char* version, std::uint64_t layout) {
  return std::string("trephine ") + version + ", layout " + std::to_string(layout);
}

}  // namespace

const sim::Catalogue& catalogue() { return all_modules(); }

Status add_module(const sim::Module& module) {
  std::vector<const sim::Module*> modules = catalogue().modules();
  for (const sim::Module* known : modules)
    if (known->name() == module.name())
      return Error{.what = "two modules have the same name",
                   .found = std::string(module.name()),
                   .expected = "unique names",
                   .remedy = "load it once, or rename it"};
  modules.push_back(&module);
  sim::Catalogue extended(std::move(modules));
  if (Status error = extended.check()) return error;
  all_modules() = std::move(extended);
  return std::nullopt;
}

Result<const sim::Module*> load_module(const std::string& path) {
  std::error_code failed;
  const std::filesystem::path file = std::filesystem::absolute(path, failed);
  const std::string where = file.filename().string();
  if (failed || !std::filesystem::exists(file, failed))
    return Error{.what = "the module does not exist",
                 .where = where,
                 .expected = "a shared library (.so)",
                 .remedy = "check the spelling"};
  const auto close = [](void* library) { dlclose(library); };
  std::unique_ptr<void, decltype(close)> library(dlopen(file.c_str(), RTLD_NOW | RTLD_LOCAL), close);
  if (!library)
    return Error{.what = "the module cannot be loaded",
                 .where = where,
                 .found = linker_error(file),
                 .expected = "a shared library that was built against this version",
                 .remedy = "build the module against this version"};
  const auto get = reinterpret_cast<sim::ModuleFunction*>(dlsym(library.get(), sim::k_module_symbol));
  const sim::ModuleExport* exported = get ? get() : nullptr;
  if (exported == nullptr)
    return Error{.what = "the library is not a module",
                 .where = where,
                 .found = get ? "no module" : linker_error(file),
                 .expected = std::string("a function ") + sim::k_module_symbol + "() that returns a module",
                 .remedy = "export it as sim/api/module_export.h describes"};
  if (exported->layout != sim::k_module_layout || std::string_view(exported->version) != sim::k_version)
    return Error{.what = "the module was built against another version",
                 .where = where,
                 .found = built_against(exported->version, exported->layout),
                 .expected = built_against(sim::k_version, sim::k_module_layout),
                 .remedy = "build it against this version"};
  if (Status error = add_module(*exported->module)) {
    error->where = where;
    return *error;
  }
  library.release();  // its code is used until the program ends
  return exported->module;
}

}  // namespace trephine::modules
