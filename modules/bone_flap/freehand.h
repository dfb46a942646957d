// A bone flap that was cut by hand, with a drill or a craniotome: its outline is measured on the detached
// piece.
#pragma once

#include <optional>

#include "modules/bone_flap/bone_flap.h"

namespace trephine::bone_flap {

/// Returns the largest detached part of the anatomy, if no flap was cut by a command and the part is as large
/// as a flap; null otherwise.
const sim::Body* freehand_piece(const sim::OperationState& operation);
/// Returns the flap that a detached piece is: outline on its outer surface, half a kerf outside its edge;
/// centre, normal and area. `flaps` is 0, and the floor of the saw is unknown. The centre is that of the
/// piece. `middle_world`: a point inside the head.
FlapState flap_of_piece(const sim::Piece& piece, const glm::dvec3& middle_world);
/// Returns the flap that is judged: that of the last command, or else one that was cut by hand; nullopt if
/// there is no flap.
std::optional<FlapState> current_flap(const sim::OperationState& operation);

}  // namespace trephine::bone_flap
