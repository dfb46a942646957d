// Event texts: every event type of the catalogue has a sentence.
#include "apps/workbench/event_text.h"

#include <cctype>
#include <gtest/gtest.h>

#include "modules/bone_flap/bone_flap.h"
#include "modules/bone_flap/judgement.h"
#include "modules/catalogue.h"
#include "modules/pedicle/pedicle.h"
#include "sim/api/forbidden.h"

namespace trephine::workbench {
namespace {

/// A window shows the entries of this table: events of a missing type would never be shown.
TEST(EventText, EveryEventOfTheCatalogueHasASentence) {
  int count = 0;
  for (const sim::ValueType* type : modules::catalogue().all()) {
    if (!modules::catalogue().is_event(*type)) {
      EXPECT_FALSE(has_event_text(*type)) << type->schema->name;
      continue;
    }
    ++count;
    EXPECT_TRUE(has_event_text(*type))
        << type->schema->name << " needs a row in apps/workbench/event_text.cpp";
  }
  EXPECT_GT(count, 20);
  // Planted fault: a type in no table.
  struct Unknown {
    double value = 3;
    static const sim::Schema& schema() {
      static constexpr sim::Field fields[] = {sim::field<&Unknown::value>("value")};
      static constexpr sim::Schema table{"unknown-event", 1, fields};
      return table;
    }
  };
  EXPECT_FALSE(has_event_text(sim::value_type<Unknown>()));
  const EventText plain = describe_event({0, 0, {}, Unknown{}});
  EXPECT_NE(plain.text.find("value=3"), std::string::npos) << plain.text;
  EXPECT_EQ(plain.level, EventLevel::record);
}

TEST(EventText, SentencesAndLevels) {
  const EventText torn = describe_event({0, 0, {}, sim::StructureTorn{"dura", 1.45}});
  EXPECT_EQ(torn.text, "The tool tore the dura at a depth of 1.45 mm.");
  EXPECT_EQ(torn.level, EventLevel::danger);
  const EventText none = describe_event({0, 0, {}, bone_flap::FlapFailed{"the outline crosses itself"}});
  EXPECT_EQ(none.text, "No bone flap: the outline crosses itself");
  EXPECT_EQ(none.level, EventLevel::refusal);
  EXPECT_EQ(describe_event({0, 0, {}, sim::FaultEvent{"stale scene", true}}).level, EventLevel::record);
  // If the depth exceeds that of a tear, the event that the tool has left is a danger.
  EXPECT_EQ(describe_event({0, 0, {}, sim::ForbiddenLeft{"cord", 5.78, 2}}).level, EventLevel::danger);
  EXPECT_EQ(describe_event({0, 0, {}, sim::ForbiddenLeft{"cord", 0.4, 2}}).level, EventLevel::record);
  EXPECT_EQ(describe_event({0, 0, {}, sim::FaultEvent{"stale scene, lost device", false}}).text,
            "The force is off: the haptic device does not respond, the computer is too busy.");
}

TEST(EventText, StepsHaveTheirTitles) {
  volume::SurgicalProcedure procedure;
  procedure.steps.resize(2);
  procedure.steps[0].name = "burr-holes", procedure.steps[0].title = "Drill the burr holes";
  procedure.steps[1].name = "saw";
  EXPECT_EQ(describe_event({0, 0, {}, sim::StepEntered{"burr-holes"}}, procedure).text,
            "The step \"Drill the burr holes\" began.");
  EXPECT_EQ(describe_event({0, 0, {}, sim::StepRefused{"burr-holes", "cut-flap", "no hole"}}, procedure).text,
            "Cut-flap was refused in the step \"Drill the burr holes\": no hole.");
  EXPECT_EQ(describe_event({0, 0, {}, sim::StepEntered{"saw"}}, procedure).text, "The step saw began.");
  const sim::StepRefused held{
      "saw", "undo", "a hand holds an instrument that the step burr-holes does not allow: hand 1: saw"};
  EXPECT_EQ(
      describe_event({0, 0, {}, held}, procedure).text,
      "Undo was refused: the step \"Drill the burr holes\" does not allow the tool in the hand. Choose No "
      "tool first.");
}

TEST(EventText, NamesOfLabelsAreWords) {
  bone_flap::FlapJudged judged;
  judged.target = "brain_tumour", judged.has_target = true;
  for (const sim::Value& event :
       {sim::Value(bone_flap::FlapClearance{"venous_sinus", 2, false}),
        sim::Value(bone_flap::FlapClearance{"venous_sinus", -1, false}),
        sim::Value(bone_flap::FlapClearance{"venous_sinus", 0, true}), sim::Value(judged),
        sim::Value(pedicle::ProbeOut{.label = "vertebra_L4"})}) {
    const std::string text = describe_event({0, 0, {}, event}).text;
    EXPECT_EQ(text.find('_'), std::string::npos) << text;
    EXPECT_TRUE(text.find("venous sinus") != std::string::npos ||
                text.find("brain tumour") != std::string::npos ||
                text.find("vertebra L4") != std::string::npos)
        << text;
  }
}

}  // namespace
}  // namespace trephine::workbench
