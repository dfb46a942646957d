#include "apps/imaging/section_panel.h"

#include <algorithm>

#include "apps/workbench/text.h"

namespace trephine::imaging {

using volume::ImagePlane;
using volume::Result;
using workbench::format_text;

using Kind = SectionObject::Kind;

Panel::Colour colour_of(Kind kind) noexcept {
  switch (kind) {
    case Kind::bone:
      return {150, 150, 150};
    case Kind::piece:
      return {196, 170, 120};
    case Kind::structure:
      return {90, 130, 210};
    case Kind::model:
      break;
  }
  return {245, 245, 245};
}

Result<std::vector<SectionObject>> section_objects(const Subject& subject, const ImagePlane& plane) {
  std::vector<SectionObject> objects;
  const auto add = [&](Kind kind, const volume::Shape& shape) {
    const volume::Field field(*subject.scan, shape);
    objects.push_back({kind, shape.name, cross_section::cut_volume(plane, field, subject.version.get())});
  };
  add(Kind::bone, *subject.bone);
  for (const volume::Shape& structure : subject.structures) add(Kind::structure, structure);
  for (const Thing& thing : subject.things) {
    auto cut = cut_of(plane, thing);
    if (!cut) return cut.error();
    objects.push_back({thing.is_piece ? Kind::piece : Kind::model, thing.name, std::move(cut).value()});
  }
  return objects;
}

Panel section_panel(const std::vector<SectionObject>& objects, const ImagePlane& plane, SectionAreas& areas) {
  constexpr Panel::Colour k_empty{16, 16, 18};
  Panel panel;
  panel.columns = plane.columns, panel.rows = plane.rows, panel.mm_a_pixel = plane.pixel;
  panel.pixels.reserve(static_cast<std::size_t>(plane.columns) * static_cast<std::size_t>(plane.rows));
  double outside = 0, of_models = 0;
  for (int row = plane.rows - 1; row >= 0; --row)
    for (int column = 0; column < plane.columns; ++column) {
      const std::size_t at = static_cast<std::size_t>(column) +
                             static_cast<std::size_t>(plane.columns) * static_cast<std::size_t>(row);
      Panel::Colour colour = k_empty;
      bool is_bone = false, is_model = false;
      for (const SectionObject& object : objects) {
        if (!object.cut.inside[at]) continue;
        if (object.kind == Kind::model)
          is_model = true;
        else
          colour = colour_of(object.kind), is_bone |= object.kind != Kind::structure;
      }
      if (is_model) colour = is_bone ? colour_of(Kind::model) : k_outside_bone;
      of_models += is_model, outside += is_model && !is_bone;
      panel.pixels.push_back(colour);
    }
  areas = {of_models * plane.pixel * plane.pixel, outside * plane.pixel * plane.pixel};
  set_letters(panel, plane.right, plane.up);
  panel.title = format_text("%s: %.0f mm\u00b2", objects[0].name.c_str(), objects[0].cut.area);
  panel.foot =
      format_text("at %.1f, %.1f, %.1f", plane.middle_world.x, plane.middle_world.y, plane.middle_world.z);
  for (const SectionObject& object : objects)
    for (const cross_section::Loop& loop : object.cut.outline)
      panel.lines.push_back({loop, {20, 20, 20}, true, ""});
  if (std::any_of(objects.begin(), objects.end(), [](const SectionObject& object) {
        return object.kind == Kind::structure && object.cut.area > 0;
      }))
    panel.lines.push_back({{}, colour_of(Kind::structure), true, "must not be cut"});
  if (outside > 0) panel.lines.push_back({{}, k_outside_bone, true, "outside bone"});
  return panel;
}

}  // namespace trephine::imaging
