// DerivedJob: derivation of data from a state of an operation in the background. The command Adopt later
// adopts the data, such as offset fields.
#pragma once

#include <functional>
#include <limits>
#include <memory>
#include <string>

#include "haptics/depth/depth_source.h"
#include "haptics/scene/touch_state.h"
#include "sim/api/command.h"

namespace trephine::sim {

/// Offset fields of a round tool, one per shape of the base.
using OffsetFields = haptics::TouchState::OffsetFields;

/// Identifies derived data: a hand uses one result per key.
struct DerivedKey {
  DerivedKind kind = DerivedKind::offset_fields;
  std::int64_t item = 0;  ///< of the hand's scene; 0 for offset fields and loose parts
  std::uint8_t hand = 0;

  friend bool operator==(const DerivedKey&, const DerivedKey&) = default;
};

/// Result of a job. Immutable.
struct DerivedData {
  OffsetFields fields = {};                                          ///< of DerivedKind::offset_fields
  std::shared_ptr<const haptics::depth::DepthSet> depths = nullptr;  ///< of depth images and pictures
  bool is_empty = false;   ///< nothing to adopt: the view cannot be drawn, or no part is loose
  std::uint64_t hash = 0;  ///< 0: not compared
};

/// Data to derive. Equal jobs give the same bits on any thread and machine.
struct DerivedJob {
  DerivedKey key = {};
  std::uint64_t serial = 0;                                    ///< Adopt::serial
  std::string input = {};                                      ///< Adopt::input
  std::shared_ptr<const haptics::TouchScene> scene = nullptr;  ///< of the hand, without detached bodies
  double interval = std::numeric_limits<double>::infinity();   ///< s; a job that takes longer is late
  /// Derives the data from immutable data alone, in milliseconds to tenths of a second; the same bits for any
  /// number of threads (0: one per core).
  std::function<DerivedData(int threads)> make = {};

  /// Returns the command that adopts the result.
  Command command(const DerivedData& data) const {
    return {Adopt{key.kind, key.item, static_cast<std::int64_t>(serial), input,
                  static_cast<std::int64_t>(data.hash)},
            key.hand};
  }
};

}  // namespace trephine::sim
