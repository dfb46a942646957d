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
};
inline constexpr Panel::Colour k_outside_bone{225, 45, 40};

/// Cuts the objects of a subject with a plane. The subject defines bone, which is the first object. Error: a
/// model cannot be cut.
Result<std::vector<SectionObject>> section_objects(const Subject& subject, const volume::ImagePlane& plane);

/// Drawn areas, mm2: of models, and of models outside bone.
struct SectionAreas {
  double models = 0, outside = 0;
};
Panel section_panel(const std::vector<SectionObject>& objects, const volume::ImagePlane& plane,
                    SectionAreas& areas);

}  // namespace trephine::imaging
