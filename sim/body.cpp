#include "sim/body.h"

#include <cmath>

#include "sim/work.h"
#include "volume/bytes.h"
#include "volume/removal.h"

namespace trephine::sim {

using volume::get;
using volume::put;

Piece::Piece(const volume::PartSurface& surface, const haptics::Material& felt, double size_mm3)
    : material(felt), mm3(size_mm3) {
  std::vector<glm::dvec3> vertices(surface.vertices_world.begin(), surface.vertices_world.end());
  for (const glm::dvec3& v : vertices) middle_world += v / static_cast<double>(vertices.size());
  tree = std::make_shared<const haptics::MeshTree>(std::move(vertices), surface.triangles);
}

std::string to_bytes(const Piece& piece) {
  std::string out;
  put(out, piece.mm3);
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
  double mm3 = 0;
  bool is_good = get(in, mm3) && mm3 >= 0 && mm3 < 1e12;
  for (double* value : {&m.stiffness, &m.damping, &m.static_friction, &m.dynamic_friction, &m.viscosity,
                        &m.pop_force, &m.pop_rearm})
    is_good = is_good && get(in, *value);
  std::uint32_t vertices = 0, corners = 0;
  is_good = is_good && !haptics::check_material(m) && get(in, vertices) && get(in, corners);
  if (!is_good || corners % 3 != 0 ||
      in.size() != sizeof(glm::vec3) * std::size_t{vertices} + sizeof(corners) * std::size_t{corners})
    return nullptr;
  surface.vertices_world.resize(vertices);
  surface.triangles.resize(corners);
  for (glm::vec3& v : surface.vertices_world) {
    get(in, v);
    for (int a = 0; a < 3; ++a) is_good = is_good && std::abs(v[a]) < 1e6f;
  }
  for (std::uint32_t& corner : surface.triangles) is_good = get(in, corner) && corner < vertices && is_good;
  return is_good ? std::make_shared<const Piece>(surface, m, mm3) : nullptr;
}

CameOff come_off(const haptics::TouchScene& scene, const FreePieces& wish,
                 const std::shared_ptr<const volume::Version>& version) {
  const haptics::TouchItem& shape = scene.items[static_cast<std::size_t>(wish.item)];
  std::vector<volume::Field> solids;
  for (const haptics::TouchItem& each : haptics::base_shapes(scene)) solids.push_back(each.field);
  const volume::SolidParts parts(shape.field, *shape.bits, *version);
  volume::RemovalEditor editor(version, std::move(solids));
  CameOff all{nullptr, {}, k_no_voxels};
  std::vector<std::uint8_t> goes(parts.parts().size(), 0);
  for (std::size_t p = 0; p < goes.size(); ++p) {
    const volume::SolidParts::Part& part = parts.parts()[p];
    if (!part.is_off) continue;
    const bool is_piece =
        static_cast<double>(part.samples) * version->lattice().frame().voxel_mm3() >= wish.smallest;
    goes[p] = 1;
    const volume::RemovalReport report = editor.take_out(parts, goes, part.box);
    goes[p] = 0;
    all.box = united(all.box, report.box);
    const double mm3 = version->mm3_of(report.removed_units);
    if (is_piece) {
      const auto surface =
          volume::part_surface(shape.field, *shape.bits, version, parts, static_cast<int>(p));
      all.pieces.push_back(std::make_shared<const Piece>(surface, shape.material, mm3));
    } else {
      ++all.debris;
      all.debris_mm3 += mm3;
    }
  }
  all.rest = editor.freeze();
  return all;
}

}  // namespace trephine::sim
