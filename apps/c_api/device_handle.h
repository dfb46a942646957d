// The device behind a handle of the C interface.
#pragma once

#include "apps/c_api/c_parts.h"

struct trephine_device {
  trephine::HandDevice device;
  explicit trephine_device(trephine::HandDevice opened) : device(std::move(opened)) {}
};
