#include "sim/api/body.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

#include "sim/api/event.h"
#include "sim/api/work.h"
#include "volume/base/bytes.h"
#include "volume/base/deterministic_math.h"
#include "volume/cuts/removal.h"
#include "volume/surface/part_surface.h"

namespace trephine::sim {

using trephine::get;
using trephine::put;

Piece::Piece(const volume::PartSurface& surface, const haptics::Material& surface_material)
    : material(surface_material) {
  std::vector<glm::dvec3> vertices(surface.vertices_world.begin(), surface.vertices_world.end());
  for (const glm::dvec3& v : vertices) middle_world += v / static_cast<double>(vertices.size());
  for (std::size_t t = 0; t < surface.triangles.size(); t += 3) {
    const auto corner = [&](std::size_t k) { return vertices[surface.triangles[t + k]] - middle_world; };
    mm3 += glm::dot(corner(0), glm::cross(corner(1), corner(2))) / 6;
  }
  tree = std::make_shared<const haptics::MeshTree>(std::move(vertices), surface.triangles);
  MixHash all;
  add_bytes(all, to_bytes(*this));
  hash = all.value();
}

haptics::Placement BodyMotion::at(double time, const haptics::Placement& placement) const noexcept {
  const double share = seconds > 0 ? std::clamp(time / seconds, 0.0, 1.0) : 1.0;
  if (share >= 1) return placement;
  // Without turns, the rotation follows the shorter arc to the placement. Turns are additional rotations
  // about `axis`, which also end at the placement.
  const double angle = -2 * 3.14159265358979323846 * turns * (1 - share);
  const glm::dquat to =
      glm::dot(from.rotation, placement.rotation) < 0 ? -placement.rotation : placement.rotation;
  const glm::dquat mixed = glm::normalize((1 - share) * from.rotation + share * to);
  const glm::dquat spin(deterministic_cos(0.5 * angle), deterministic_sin(0.5 * angle) * axis);
  return {from.position_world + share * (placement.position_world - from.position_world),
          glm::normalize(mixed * spin)};
}

std::string to_bytes(const Piece& piece) {
  std::string out;
  const haptics::Material& m = piece.material;
  for (const double value :
       {m.stiffness, m.damping, m.static_friction, m.dynamic_friction, m.viscosity, m.pop_force, m.pop_rearm})
    put(out, value);
  put(out, static_cast<std::uint32_t>(piece.tree->vertices().size()));
  put(out, static_cast<std::uint32_t>(piece.tree->triangles().size()));
  for (const glm::dvec3& v : piece.tree->vertices())
    put(out, glm::vec3(v));  // lossless: the vertices were floats
  for (const std::uint32_t corner : piece.tree->triangles()) put(out, corner);
  return out;
}

std::shared_ptr<const Piece> piece_from_bytes(std::string_view in) {
  volume::PartSurface surface;
  haptics::Material m;
  bool is_good = true;
  for (double* value : {&m.stiffness, &m.damping, &m.static_friction, &m.dynamic_friction, &m.viscosity,
                        &m.pop_force, &m.pop_rearm})
    is_good = is_good && get(in, *value);
  std::uint32_t vertices = 0, corners = 0;
  is_good = is_good && !haptics::check_material(m) && get(in, vertices) && get(in, corners);
  if (!is_good || vertices == 0 || corners == 0 || corners % 3 != 0 ||
      in.size() != sizeof(glm::vec3) * std::size_t{vertices} + sizeof(corners) * std::size_t{corners})
    return nullptr;
  surface.vertices_world.resize(vertices);
  surface.triangles.resize(corners);
  for (glm::vec3& v : surface.vertices_world) {
    get(in, v);
    for (int a = 0; a < 3; ++a) is_good = is_good && std::abs(v[a]) < 1e6f;
  }
  for (std::uint32_t& corner : surface.triangles) is_good = get(in, corner) && corner < vertices && is_good;
  if (!is_good) return nullptr;
  auto piece = std::make_shared<const Piece>(surface, m);
  return piece->mm3 > 0 ? piece : nullptr;
}

Status check_shape_of_pieces(const haptics::TouchScene& anatomy, std::int64_t item, const char* field) {
  const auto shapes = haptics::base_shapes(anatomy);
  if (item < 0 || item >= static_cast<std::int64_t>(shapes.size()))
    return Error{.what = "unknown shape to detach pieces from",
                 .where = field,
                 .found = std::to_string(item),
                 .expected = shapes.empty() ? "a scene with a shape of a scan"
                                            : "0 to " + std::to_string(shapes.size() - 1),
                 .remedy = "choose the index of a shape of the anatomy"};
  // A smoothed shape has smooth walls, but the surface of its piece would have voxel steps: a tool that rests
  // on the wall would sink into a step.
  if (const haptics::TouchItem& shape = shapes[static_cast<std::size_t>(item)]; shape.soft)
    return Error{.what = "pieces of a smoothed shape cannot be detached",
                 .where = field,
                 .found = haptics::name_of(shape),
                 .expected = "a shape that is not smoothed",
                 .remedy = "choose a shape of intensities, not a label or a thresholded scan"};
  return std::nullopt;
}

std::uint64_t hash_of(const Detachment& detachment) {
  MixHash all;
  all.add(detachment.rest->content_hash());
  all.add(std::uint64_t{detachment.piece_count});
  for (const auto& piece : detachment.pieces) all.add(piece->hash);
  return all.value();
}

Detachment detach_parts(const haptics::TouchItem& shape, const volume::SolidParts& parts,
                        std::span<const PartFate> fates, std::vector<volume::Field> solids,
                        const std::shared_ptr<const volume::Version>& version) {
  Detachment result;
  result.box = k_no_voxels;
  result.piece_count = static_cast<std::size_t>(std::count(fates.begin(), fates.end(), PartFate::piece));
  result.rest = version;
  if (result.piece_count > haptics::TouchScene::k_max_movers) return result;
  volume::RemovalEditor editor(version, std::move(solids));
  std::vector<std::uint8_t> is_removed(fates.size(), 0);
  for (std::size_t p = 0; p < is_removed.size(); ++p) {
    if (fates[p] == PartFate::stays) continue;
    is_removed[p] = 1;
    const volume::RemovalReport report = editor.remove_parts(parts, is_removed, parts.parts()[p].box);
    is_removed[p] = 0;
    result.box = union_of(result.box, report.box);
    if (fates[p] == PartFate::piece) {
      const auto surface =
          volume::part_surface(shape.field, *shape.bits, version, parts, static_cast<int>(p));
      result.pieces.push_back(std::make_shared<const Piece>(surface, shape.material));
    } else {
      ++result.debris;
      result.debris_mm3 += version->mm3_of(report.removed_units);
    }
  }
  result.rest = editor.freeze();
  return result;
}

Detachment detach_free_pieces(const haptics::TouchItem& shape, const FreePieces& request,
                              std::vector<volume::Field> solids,
                              const std::shared_ptr<const volume::Version>& version) {
  const volume::SolidParts parts(shape.field, *shape.bits, *version);
  const double sample_mm3 = version->lattice().frame().voxel_mm3();
  std::vector<PartFate> fates;
  for (const volume::SolidParts::Part& part : parts.parts())
    fates.push_back(!part.is_detached                                                    ? PartFate::stays
                    : static_cast<double>(part.samples) * sample_mm3 >= request.smallest ? PartFate::piece
                                                                                         : PartFate::debris);
  return detach_parts(shape, parts, fates, std::move(solids), version);
}

}  // namespace trephine::sim
