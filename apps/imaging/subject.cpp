#include "apps/imaging/subject.h"

#include "apps/workbench/text.h"
#include "volume/surface/surface_facts.h"

namespace trephine::imaging {

using workbench::format_text;

Subject subject_of(const workbench::Moment& moment) {
  Subject subject{moment.scan, moment.version, moment.shape, {}, moment.objects, {}};
  subject.structures = moment.forbidden;
  subject.plan = std::make_shared<const volume::SurgicalPlan>(moment.plan);
  return subject;
}

Status check_closed(const Object& object) {
  const volume::SurfaceFacts facts = volume::facts_of(object.tree->vertices(), object.tree->triangles());
  if (facts.open_edges + facts.misoriented_edges > 0)
    return Error{.what = "a model is not a closed surface",
                 .where = object.name,
                 .found = format_text("%zu open edges, %zu between triangles that face opposite sides",
                                      facts.open_edges, facts.misoriented_edges),
                 .expected = "a closed surface with all triangles facing outward",
                 .remedy = "close the surface and turn these triangles in a mesh editor"};
  if (facts.volume > 0) return std::nullopt;
  return Error{.what = "the triangles of the model face inward",
               .where = object.name,
               .found = format_text("%.0f mm³ within its surface", facts.volume),
               .expected = "triangles that are counter-clockwise seen from outside",
               .remedy = "flip its triangles in a mesh editor"};
}

Result<cross_section::Cut> cut_of(const volume::ImagePlane& plane, const Object& object) {
  if (Status error = check_closed(object)) return *error;
  cross_section::SectionMesh mesh;
  for (const glm::dvec3& v : object.tree->vertices())
    mesh.vertices_world.push_back(object.placement.world_from_local(v));
  mesh.triangles = object.tree->triangles();
  auto cut = cross_section::cut_mesh(plane, mesh);
  if (cut) return cut;
  Error error = cut.error();
  error.where = object.name;
  return error;
}

}  // namespace trephine::imaging
