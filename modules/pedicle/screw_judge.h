// ScrewJudge: judges screws in the vertebrae that they are in, found by the labels along them.
#pragma once

#include <map>
#include <optional>

#include "modules/pedicle/judgement.h"

namespace trephine::pedicle {

/// Searches for each vertebra once, which takes tenths of a second. Borrows the input for its lifetime.
class ScrewJudge {
 public:
  /// `item`: index of the bone's shape in the anatomy.
  ScrewJudge(const sim::JobInput& input, std::size_t item, const ScoreMarks& marks)
      : input_(input), item_(item), marks_(marks) {}

  /// Tries the labels along a screw, the most frequent first, and returns the first judgement that succeeds;
  /// else the error of the last label.
  Result<ScrewJudged, LocatedError> judge(const JudgedScrew& screw);
  /// Judges a screw in the vertebra with this label; -1: in the bone around `canal_world`, mm.
  Result<ScrewJudged, LocatedError> judge_in(const JudgedScrew& screw, int label,
                                             const glm::dvec3* canal_world);

 private:
  const std::shared_ptr<const volume::Volume>& scan() const {
    return input_.state.undoable.version->shared_base();
  }

  const sim::JobInput& input_;
  std::size_t item_;
  ScoreMarks marks_;
  std::map<int, Result<JudgedBone, LocatedError>> bones_;  ///< by label
};

}  // namespace trephine::pedicle
