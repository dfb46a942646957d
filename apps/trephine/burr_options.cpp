#include "apps/trephine/burr_options.h"

#include "apps/trephine/field_option.h"

namespace trephine::app {

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
           "The bone is touched with all of the burr, not with its lowest point; the hand holds a ball's "
           "middle, "
           "and the tip of other burrs; what touches is a voxel or a twelfth smaller than what cuts, so that "
           "it "
           "has room in its own hole; to 12 mm")
      .means("tool radius");
  add("shaft", "--shaft").type("MM");
  return diameter;
}

}  // namespace trephine::app
