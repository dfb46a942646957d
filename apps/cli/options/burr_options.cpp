#include "apps/cli/options/burr_options.h"

#include "apps/cli/options/field_option.h"

namespace trephine::cli {

Option add_burr(Options& options, drilling::Burr& burr) {
  const auto add = [&](std::string_view field, const char* called) {
    return add_field(options, drilling::Burr::schema(), &burr, field, called);
  };
  const Option diameter = add("diameter", "--burr-diameter").type("MM");
  add("shape", "--burr-shape");
  add("length", "--burr-length").type("MM");
  add("grade", "--grade");
  add("rpm", "--rpm").shows_default();
  add("dry", "--dry");
  add("removal_rate", "--removal-rate").shows_default();
  add("feed_limit", "--feed-limit").shows_default();
  options
      .add("--round", burr.is_round,
           "Touch the bone with the whole burr (up to 12 mm) instead of its lowest point. The hand is at the "
           "centre of a ball, or the tip of other burrs. The touching shape is smaller than the cutting "
           "shape by up to a voxel, or by a twelfth of the radius if that is more")
      .means("tool radius");
  add("shaft", "--shaft").type("MM");
  return diameter;
}

}  // namespace trephine::cli
