#include "apps/view/bone_mesh.h"

#include <algorithm>
#include <glm/common.hpp>
#include <vtkCellArray.h>
#include <vtkFloatArray.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkPoints.h>
#include <vtkTypeInt64Array.h>
#include <vtkUnsignedCharArray.h>

namespace trephine::view {

using glm::dvec3;

namespace {

/// Colours that any colour vision distinguishes: bone and cut also differ in lightness.
constexpr Tint k_tints[] = {{{0.84, 0.71, 0.55}, {0.95, 0.90, 0.80}, {0.55, 0.20, 0.15}, {0.86, 0.60, 0.48}},
                            {{0.35, 0.55, 0.75}, {0.55, 0.75, 0.92}, {0.16, 0.30, 0.50}, {0.30, 0.48, 0.70}},
                            {{0.80, 0.62, 0.20}, {0.95, 0.80, 0.35}, {0.50, 0.36, 0.05}, {0.70, 0.52, 0.12}},
                            {{0.35, 0.62, 0.48}, {0.55, 0.80, 0.66}, {0.12, 0.36, 0.26}, {0.25, 0.52, 0.40}}};

dvec3 colour_of(const Tint& tint, const VertexMatter& matter) {
  const auto density = static_cast<double>(matter.density);
  return glm::mix(glm::mix(tint.spongy, tint.compact, density),
                  glm::mix(tint.cut_spongy, tint.cut_compact, density),
                  static_cast<double>(matter.freshness));
}

}  // namespace

Tint tint_of(std::size_t shape, const std::optional<dvec3>& colour) {
  if (!colour) return k_tints[shape % std::size(k_tints)];
  return {0.85 * *colour, glm::mix(*colour, dvec3(1), 0.2), 0.45 * *colour, 0.7 * *colour};
}

vtkSmartPointer<vtkPolyData> to_poly_data(const std::vector<const DrawMesh*>& meshes, const Tint& tint) {
  std::size_t vertices = 0, triangles = 0;
  for (const DrawMesh* m : meshes) vertices += m->vertices.size(), triangles += m->triangles.size() / 3;
  vtkNew<vtkFloatArray> points, normals;
  vtkNew<vtkUnsignedCharArray> colors;
  for (vtkDataArray* a : std::initializer_list<vtkDataArray*>{points, normals, colors}) {
    a->SetNumberOfComponents(3);
    a->SetNumberOfTuples(static_cast<vtkIdType>(vertices));
  }
  colors->SetName("Colors");
  normals->SetName("Normals");
  vtkNew<vtkTypeInt64Array> offsets, connectivity;
  offsets->SetNumberOfValues(static_cast<vtkIdType>(triangles + 1));
  connectivity->SetNumberOfValues(static_cast<vtkIdType>(3 * triangles));
  float *p = points->GetPointer(0), *n = normals->GetPointer(0);
  unsigned char* c = colors->GetPointer(0);
  vtkTypeInt64* index = connectivity->GetPointer(0);
  std::size_t first = 0;
  for (const DrawMesh* m : meshes) {
    for (std::size_t i = 0; i < m->vertices.size(); ++i) {
      const Tint vertex_tint = m->colours.empty() ? tint : tint_of(0, dvec3(m->colours[i]));
      // Ambient light, reduced by occlusion.
      const double light = 0.28 + 0.72 * static_cast<double>(m->openness[i]);
      const dvec3 color = light * colour_of(vertex_tint, {m->freshness[i], m->density[i]});
      for (int a = 0; a < 3; ++a) {
        *p++ = m->vertices[i][a];
        *n++ = m->normals[i][a];
        *c++ = static_cast<unsigned char>(255 * std::clamp(color[a], 0.0, 1.0));
      }
    }
    for (const std::uint32_t v : m->triangles) *index++ = static_cast<vtkTypeInt64>(first + v);
    first += m->vertices.size();
  }
  for (std::size_t t = 0; t <= triangles; ++t)
    offsets->SetValue(static_cast<vtkIdType>(t), static_cast<vtkTypeInt64>(3 * t));
  vtkNew<vtkPoints> vtk_points;
  vtk_points->SetData(points);
  vtkNew<vtkCellArray> cells;
  cells->SetData(offsets, connectivity);
  auto data = vtkSmartPointer<vtkPolyData>::New();
  data->SetPoints(vtk_points);
  data->SetPolys(cells);
  data->GetPointData()->SetNormals(normals);
  data->GetPointData()->SetScalars(colors);
  return data;
}

dvec3 bone_colour(const VertexMatter& matter) { return colour_of(k_tints[0], matter); }

}  // namespace trephine::view
