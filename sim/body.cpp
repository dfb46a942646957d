#include "sim/body.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

#include "sim/event.h"
#include "sim/work.h"
#include "volume/bytes.h"
#include "volume/removal.h"

namespace trephine::sim {

using volume::get;
using volume::put;

Piece::Piece(const volume::PartSurface& surface, const haptics::Material& surface_material)
    : material(surface_material) {
  std::vector<glm::dvec3> vertices(surface.vertices_world.begin(), surface.vertices_world.end());
  for (const glm::dvec3& v : vertices) middle_world += v / static_cast<double>(vertices.size());
  for (std::size_t t = 0; t < surface.triangles.size(); t += 3) {
    const auto corner = [&](std::size_t k) { return vertices[surface.triangles[t + k]] - middle_world; };
    mm3 += glm::dot(corner(0), glm::cross(corner(1), corner(2))) / 6;
  }
  tree = std::make_shared<const haptics::MeshTree>(std::move(vertices), surface.triangles);
  volume::MixHash all;
  add_bytes(all, to_bytes(*this));
  hash = all.value();
}

std::string to_bytes(const Piece& piece) {
  std::string out;
  const haptics::Material& m = piece.material;
  for (const double value :
       {m.stiffness, m.damping, m.static_friction, m.dynamic_friction, m.viscosity, m.pop_force, m.pop_rearm})
    put(out, value);
  put(out, static_cast<std::uint32_t>(piece.tree->vertices().size()));
  put(out, static_cast<std::uint32_t>(piece.tree->triangles().size()));
  for (const glm::dvec3& v : piece.tree->vertices()) put(out, glm::vec3(v));  // of which they were made
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

volume::Status check_shape_of_pieces(const haptics::TouchScene& anatomy, std::int64_t item,
                                     const char* field) {
  const auto shapes = haptics::base_shapes(anatomy);
  if (item < 0 || item >= static_cast<std::int64_t>(shapes.size()))
    return volume::Error{"there is no such shape to free pieces of", field, std::to_string(item),
                         "0 to " + std::to_string(shapes.size() - 1), ""};
  // Its touch is of smooth walls, and the piece's would be of steps: who rests there would fall in.
  if (const haptics::TouchItem& shape = shapes[static_cast<std::size_t>(item)]; shape.soft)
    return volume::Error{"pieces of a shape that was made smooth cannot come off", field,
                         haptics::name_of(shape), "a shape between intensities", ""};
  return std::nullopt;
}

std::uint64_t hash_of(const CameOff& off) {
  volume::MixHash all;
  all.add(off.rest->content_hash());
  all.add(std::uint64_t{off.piece_count});
  for (const auto& piece : off.pieces) all.add(piece->hash);
  return all.value();
}

CameOff take_off(const haptics::TouchItem& shape, const volume::SolidParts& parts,
                 std::span<const PartFate> fates, std::vector<volume::Field> solids,
                 const std::shared_ptr<const volume::Version>& version) {
  CameOff all;
  all.box = k_no_voxels;
  all.piece_count = static_cast<std::size_t>(std::count(fates.begin(), fates.end(), PartFate::piece));
  all.rest = version;
  if (all.piece_count > haptics::TouchScene::k_max_movers) return all;
  volume::RemovalEditor editor(version, std::move(solids));
  std::vector<std::uint8_t> goes(fates.size(), 0);
  for (std::size_t p = 0; p < goes.size(); ++p) {
    if (fates[p] == PartFate::stays) continue;
    goes[p] = 1;
    const volume::RemovalReport report = editor.take_out(parts, goes, parts.parts()[p].box);
    goes[p] = 0;
    all.box = united(all.box, report.box);
    if (fates[p] == PartFate::piece) {
      const auto surface =
          volume::part_surface(shape.field, *shape.bits, version, parts, static_cast<int>(p));
      all.pieces.push_back(std::make_shared<const Piece>(surface, shape.material));
    } else {
      ++all.debris;
      all.debris_mm3 += version->mm3_of(report.removed_units);
    }
  }
  all.rest = editor.freeze();
  return all;
}

CameOff come_off(const haptics::TouchItem& shape, const FreePieces& request,
                 std::vector<volume::Field> solids, const std::shared_ptr<const volume::Version>& version) {
  const volume::SolidParts parts(shape.field, *shape.bits, *version);
  const double sample_mm3 = version->lattice().frame().voxel_mm3();
  std::vector<PartFate> fates;
  for (const volume::SolidParts::Part& part : parts.parts())
    fates.push_back(!part.is_off                                                         ? PartFate::stays
                    : static_cast<double>(part.samples) * sample_mm3 >= request.smallest ? PartFate::piece
                                                                                         : PartFate::debris);
  return take_off(shape, parts, fates, std::move(solids), version);
}

}  // namespace trephine::sim
