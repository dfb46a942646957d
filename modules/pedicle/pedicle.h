// Pedicle: tracks of a probe, screws in them, and judgements of these screws.
#pragma once

#include "modules/pedicle/judgement.h"
#include "modules/pedicle/placement.h"
#include "modules/pedicle/probe.h"
#include "sim/api/module.h"

namespace trephine::pedicle {

class Pedicle final : public sim::Module {
 public:
  std::string_view name() const noexcept override { return "pedicle"; }
  std::uint32_t version() const noexcept override { return 4; }  // 4: screw-placed has beyond_track
  std::span<const sim::InstrumentType* const> instruments() const override;
  std::span<const sim::ValueType* const> commands() const override;
  std::span<const sim::JobType* const> jobs() const override;
  std::span<const sim::ValueType* const> events() const override;
  sim::Value undoable() const override { return PedicleState{}; }
  sim::Value result() const override { return ScrewJudgements{}; }
  Status allows(const sim::Command& command, const sim::OperationState& operation) const override;
  void apply(const sim::Command& command, sim::ModuleWork& work) const override;
  void react(const sim::Event& event, const sim::OperationState& operation,
             sim::ModuleReaction& reaction) const override;
  void react_to_command(const sim::Command& command, const sim::OperationState& operation,
                        sim::ModuleReaction& reaction) const override;
  std::vector<sim::Measure> measures(const sim::OperationState& operation) const override;
  std::vector<sim::Finding> findings(const sim::JobInput& input) const override;
  /// True while a probe is in bone: the label next to it shows its depth.
  bool is_moving(const sim::OperationState& operation) const override;
  sim::Overlays overlays(const sim::OperationState& operation) const override;
};

}  // namespace trephine::pedicle
