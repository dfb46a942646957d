// Field tables of the module's commands, events and state.
#include "modules/bone_flap/bone_flap.h"

namespace trephine::bone_flap {

using sim::field;

const sim::Schema& AddAnchor::schema() {
  static constexpr sim::Field fields[] = {
      field<&AddAnchor::at>("at", {.unit = "mm", .low = -1e5, .high = 1e5, .help = "position on the skull"})};
  static constexpr sim::Schema table{"add-anchor", 1, fields};
  return table;
}
const sim::Schema& MoveAnchor::schema() {
  static constexpr sim::Field fields[] = {
      field<&MoveAnchor::number>(
          "number", {.low = 1, .high = k_max_anchors, .help = "number of the anchor, starting at 1"}),
      field<&MoveAnchor::at>("at",
                             {.unit = "mm", .low = -1e5, .high = 1e5, .help = "position on the skull"})};
  static constexpr sim::Schema table{"move-anchor", 1, fields};
  return table;
}
const sim::Schema& RemoveAnchor::schema() {
  static constexpr sim::Field fields[] = {field<&RemoveAnchor::number>(
      "number", {.low = 0, .high = k_max_anchors, .help = "number of the anchor; 0: the last one"})};
  static constexpr sim::Schema table{"remove-anchor", 1, fields};
  return table;
}
const sim::Schema& ClearAnchors::schema() {
  static constexpr sim::Schema table{"clear-anchors"};
  return table;
}

namespace {
// Fields that cut-flap and preview-flap share.
constexpr std::string_view k_saws[] = {"0.8", "1.2", "1.6", "2.0", "2.4"};
constexpr sim::FieldInfo k_outline{.help = "outline of the plan, instead of anchors",
                                   .names = sim::FieldInfo::Names::outline,
                                   .empty_choice = "Anchors; without anchors, the only outline"};
constexpr sim::FieldInfo k_anchors{.unit = "mm",
                                   .low = -1e5,
                                   .high = 1e5,
                                   .help = "positions on the skull, in order around the outline",
                                   .is_expert = true};
constexpr sim::FieldInfo k_saw{
    .unit = "mm", .choices = k_saws, .help = "width of the cut", .label = "Saw width"};
constexpr sim::FieldInfo k_distance{
    .unit = "mm",
    .low = 20,
    .high = 500,
    .help = "distance from the outline's centre to the point where all lines of the saw meet",
    .label = "Depth where the saw lines meet",
    .is_expert = true};
constexpr sim::FieldInfo k_item{.low = 0,
                                .high = 63,
                                .help = "index of the touched shape that is the skull",
                                .label = "Shape that is the skull",
                                .is_expert = true};
}  // namespace

const sim::Schema& PreviewFlap::schema() {
  static constexpr sim::Field fields[] = {
      field<&PreviewFlap::outline>("outline", k_outline), field<&PreviewFlap::anchors>("anchors", k_anchors),
      field<&PreviewFlap::saw>("saw", k_saw), field<&PreviewFlap::distance>("distance", k_distance),
      field<&PreviewFlap::item>("item", k_item)};
  static constexpr sim::Schema table{"preview-flap", 1, fields};
  return table;
}

const sim::Schema& CutFlap::schema() {
  static constexpr sim::Field fields[] = {
      field<&CutFlap::outline>("outline", k_outline),
      field<&CutFlap::anchors>("anchors", k_anchors),
      field<&CutFlap::saw>("saw", k_saw),
      field<&CutFlap::distance>("distance", k_distance),
      field<&CutFlap::seed>("seed", {.unit = "mm",
                                     .low = -1e5,
                                     .high = 1e5,
                                     .help = "position on the flap; if empty, bone near the outline's centre",
                                     .label = "Position on the flap",
                                     .most_values = 1,
                                     .is_expert = true}),
      field<&CutFlap::leave>("leave", {.help = "numbers of pieces that stay; 1 is the largest piece",
                                       .label = "Pieces that stay",
                                       .is_expert = true}),
      field<&CutFlap::smoothing>("smoothing", {.unit = "mm",
                                               .low = 0,
                                               .high = 3,
                                               .help = "sigma of a Gaussian over the rim",
                                               .label = "Smoothing of the rim"}),
      field<&CutFlap::smallest>(
          "smallest", {.unit = "mm3",
                       .low = 0,
                       .high = 1e6,
                       .help = "smaller pieces become debris, except the piece at the position on the flap",
                       .label = "Smallest piece",
                       .is_expert = true}),
      field<&CutFlap::hole>("hole", {.unit = "mm",
                                     .low = 0,
                                     .high = 50,
                                     .help = "widest gap in the bone that the outline may cross",
                                     .label = "Gap to cross",
                                     .is_expert = true}),
      field<&CutFlap::space>("space", {.unit = "mm",
                                       .low = 0,
                                       .high = 50,
                                       .help = "widest air space in the bone that the saw cuts through",
                                       .label = "Air space to saw through",
                                       .is_expert = true}),
      field<&CutFlap::thickest>("thickest", {.unit = "mm",
                                             .low = 1,
                                             .high = 50,
                                             .help = "largest thickness of the calvaria",
                                             .label = "Thickest calvaria",
                                             .is_expert = true}),
      field<&CutFlap::item>("item", k_item)};
  static constexpr sim::Schema table{"cut-flap", 1, fields};
  return table;
}

const sim::Schema& FlapState::schema() {
  static constexpr sim::Field fields[] = {
      field<&FlapState::flaps>("flaps"),       field<&FlapState::outline>("outline"),
      field<&FlapState::floor>("floor"),       field<&FlapState::centre>("centre"),
      field<&FlapState::normal>("normal"),     field<&FlapState::apex>("apex"),
      field<&FlapState::width>("width"),       field<&FlapState::area>("area"),
      field<&FlapState::wall>("wall"),         field<&FlapState::kerf_size>("kerf_size"),
      field<&FlapState::rim_size>("rim_size"), field<&FlapState::flap_size>("flap_size")};
  static constexpr sim::Schema table{"flap-world", 1, fields};
  return table;
}

const sim::Schema& FlapSettings::schema() {
  static constexpr sim::Field fields[] = {field<&FlapSettings::anchors>("anchors")};
  static constexpr sim::Schema table{"flap-settings", 1, fields};
  return table;
}

const sim::Schema& FlapPreview::schema() {
  static constexpr sim::Field fields[] = {
      field<&FlapPreview::failed_anchors>("tried"),
      field<&FlapPreview::problem>("problem"),
      field<&FlapPreview::problem_at>("problem_at"),
      field<&FlapPreview::lid>("surface"),
      field<&FlapPreview::lid_rings>("surface_rings", {.low = 0, .high = 65536}),
      field<&FlapPreview::depth>("depth"),
      field<&FlapPreview::summary>("summary")};
  static constexpr sim::Schema table{"flap-preview", 1, fields};
  return table;
}

const sim::Schema& FlapCut::schema() {
  static constexpr sim::Field fields[] = {
      field<&FlapCut::pieces>("pieces"),
      field<&FlapCut::area>("area", {.unit = "mm2", .help = "outer surface of the skull inside the cut"}),
      field<&FlapCut::wall>("wall", {.unit = "mm2", .help = "sawn walls in bone"}),
      field<&FlapCut::kerf_size>("kerf", {.unit = "mm3"}),
      field<&FlapCut::rim_size>("rim", {.unit = "mm3", .help = "volume removed by smoothing"}),
      field<&FlapCut::flap_size>("flap", {.unit = "mm3"}),
      field<&FlapCut::holes>(
          "holes",
          {.help = "pairs of bone samples that still connect flap and skull; 0: the cut is complete"})};
  static constexpr sim::Schema table{"flap-cut", 1, fields};
  return table;
}

const sim::Schema& FlapPiece::schema() {
  static constexpr sim::Field fields[] = {
      field<&FlapPiece::number>("number"), field<&FlapPiece::size>("size", {.unit = "mm3"}),
      field<&FlapPiece::is_seed>("seed"), field<&FlapPiece::is_detached>("detached"),
      field<&FlapPiece::is_at_border>("at_border")};
  static constexpr sim::Schema table{"flap-piece", 1, fields};
  return table;
}

const sim::Schema& FlapPreviewed::schema() {
  static constexpr sim::Field fields[] = {
      field<&FlapPreviewed::area>(
          "area", {.unit = "mm2", .help = "outer surface of the skull; 0: the cut would fail"}),
      field<&FlapPreviewed::summary>("summary")};
  static constexpr sim::Schema table{"flap-previewed", 1, fields};
  return table;
}

const sim::Schema& FlapFailed::schema() {
  static constexpr sim::Field fields[] = {field<&FlapFailed::reason>("reason"),
                                          field<&FlapFailed::holes>("holes")};
  static constexpr sim::Schema table{"flap-failed", 1, fields};
  return table;
}

}  // namespace trephine::bone_flap
