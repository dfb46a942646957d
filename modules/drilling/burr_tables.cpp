// Field tables of a burr: parameters, state and event.
#include "modules/drilling/burr.h"

namespace trephine::drilling {

using sim::field;

const sim::Schema& Burr::schema() {
  constexpr double k_above_0 = 1e-9;
  static constexpr std::string_view shapes[] = {"sphere", "cylinder", "barrel", "match-head"};
  static constexpr std::string_view grades[] = {"cutting", "diamond"};
  static constexpr sim::Field fields[] = {
      field<&Burr::diameter>("diameter",
                             {.unit = "mm", .low = k_above_0, .high = 30, .help = "largest diameter"}),
      field<&Burr::removal_rate>("removal_rate",
                                 {.unit = "mm3/s",
                                  .low = 0,
                                  .high = 1e5,
                                  .help = "rate in contact at any force; 0: by force, speed and bone",
                                  .label = "Fixed removal rate",
                                  .is_expert = true}),
      field<&Burr::feed_limit>("feed_limit", {.unit = "mm/s",
                                              .low = k_above_0,
                                              .high = 1e4,
                                              .help = "fastest motion through matter",
                                              .label = "Fastest feed",
                                              .is_expert = true}),
      field<&Burr::is_kinematic>("kinematic", {.help = "removes all that it sweeps, touched or not",
                                               .label = "Cuts what it sweeps",
                                               .is_expert = true}),
      field<&Burr::is_round>("round", {.help = "the whole burr touches, not a point",
                                       .label = "Touches with the whole burr",
                                       .is_expert = true}),
      field<&Burr::shape>("shape", {.choices = shapes, .help = "shape of the cutting part"}),
      field<&Burr::grade>(
          "grade",
          {.choices = grades, .help = "a cutting burr has teeth, a diamond one grains", .label = "Type"}),
      field<&Burr::rpm>(
          "rpm",
          {.unit = "1/min", .low = 100, .high = 5e5, .help = "speed of the spindle", .label = "Speed"}),
      field<&Burr::length>("length", {.unit = "mm",
                                      .low = 0,
                                      .high = 30,
                                      .help = "length of the cutting part; 0: usual for the shape",
                                      .label = "Cutting length",
                                      .is_expert = true}),
      field<&Burr::shaft>("shaft", {.unit = "mm",
                                    .low = 0,
                                    .high = 100,
                                    .help = "length of the shaft that also touches, if round is set",
                                    .label = "Shaft that touches",
                                    .is_expert = true}),
      field<&Burr::is_dry>("dry", {.help = "without irrigation", .label = "Without irrigation"})};
  static constexpr sim::Schema table{"burr", 1, fields};
  return table;
}

const sim::Schema& BurrState::schema() {
  static constexpr sim::Field fields[] = {field<&BurrState::has_centre>("has_centre"),
                                          field<&BurrState::centre>("centre", {.unit = "mm"}),
                                          field<&BurrState::axis>("axis"),
                                          field<&BurrState::hip>("hip", {.unit = "mm"}),
                                          field<&BurrState::free_mm>("free", {.unit = "mm"}),
                                          field<&BurrState::removal_budget_mm3>("budget", {.unit = "mm3"}),
                                          field<&BurrState::shaft>("shaft"),
                                          field<&BurrState::engaged>("engaged", {.unit = "mm2"}),
                                          field<&BurrState::bite_mm3>("bite", {.unit = "mm3"}),
                                          field<&BurrState::bite_mm>("bite_path", {.unit = "mm"}),
                                          field<&BurrState::held_at>("held_at", {.unit = "mm"}),
                                          field<&BurrState::held_normal>("held_normal"),
                                          field<&BurrState::begun_at>("begun_at", {.unit = "mm"}),
                                          field<&BurrState::thrust>("thrust", {.unit = "N"}),
                                          field<&BurrState::is_through>("is_through"),
                                          field<&BurrState::deepest>("deepest", {.unit = "mm"}),
                                          field<&BurrState::seconds>("seconds", {.unit = "s"}),
                                          field<&BurrState::deepest_at>("deepest_at", {.unit = "s"}),
                                          field<&BurrState::rise>("rise", {.unit = "K"}),
                                          field<&BurrState::hottest>("hottest", {.unit = "K"})};
  static constexpr sim::Schema table{"burr-state", 1, fields};
  return table;
}

const sim::Schema& Breakthrough::schema() {
  static constexpr sim::Field fields[] = {
      field<&Breakthrough::thrust>("thrust", {.unit = "N", .help = "force before the breakthrough"}),
      field<&Breakthrough::plunge>("plunge", {.unit = "mm", .help = "depth beyond the breakthrough"}),
      field<&Breakthrough::seconds>("seconds", {.unit = "s", .help = "time until the deepest point"})};
  static constexpr sim::Schema table{"breakthrough", 1, fields};
  return table;
}

}  // namespace trephine::drilling
