// Tables of the fields of the module's structs.
#include "modules/pedicle/pedicle.h"

namespace trephine::pedicle {

using sim::field;

const sim::Schema& PedicleState::schema() {
  static constexpr sim::Field fields[] = {
      field<&PedicleState::track_entries>("track_entries", {.unit = "mm"}),
      field<&PedicleState::track_ends>("track_ends", {.unit = "mm"}),
      field<&PedicleState::track_depths>("track_depths", {.unit = "mm"}),
      field<&PedicleState::track_outside>("track_outside", {.unit = "mm"}),
      field<&PedicleState::screw_bodies>("screw_bodies"),
      field<&PedicleState::screw_entries>("screw_entries", {.unit = "mm"}),
      field<&PedicleState::screw_tips>("screw_tips", {.unit = "mm"}),
      field<&PedicleState::screw_diameters>("screw_diameters", {.unit = "mm"}),
      field<&PedicleState::screw_tracks>("screw_tracks")};
  static constexpr sim::Schema table{"pedicle-state", 1, fields};
  return table;
}

const sim::Schema& PlaceScrew::schema() {
  static constexpr sim::Field fields[] = {
      field<&PlaceScrew::track>("track", {.low = 0,
                                          .high = 1000,
                                          .help = "number of the track; 0: the last",
                                          .empty_choice = "The last track"}),
      field<&PlaceScrew::diameter>("diameter",
                                   {.unit = "mm", .choices = k_diameters, .help = "outer diameter"}),
      field<&PlaceScrew::length>("length",
                                 {.unit = "mm", .choices = k_lengths, .help = "length below the head"}),
      field<&PlaceScrew::entry>("entry", {.unit = "mm",
                                          .low = -1e5,
                                          .high = 1e5,
                                          .help = "position at which it enters, instead of a track",
                                          .most_values = 1,
                                          .is_expert = true}),
      field<&PlaceScrew::target>("target", {.unit = "mm",
                                            .low = -1e5,
                                            .high = 1e5,
                                            .help = "position toward which it points",
                                            .most_values = 1,
                                            .is_expert = true}),
      field<&PlaceScrew::seconds>(
          "seconds",
          {.unit = "s", .low = 0, .high = 30, .help = "duration of its motion", .is_expert = true}),
      field<&PlaceScrew::is_forced>("forced",
                                    {.help = "allows a tip far in front of the bone", .is_expert = true}),
      field<&PlaceScrew::item>("item",
                               {.low = 0, .high = 63, .help = "shape of the bone", .is_expert = true})};
  static constexpr sim::Schema table{"place-screw", 1, fields};
  return table;
}

const sim::Schema& RemoveScrew::schema() {
  static constexpr sim::Field fields[] = {
      field<&RemoveScrew::body>("body", {.help = "number of the screw among the bodies; 0: the last screw",
                                         .label = "Screw",
                                         .empty_choice = "The last screw"})};
  static constexpr sim::Schema table{"remove-screw", 1, fields};
  return table;
}

const sim::Schema& ScrewPlaced::schema() {
  static constexpr sim::Field fields[] = {
      field<&ScrewPlaced::body>("body"),
      field<&ScrewPlaced::diameter>("diameter", {.unit = "mm"}),
      field<&ScrewPlaced::length>("length", {.unit = "mm"}),
      field<&ScrewPlaced::tip>("tip", {.unit = "mm"}),
      field<&ScrewPlaced::track>("track", {.help = "number of its track; 0: none"}),
      field<&ScrewPlaced::beyond_track>(
          "beyond_track", {.unit = "mm", .help = "length beyond its track; negative: shorter"})};
  static constexpr sim::Schema table{"screw-placed", 1, fields};
  return table;
}

const sim::Schema& ScrewFailed::schema() {
  static constexpr sim::Field fields[] = {field<&ScrewFailed::reason>("reason")};
  static constexpr sim::Schema table{"screw-failed", 1, fields};
  return table;
}

const sim::Schema& JudgeScrew::schema() {
  static constexpr sim::Field fields[] = {
      field<&JudgeScrew::body>("body", {.help = "number of the screw among the bodies; 0: the last screw",
                                        .label = "Screw",
                                        .empty_choice = "The last screw"}),
      field<&JudgeScrew::vertebra>("vertebra", {.help = "label of the vertebra; without it that of the screw",
                                                .names = sim::FieldInfo::Names::bone_label,
                                                .empty_choice = "That of the screw"}),
      field<&JudgeScrew::canal>("canal", {.unit = "mm",
                                          .low = -1e5,
                                          .high = 1e5,
                                          .help = "position in its canal, at the height of the lamina",
                                          .label = "or a position in its canal",
                                          .is_expert = true}),
      field<&JudgeScrew::item>("item",
                               {.low = 0, .high = 63, .help = "shape of the bone", .is_expert = true}),
      field<&JudgeScrew::trajectory_zero>(
          "trajectory_zero",
          {.unit = "mm",
           .low = 0.1,
           .high = 1000,
           .help = "distances of entry and tip from the plan, in sum, from which on there are no points",
           .label = "No points from a plan error of",
           .is_expert = true}),
      field<&JudgeScrew::depth_zero>(
          "depth_zero",
          {.unit = "mm",
           .low = 0.1,
           .high = 1000,
           .help = "difference between the lengths of screw and track from which on there are no points",
           .label = "No points from a depth error of",
           .is_expert = true}),
      field<&JudgeScrew::trajectory_share>(
          "trajectory_share",
          {.low = 0, .high = 1, .help = "share of the trajectory in the score", .is_expert = true})};
  static constexpr sim::Schema table{"judge-screw", 1, fields};
  return table;
}

const sim::Schema& ScrewJudged::schema() {
  static constexpr sim::Field fields[] = {
      field<&ScrewJudged::body>("body"),
      field<&ScrewJudged::vertebra>("vertebra"),
      field<&ScrewJudged::side>("side", {.choices = k_side_names}),
      field<&ScrewJudged::breach>("breach",
                                  {.unit = "mm", .help = "of the pedicle; negative: thickness of bone"}),
      field<&ScrewJudged::wall>("wall", {.choices = k_wall_names}),
      field<&ScrewJudged::breach_at>("breach_at", {.unit = "mm"}),
      field<&ScrewJudged::from_entry>("from_entry", {.unit = "mm"}),
      field<&ScrewJudged::front>("front", {.unit = "mm", .help = "in front of the vertebra's body"}),
      field<&ScrewJudged::front_at>("front_at", {.unit = "mm"}),
      field<&ScrewJudged::grade>("grade", {.choices = k_grade_names}),
      field<&ScrewJudged::grade_of_larger>("grade_larger",
                                           {.choices = k_grade_names, .help = "bone half a voxel larger"}),
      field<&ScrewJudged::grade_of_smaller>("grade_smaller",
                                            {.choices = k_grade_names, .help = "bone half a voxel smaller"}),
      field<&ScrewJudged::half_voxel>("half_voxel", {.unit = "mm"}),
      field<&ScrewJudged::is_uncertain>("uncertain", {.help = "the voxels do not decide the grade"}),
      field<&ScrewJudged::has_intensity>("has_intensity"),
      field<&ScrewJudged::core_hu>("core", {.unit = "HU"}),
      field<&ScrewJudged::shell_hu>("shell", {.unit = "HU"}),
      field<&ScrewJudged::planned>("planned"),
      field<&ScrewJudged::entry_error>("entry_error", {.unit = "mm"}),
      field<&ScrewJudged::target_error>("target_error", {.unit = "mm"}),
      field<&ScrewJudged::angle_error>("angle_error", {.unit = "degrees"}),
      field<&ScrewJudged::has_track>("has_track"),
      field<&ScrewJudged::depth_error>("depth_error", {.unit = "mm"}),
      field<&ScrewJudged::has_score>("has_score"),
      field<&ScrewJudged::score>("score")};
  static constexpr sim::Schema table{"screw-judged", 1, fields};
  return table;
}

const sim::Schema& ScrewNotJudged::schema() {
  static constexpr sim::Field fields[] = {field<&ScrewNotJudged::reason>("reason")};
  static constexpr sim::Schema table{"screw-not-judged", 1, fields};
  return table;
}

const sim::Schema& ScrewJudgements::schema() {
  static constexpr sim::Field fields[] = {field<&ScrewJudgements::bodies>("bodies"),
                                          field<&ScrewJudgements::names>("names"),
                                          field<&ScrewJudgements::breaches>("breaches", {.unit = "mm"}),
                                          field<&ScrewJudgements::fronts>("fronts", {.unit = "mm"}),
                                          field<&ScrewJudgements::grades>("grades"),
                                          field<&ScrewJudgements::scores>("scores")};
  static constexpr sim::Schema table{"screw-judgements", 1, fields};
  return table;
}

}  // namespace trephine::pedicle
