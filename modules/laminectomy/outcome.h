// Outcome of a laminectomy: room in the canal, and remaining parts of the vertebra's arch.
#pragma once

#include <array>

#include "sim/api/value.h"
#include "volume/anatomy/vertebra.h"

namespace trephine::laminectomy {

/// Part of the vertebra's arch.
struct Part {
  double size = 0;           ///< mm3, before the operation
  double removed = 0;        ///< mm3
  glm::dvec3 at_world{0.0};  ///< mm: centre of the removed bone, or of the part if no bone was removed
  double share_removed() const noexcept { return size > 0 ? removed / size : 0; }
};

/// Pars interarticularis: the isthmus between a vertebra's upper and lower facet, viewed from the back.
struct Pars {
  double before = 0, after = 0;  ///< width, mm, from its outer edge to the midline or the cut
  glm::dvec3 at_world{0.0};      ///< mm: narrowest point after the operation
};

/// Result of judge().
struct Outcome {
  volume::VertebraFrame frame;
  double half_width = 0;                       ///< mm, half of the canal's width between the pedicles
  double pedicle_low = 0, pedicle_high = 0;    ///< mm along `up` of the frame
  double roof_back = 0;                        ///< mm backward from the canal's centre to the spinous process
  std::vector<volume::CanalSection> sections;  ///< 1 mm apart, upward, over the whole vertebra

  bool is_at_border = false;          ///< the scan ends within the vertebra
  int roof_first = 0, roof_last = 0;  ///< first and last section that the lamina closed before the operation
  int narrowest = 0;                  ///< of these, the section with the narrowest canal before the operation
  int widest_opened = -1;             ///< section with the widest opening; -1: the roof is closed everywhere
  double opened_length = 0;           ///< mm along the canal with an opened roof

  Part lamina, spinous_process;
  std::array<Part, 2> upper_facet, lower_facet;  ///< left, right
  std::array<Pars, 2> pars;

  /// Returns the centre of the canal in a section, mm, world.
  glm::dvec3 position_of(int section) const {
    return frame.world({0, 0, sections[static_cast<std::size_t>(section)].z});
  }
};

/// Judges the vertebra with this label. If `label` is -1, judges the bone within 18 mm above and below
/// `canal_world`, a position in the canal (mm). Requires a frozen `version`.
Result<Outcome, LocatedError> judge(const volume::Field& bone, int label, const glm::dvec3* canal_world,
                                    const volume::Version& version);

/// Returns the index of the scan's slice (along its third axis) at a position, clamped to the scan.
int slice_of(const volume::Volume& scan, const glm::dvec3& world) noexcept;

}  // namespace trephine::laminectomy
