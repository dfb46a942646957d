// events_of(): the events of one type in the chronicle of an engine.
#pragma once

#include <utility>
#include <vector>

#include "sim/engine/engine.h"

namespace trephine::sim {

/// Returns the events of a type, oldest first, with their positions (world, mm).
template <class T>
std::vector<std::pair<T, glm::dvec3>> events_of(const Engine& engine) {
  std::vector<std::pair<T, glm::dvec3>> all;
  const Chronicle& chronicle = engine.state().chronicle;
  for (std::size_t i = 0; i < chronicle.size(); ++i)
    if (const T* event = chronicle[i].value.as<T>()) all.emplace_back(*event, chronicle[i].position_world);
  return all;
}

}  // namespace trephine::sim
