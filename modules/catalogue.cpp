#include "modules/catalogue.h"

#include <tuple>

#include "modules/all_modules.h"

namespace trephine::modules {

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

}  // namespace trephine::modules
