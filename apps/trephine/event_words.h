// What happened in a session, in words.
#pragma once

#include <string>

#include "sim/event.h"

namespace trephine::app {

/// For people: "the tool came into dura, working".
std::string words_of(const sim::Event& event);

}  // namespace trephine::app
