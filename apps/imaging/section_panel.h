// Section panels: bone, detached bodies, forbidden structures and models in a plane, and the area of models
// outside bone.
#pragma once

#include "apps/imaging/panel.h"
#include "apps/imaging/subject.h"

namespace trephine::imaging {

/// One object of the section.
struct SectionObject {
  /// `model`: metal, which should be in bone. `soft`: a model of soft tissue.
  enum class Kind { bone, piece, structure, model, soft } kind;
  std::string name;
  Panel::Colour colour;
  cross_section::Cut cut;
  /// Pixels of the head and the tip of a screw, which need not be in bone; empty for other objects.
  std::vector<std::uint8_t> uncounted = {};
  std::vector<std::uint8_t> by_labels = {};  ///< bone only: pixels added by labels that name a bone
  std::vector<std::uint8_t> uncut = {};      ///< bone only, if there are models: its pixels before any cut
};
inline constexpr Panel::Colour k_outside_bone{225, 45, 40};

/// Returns the cross-sections of a subject's objects with a plane; the first is bone. Requires a subject with
/// `bone`. Error: the surface of an object cannot be cut.
Result<std::vector<SectionObject>> section_objects(const Subject& subject, const volume::ImagePlane& plane);

/// A labelled structure that is neither bone nor forbidden, such as a tumour.
struct SectionTissue {
  std::string name;  ///< words
  Panel::Colour colour;
  std::vector<std::uint8_t> inside;  ///< one byte per pixel, as in Cut
};
/// Returns the labelled structures in a plane that section_objects() does not return. Removed voxels are left
/// out. Each structure has the dimmed colour of its label. Each pixel belongs to the voxel that contains its
/// centre.
std::vector<SectionTissue> section_tissues(const Subject& subject, const volume::ImagePlane& plane);

/// Drawn areas, mm2: of models, and of models outside bone. Heads and tips of screws, and places where bone
/// was cut, do not count as outside.
struct SectionAreas {
  double models = 0, outside = 0;
};
/// Draws a section and its legend. Objects cover tissues.
Panel section_panel(const std::vector<SectionObject>& objects, const std::vector<SectionTissue>& tissues,
                    const volume::ImagePlane& plane, SectionAreas& areas);

}  // namespace trephine::imaging
