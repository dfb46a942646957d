// Sections: what of a plane is bone, what came off, what must not be cut, and what of models lies outside
// bone.
#pragma once

#include "apps/imaging/panel.h"
#include "apps/imaging/subject.h"

namespace trephine::imaging {

/// One object of the section.
struct SectionObject {
  enum class Kind { bone, piece, structure, model } kind;
  std::string name;
  Panel::Colour colour;
  cross_section::Cut cut;
  /// The head and the tip of a screw: they need not be in bone.
  std::vector<std::uint8_t> uncounted = {};
  std::vector<std::uint8_t> by_labels = {};  ///< of bone: what labels that name a bone add to it
};
inline constexpr Panel::Colour k_outside_bone{225, 45, 40};

/// The subject says what is bone. Bone comes first. Error names a model that cannot be cut.
volume::Result<std::vector<SectionObject>> section_objects(const Subject& subject,
                                                           const volume::ImagePlane& plane);

/// Areas of what is drawn, mm2: of models, and of these outside bone.
struct SectionAreas {
  double models = 0, outside = 0;
};
Panel section_panel(const std::vector<SectionObject>& objects, const volume::ImagePlane& plane,
                    SectionAreas& areas);

}  // namespace trephine::imaging
