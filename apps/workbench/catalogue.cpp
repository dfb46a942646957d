#include "apps/workbench/catalogue.h"

#include <tuple>

#include "apps/workbench/modules.h"

namespace trephine::workbench {

namespace {

template <class... Modules>
sim::Catalogue catalogue_of(ModuleList<Modules...>) {
  static const std::tuple<Modules...> all;
  return std::apply(
      [](const auto&... modules) { return sim::Catalogue(std::vector<const sim::Module*>{&modules...}); },
      all);
}

}  // namespace

const sim::Catalogue& catalogue() {
  static const sim::Catalogue all = catalogue_of(AllModules());
  return all;
}

}  // namespace trephine::workbench
