// Picture of the steps of a procedure.
#pragma once

#include <string>

#include "apps/imaging/step_diagram.h"
#include "volume/base/error.h"

namespace trephine::view {

/// Draws a diagram into memory and writes a PNG. Error (ErrorKind::missing_here)
/// if OpenGL is not available.
Status write_steps(const imaging::StepDiagram& diagram, const std::string& path);

}  // namespace trephine::view
