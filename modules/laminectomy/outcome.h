// Outcome of a laminectomy: room in the canal, remains of the vertebra's back.
#pragma once

#include "modules/laminectomy/vertebra.h"
#include "sim/value.h"

namespace trephine::laminectomy {

/// A part of the vertebra's arch.
struct Part {
  double size = 0;           ///< mm3, before
  double removed = 0;        ///< mm3
  glm::dvec3 at_world{0.0};  ///< the middle of what was removed; of the part where nothing was
  double share_removed() const noexcept { return size > 0 ? removed / size : 0; }
};

/// The isthmus between a vertebra's upper and lower facet, as seen from the back.
struct Pars {
  double before = 0, after = 0;  ///< mm, from its outer edge to the middle, or to where it was cut
  glm::dvec3 at_world{0.0};      ///< where it is narrowest now
};

struct Outcome {
  VertebraFrame frame;
  double half_width = 0;                     ///< mm, of the canal between the pedicles
  double pedicle_low = 0, pedicle_high = 0;  ///< mm along `up`
  double roof_back = 0;                      ///< mm behind the middle, where the spinous process begins
  std::vector<CanalSection> sections;  ///< a millimetre apart, from below to above, over the whole vertebra

  bool is_at_border = false;          ///< the scan ends within the vertebra
  int roof_first = 0, roof_last = 0;  ///< of the sections: those that the lamina closed behind
  int narrowest = 0;                  ///< of those: where the canal was narrowest
  int widest_opened = -1;             ///< where the opening is widest; -1: the roof is closed everywhere
  double opened_length = 0;           ///< mm along the canal whose roof was opened

  Part lamina, spinous_process;
  std::array<Part, 2> upper_facet, lower_facet;  ///< left, right
  std::array<Pars, 2> pars;

  glm::dvec3 place_of(int section) const {
    return frame.world({0, 0, sections[static_cast<std::size_t>(section)].z});
  }
};

/// Judges the vertebra with this label; -1 and a place in its canal: the bone within 18 mm above and below
/// it. `version` is frozen. False, and why, when no such vertebra is found.
bool judge(const volume::Field& bone, int label, const glm::dvec3* canal_world,
           const volume::Version& version, Outcome& outcome, Trouble& trouble);

/// The slice of the scan (along its third axis) that shows a place.
int slice_of(const volume::Volume& scan, const glm::dvec3& world) noexcept;

}  // namespace trephine::laminectomy
