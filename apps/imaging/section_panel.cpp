#include "apps/imaging/section_panel.h"

#include <algorithm>
#include <array>
#include <glm/geometric.hpp>
#include <iterator>

#include "apps/workbench/text.h"
#include "data-tools/formats/write_volume.h"
#include "volume/scan/bone_labels.h"

namespace trephine::imaging {

using volume::ImagePlane;
using workbench::format_text;
using workbench::words_of;

using Kind = SectionObject::Kind;

namespace {

/// Colours of objects. Successive pieces get different colours, and so do successive models.
constexpr Panel::Colour k_bone{150, 150, 150}, k_cancellous{122, 110, 98};
constexpr Panel::Colour k_pieces[] = {{196, 170, 120}, {150, 178, 128}, {184, 146, 168}};
constexpr Panel::Colour k_models[] = {{245, 245, 245}, {188, 222, 248}, {250, 232, 178}};

Panel::Colour colour_of(const volume::Volume& scan, const volume::Shape& structure, std::size_t index) {
  // A label has the same colour as in all other views. Other structures get one colour each.
  const bool is_label = structure.label > 0;
  const glm::dvec3 share = is_label ? data_tools::label_colour(structure.label, scan.label_colours)
                                    : data_tools::label_colour(static_cast<int>(index) + 1, {});
  return {static_cast<std::uint8_t>(255 * share.x), static_cast<std::uint8_t>(255 * share.y),
          static_cast<std::uint8_t>(255 * share.z)};
}

/// Returns a byte per pixel: 1 beyond either end of a screw's shaft, thus in its head and its tip.
std::vector<std::uint8_t> head_and_tip(const ImagePlane& plane, const data_tools::ScrewPosition& screw) {
  std::vector<std::uint8_t> beyond(static_cast<std::size_t>(plane.columns) *
                                   static_cast<std::size_t>(plane.rows));
  const glm::dvec3 axis = screw.tip_world - screw.entry_world, along = glm::normalize(axis);
  const double length = glm::length(axis) - data_tools::k_screw_tip * screw.diameter;
  for (int row = 0; row < plane.rows; ++row)
    for (int column = 0; column < plane.columns; ++column) {
      const double at = glm::dot(plane.world(column, row) - screw.entry_world, along);
      beyond[static_cast<std::size_t>(column) +
             static_cast<std::size_t>(plane.columns) * static_cast<std::size_t>(row)] = at < 0 || at > length;
    }
  return beyond;
}

}  // namespace

Result<std::vector<SectionObject>> section_objects(const Subject& subject, const ImagePlane& plane) {
  std::vector<SectionObject> objects;
  const auto add = [&](Kind kind, const volume::Shape& shape, const Panel::Colour& colour) {
    const volume::Field field(*subject.scan, shape);
    objects.push_back(
        {kind, shape.name, colour, cross_section::cut_volume(plane, field, subject.version.get())});
  };
  add(Kind::bone, *subject.bone, k_bone);
  objects[0].by_labels = cross_section::bone_by_labels(plane, *subject.scan, subject.version.get());
  for (std::size_t i = 0; i < subject.structures.size(); ++i)
    add(Kind::structure, subject.structures[i], colour_of(*subject.scan, subject.structures[i], i));
  std::size_t pieces = 0, models = 0;
  for (const Object& object : subject.objects) {
    if (object.matter == volume::Matter::scenery) continue;
    auto cut = cut_of(plane, object);
    if (!cut) return cut.error();
    const Kind kind = object.matter == volume::Matter::bone ? Kind::piece
                      : volume::is_metal(object.matter)     ? Kind::model
                                                            : Kind::soft;
    constexpr Panel::Colour k_soft{230, 184, 107};
    objects.push_back({kind, object.name,
                       kind == Kind::piece   ? k_pieces[pieces++ % std::size(k_pieces)]
                       : kind == Kind::model ? k_models[models++ % std::size(k_models)]
                                             : k_soft,
                       std::move(cut).value()});
    if (object.screw) objects.back().uncounted = head_and_tip(plane, *object.screw);
  }
  if (std::any_of(objects.begin(), objects.end(),
                  [](const SectionObject& o) { return o.kind == Kind::model; }))
    objects[0].uncut = cross_section::uncut_bone(plane, volume::Field(*subject.scan, *subject.bone));
  return objects;
}

std::vector<SectionTissue> section_tissues(const Subject& subject, const ImagePlane& plane) {
  const volume::Volume& scan = *subject.scan;
  if (scan.labels.is_empty()) return {};
  // Index of each label's tissue; -1: drawn as an object, or background; k_unused: no pixel found so far.
  constexpr int k_unused = -2;
  std::array<int, 256> index;
  index.fill(k_unused);
  index[0] = -1;
  for (std::size_t label = 1; label < std::min(scan.label_names.size(), index.size()); ++label)
    if (volume::is_bone_name(scan.label_names[label])) index[label] = -1;
  const auto exclude = [&](const volume::Shape& shape) {
    if (shape.is_label() && shape.label < static_cast<int>(index.size()))
      index[static_cast<std::size_t>(shape.label)] = -1;
  };
  if (subject.bone) exclude(*subject.bone);
  for (const volume::Shape& structure : subject.structures) exclude(structure);

  std::vector<SectionTissue> tissues;
  const auto columns = static_cast<std::size_t>(plane.columns), rows = static_cast<std::size_t>(plane.rows);
  for (int row = 0; row < plane.rows; ++row)
    for (int column = 0; column < plane.columns; ++column) {
      const glm::ivec3 v = volume::voxel_of(scan.frame.volume_from_world(plane.world(column, row)));
      if (!scan.contains(v) || (subject.version && !subject.version->is_kept(v))) continue;
      const std::size_t label = scan.labels[scan.index(v.x, v.y, v.z)];
      if (index[label] == -1) continue;
      if (index[label] == k_unused) {
        index[label] = static_cast<int>(tissues.size());
        volume::Shape shape;
        shape.label = static_cast<int>(label);
        Panel::Colour colour = colour_of(scan, shape, 0);
        for (std::uint8_t& c : colour) c = static_cast<std::uint8_t>(c * 11 / 20);
        const bool is_named = label < scan.label_names.size() && !scan.label_names[label].empty();
        tissues.push_back({is_named ? words_of(scan.label_names[label]) : "label " + std::to_string(label),
                           colour, std::vector<std::uint8_t>(columns * rows)});
      }
      tissues[static_cast<std::size_t>(index[label])]
          .inside[static_cast<std::size_t>(column) + columns * static_cast<std::size_t>(row)] = 1;
    }
  return tissues;
}

Panel section_panel(const std::vector<SectionObject>& objects, const std::vector<SectionTissue>& tissues,
                    const ImagePlane& plane, SectionAreas& areas) {
  constexpr Panel::Colour k_empty{16, 16, 18};
  Panel panel;
  panel.columns = plane.columns, panel.rows = plane.rows, panel.mm_per_pixel = plane.pixel;
  panel.is_to_scale = true;
  panel.pixels.reserve(static_cast<std::size_t>(plane.columns) * static_cast<std::size_t>(plane.rows));
  double outside_pixels = 0, model_pixels = 0;
  bool has_cancellous = false;
  for (int row = plane.rows - 1; row >= 0; --row)
    for (int column = 0; column < plane.columns; ++column) {
      const std::size_t at = static_cast<std::size_t>(column) +
                             static_cast<std::size_t>(plane.columns) * static_cast<std::size_t>(row);
      Panel::Colour colour = k_empty;
      for (const SectionTissue& tissue : tissues)
        if (tissue.inside[at]) colour = tissue.colour;
      bool is_bone = !objects[0].by_labels.empty() && objects[0].by_labels[at];
      if (is_bone) colour = k_cancellous;
      const SectionObject* model = nullptr;
      for (const SectionObject& object : objects) {
        if (!object.cut.inside[at]) continue;
        if (object.kind == Kind::model)
          model = &object;
        else
          colour = object.colour, is_bone |= object.kind == Kind::bone || object.kind == Kind::piece;
      }
      if (model != nullptr) {
        const bool is_outside = !is_bone && (objects[0].uncut.empty() || !objects[0].uncut[at]) &&
                                (model->uncounted.empty() || !model->uncounted[at]);
        colour = is_outside ? k_outside_bone : model->colour;
        model_pixels += 1, outside_pixels += is_outside;
      }
      has_cancellous |= colour == k_cancellous;
      panel.pixels.push_back(colour);
    }
  areas = {model_pixels * plane.pixel * plane.pixel, outside_pixels * plane.pixel * plane.pixel};
  set_letters(panel, plane.right, plane.up);
  panel.title = format_text("%s: %.0f mm\u00b2", objects[0].name.c_str(), objects[0].cut.area);
  panel.foot =
      format_text("at %.1f, %.1f, %.1f", plane.middle_world.x, plane.middle_world.y, plane.middle_world.z);
  // Dark rather than black outlines, so that objects as thin as their outline remain visible.
  for (const SectionObject& object : objects) {
    Panel::Colour dark = object.colour;
    for (std::uint8_t& c : dark) c = static_cast<std::uint8_t>(c * 7 / 10);
    for (const cross_section::Loop& loop : object.cut.outline) panel.lines.push_back({loop, dark, true, ""});
  }
  // Legend.
  const auto list = [&](const std::string& name, const Panel::Colour& colour) {
    panel.lines.push_back({{}, colour, true, name});
  };
  for (const SectionObject& object : objects)
    if (object.kind != Kind::bone && object.cut.area > 0)
      list(words_of(object.name) + (object.kind == Kind::structure ? " (do not cut)" : ""), object.colour);
  for (const SectionTissue& tissue : tissues) list(tissue.name, tissue.colour);
  if (has_cancellous) list("bone below the threshold, by labels", k_cancellous);
  if (outside_pixels > 0) list("outside bone", k_outside_bone);
  return panel;
}

}  // namespace trephine::imaging
