// Sentences about steps: units, numbers and reasons as a user reads them.
#include "apps/workbench/step_text.h"

#include <gtest/gtest.h>

namespace trephine::workbench {
namespace {

TEST(StepText, DescribesUnmetConditions) {
  EXPECT_EQ(describe_unmet({"anchors", 3, {}}, 2), "At least 3 anchors are needed; there are 2.");
  EXPECT_EQ(describe_unmet({"flaps", 1, {}}, 0), "At least 1 flap is needed; there are 0.");
  EXPECT_EQ(describe_unmet({"changes", {}, 1}, 4), "At most 1 change is allowed; there are 4.");
  EXPECT_EQ(describe_unmet({"bodies", 2, {}}, 1), "At least 2 detached pieces are needed; there is 1.");
  EXPECT_EQ(describe_unmet({"removed_mm3", 100, 200}, 40.256),
            "The removed volume must be at least 100 mm³ and at most 200 mm³; it is 40.26 mm³.");
  EXPECT_EQ(describe_unmet({"step_seconds", 10, {}}, 3.0),
            "The time in this step must be at least 10 s; it is 3 s.");
  EXPECT_EQ(describe_unmet({"nearest_mm venous_sinus", 2, {}}, 1.5),
            "The distance from venous sinus must be at least 2 mm; it is 1.5 mm.");
  EXPECT_EQ(describe_unmet({"events flap-cut", 1, {}}, 0), "Still to do in this step: cut the flap.");
  EXPECT_EQ(describe_unmet({"events note", 1, {}}, 0), "Still to do in this step: \"note\".");
  EXPECT_EQ(describe_unmet({"tracks", 1, {}}, 0),
            "Still to do in this step: make a track with the probe, and draw the probe out.");
  EXPECT_EQ(describe_unmet({"tracks", 2, {}}, 1), "At least 2 tracks are needed; there is 1.");
  EXPECT_EQ(describe_unmet({"target exposed", 90, {}}, {}),
            "Target exposed must be at least 90; it is unknown, or outdated by a later change.");
}

/// The error of the engine lists measurements with values, and hands with instruments.
TEST(StepText, DescribesEachReasonOfARefusal) {
  volume::ProcedureStep step;
  step.name = "plan";
  step.transitions.push_back({"cut", "request", {{"anchors", 3, {}}, {"flaps", {}, 0}, {"screws", 1, {}}}});
  step.transitions.push_back({"judge", "flap-cut", {{"anchors", 9, {}}}});
  const Error unmet{.what = "the conditions of the next step are not met",
                    .where = "step plan",
                    .found = "anchors 2, screws unknown; hand 1: burr"};
  EXPECT_EQ(describe_refusal(step, "cut", unmet),
            "At least 3 anchors are needed; there are 2. At least 1 screw is needed; the number is unknown.");
  EXPECT_EQ(describe_refusal(step, "cut", {.what = "x", .found = "hand 2: burr"}),
            "Hand 2 holds the burr, which the next step does not allow. Choose another tool, or no tool.");
  // A name that ends like another one, and limits that hold.
  EXPECT_EQ(describe_refusal(step, "cut", {.what = "x", .found = "old anchors 2, anchors 5"}),
            "X: old anchors 2, anchors 5.");
  EXPECT_EQ(describe_refusal(step, "judge", {.what = "the step cannot be requested", .found = "judge"}),
            "The step cannot be requested: judge.");
}

TEST(StepText, DescribesProhibitions) {
  volume::ProcedureStep step;
  step.name = "remove-bone";
  const Error error{.what = "the step does not allow the command",
                    .found = "cut-flap",
                    .expected = "add-anchor, burr kinematic=no"};
  EXPECT_EQ(
      describe_prohibition(step, "command", error),
      "The step \"remove bone\" does not allow this command. It allows: add anchor, burr kinematic=no.");
  step.title = "Remove bone";
  EXPECT_TRUE(describe_prohibition(step, "instrument", error)
                  .starts_with("The step \"Remove bone\" does not allow this instrument."));
}

}  // namespace
}  // namespace trephine::workbench
