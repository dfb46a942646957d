// Ventriculostomy: insertion of a catheter through a hole into a ventricle, and judgement of its path.
#pragma once

#include "modules/ventriculostomy/catheter_in_place.h"
#include "modules/ventriculostomy/judgement.h"

namespace trephine::ventriculostomy {

class Ventriculostomy final : public sim::Module {
 public:
  std::string_view name() const noexcept override { return "ventriculostomy"; }
  std::span<const sim::InstrumentType* const> instruments() const override;
  std::span<const sim::JobType* const> jobs() const override;
  std::span<const sim::ValueType* const> events() const override;
  std::uint32_t version() const noexcept override {
    return 5;  // since 4, a catheter that cannot enter is held before the layer
  }
  sim::Value undoable() const override { return CathetersInPlace{}; }
  sim::Value settings() const override { return CatheterPassages{}; }
  sim::Value result() const override { return CatheterJudged{}; }
  Status allows(const sim::Command& command, const sim::OperationState& operation) const override;
  void react(const sim::Event& event, const sim::OperationState& operation,
             sim::ModuleReaction& reaction) const override;
  void react_to_command(const sim::Command& command, const sim::OperationState& operation,
                        sim::ModuleReaction& reaction) const override;
  std::vector<sim::Measure> measures(const sim::OperationState& operation) const override;
  std::vector<sim::Finding> findings(const sim::JobInput& input) const override;
  bool is_moving(const sim::OperationState& operation) const override;
  sim::Overlays overlays(const sim::OperationState& operation) const override;
};

}  // namespace trephine::ventriculostomy
