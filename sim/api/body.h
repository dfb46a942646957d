// Body: an object of an operation, which is either a detached part of the anatomy or an implant.
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "haptics/mesh/mesh_tree.h"
#include "haptics/scene/touch_scene.h"
#include "sim/api/command.h"
#include "volume/cuts/version.h"
#include "volume/scan/matter.h"

namespace trephine::volume {
struct PartSurface;
class SolidParts;
}  // namespace trephine::volume

namespace trephine::sim {

/// Surface of a body, in the frame of the piece: for a detached part the world frame at its detachment, for
/// an implant the implant's own frame. A piece is touched like a model, and cannot be cut.
struct Piece {
  std::shared_ptr<const haptics::MeshTree> tree;
  haptics::Material material;
  double mm3 = 0;                ///< volume
  glm::dvec3 middle_world{0.0};  ///< mm, mean of the vertices, in the frame of the piece
  std::uint64_t hash = 0;        ///< of to_bytes()

  Piece(const volume::PartSurface& surface, const haptics::Material& material);
};
/// Returns canonical bytes: equal bytes give an equal piece.
std::string to_bytes(const Piece& piece);
/// Returns null for invalid bytes.
std::shared_ptr<const Piece> piece_from_bytes(std::string_view bytes);

/// Motion of a body to its placement, such as that of a screw: straight, with turns about an axis.
struct BodyMotion {
  haptics::Placement from;       ///< pose at the start
  std::uint64_t begin_tick = 0;  ///< tick at which the motion starts
  double seconds = 0;            ///< duration; 0: no motion
  double turns = 0;              ///< additional turns about `axis`, by the right-hand rule
  glm::dvec3 axis{0, 0, 1};      ///< unit, in the frame of the body
  /// Returns the pose at a time (s) after the start, on the way to `placement`.
  haptics::Placement at(double time, const haptics::Placement& placement) const noexcept;
};

struct Body {
  Id id;          ///< never reused
  int mover = 0;  ///< number of its mover, while the body exists; -1 for a fixed body
  std::shared_ptr<const Piece> piece;
  haptics::Placement placement;  ///< pose of the frame of the piece; for a held body, before the grasp
  int holder = -1;               ///< hand that holds it; -1: no hand. Undo does not restore grasps
  haptics::Placement grip = {};  ///< pose relative to that hand
  volume::Matter matter = volume::Matter::bone;
  bool is_implant = false;  ///< was never part of the anatomy
  bool is_fixed = false;    ///< cannot be grasped or placed
  BodyMotion motion = {};   ///< a body in motion is not touched
};

/// An implant that a job adds.
struct NewBody {
  std::shared_ptr<const Piece> piece;
  haptics::Placement placement;
  volume::Matter matter = volume::Matter::titanium;
  bool is_fixed = true;
  BodyMotion motion = {};  ///< begin_tick is set at the adoption
};

/// Fate of a part of a cut shape.
enum class PartFate : std::uint8_t { stays, piece, debris };

/// Result of detaching parts of a shape.
struct Detachment {
  std::shared_ptr<const volume::Version> rest;  ///< version without the detached parts
  std::vector<std::shared_ptr<const Piece>> pieces;
  /// Number of parts that are pieces. If it exceeds TouchScene::k_max_movers, nothing is detached.
  std::size_t piece_count = 0;
  volume::VoxelBox box;     ///< voxels that may look different
  std::int64_t debris = 0;  ///< number of smaller parts, which were removed
  double debris_mm3 = 0;
};
/// Checks that `item` is the index of a shape of the anatomy whose parts can be detached. `field`: location
/// for the error.
Status check_shape_of_pieces(const haptics::TouchScene& anatomy, std::int64_t item, const char* field);
/// Returns the hash of the remaining version and of the pieces.
std::uint64_t hash_of(const Detachment& detachment);
/// Detaches parts, one after another. `fates`: one per part. `solids`: fields of all matter that can be cut,
/// as in the engine's editor. Takes seconds for large pieces.
Detachment detach_parts(const haptics::TouchItem& shape, const volume::SolidParts& parts,
                        std::span<const PartFate> fates, std::vector<volume::Field> solids,
                        const std::shared_ptr<const volume::Version>& version);
/// Detaches the disconnected parts. Parts of at least the requested volume become pieces; smaller parts
/// become debris. May run on any thread, since all input is immutable. `solids` and duration: as for
/// detach_parts().
Detachment detach_free_pieces(const haptics::TouchItem& shape, const FreePieces& request,
                              std::vector<volume::Field> solids,
                              const std::shared_ptr<const volume::Version>& version);

}  // namespace trephine::sim
