// ByteReader: reads the values of a checkpoint. Included by checkpoint_store.cpp only.
#pragma once

#include <string>
#include <string_view>
#include <utility>

#include "haptics/servo/servo_memory.h"
#include "volume/base/bytes.h"

namespace trephine::sim {

using trephine::get;
using trephine::get_number;
using trephine::get_text;

/// Thrown for broken bytes; CheckpointStore catches it.
struct Broken {
  const char* what;
};

/// Reads one value after another; throws Broken for an invalid one.
class ByteReader {
 public:
  explicit ByteReader(std::string_view in) : in_(in) {}

  template <class T>
  T value() {
    T result{};
    if (!get(in_, result)) throw Broken{"it ends early"};
    return result;
  }
  std::uint64_t count(std::uint64_t limit = ~std::uint64_t{0}) {
    const std::int64_t result = signed_number();
    if (result < 0 || static_cast<std::uint64_t>(result) > limit) throw Broken{"a number out of its range"};
    return static_cast<std::uint64_t>(result);
  }
  std::int64_t signed_number() {
    std::int64_t result = 0;
    if (!get_number(in_, result)) throw Broken{"it ends early"};
    return result;
  }
  /// Reads a number of elements that take at least a byte each.
  std::uint64_t element_count() { return count(in_.size()); }
  std::string_view text() {
    std::string_view result;
    if (!get_text(in_, result)) throw Broken{"it ends early"};
    return result;
  }
  double number() {
    const auto result = value<double>();
    if (!(std::abs(result) < 1e12)) throw Broken{"an invalid number"};
    return result;
  }
  glm::dvec3 position() {
    const double x = number(), y = number(), z = number();
    return {x, y, z};
  }
  std::uint8_t flags(std::uint8_t known) {
    const auto result = value<std::uint8_t>();
    if ((result & ~known) != 0) throw Broken{"an unknown flag"};
    return result;
  }
  haptics::Placement placement() {
    haptics::Placement result;
    result.position_world = position();
    double parts[4];
    for (double& part : parts) part = number();
    result.rotation = {parts[0], parts[1], parts[2], parts[3]};
    if (!(std::abs(glm::length(result.rotation) - 1) < 1e-6)) throw Broken{"an invalid rotation"};
    return result;
  }
  volume::VoxelBox box(const glm::ivec3& size) {
    volume::VoxelBox result;
    bool is_empty = false;
    for (glm::ivec3* corner : {&result.low, &result.high})
      for (int a = 0; a < 3; ++a) {
        const std::int64_t at = signed_number();
        if (std::abs(at) > (1 << 30)) throw Broken{"an invalid box"};
        (*corner)[a] = static_cast<int>(at);
      }
    for (int a = 0; a < 3; ++a) is_empty = is_empty || result.low[a] > result.high[a];
    for (int a = 0; !is_empty && a < 3; ++a)
      if (result.low[a] < -64 || result.high[a] > size[a] + 64) throw Broken{"a box beyond the volume"};
    return result;
  }
  haptics::ServoRecord record() {
    haptics::ServoRecord result;
    if (!haptics::get_record(in_, result)) throw Broken{"an invalid tick"};
    return result;
  }
  bool is_at_end() const { return in_.empty(); }

 private:
  std::string_view in_;
};

template <class T>
T value_or_throw(Result<T> result) {
  if (!result) throw Broken{"invalid bricks or values"};
  return std::move(result).value();
}

}  // namespace trephine::sim
