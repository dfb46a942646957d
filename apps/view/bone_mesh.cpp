#include "apps/view/bone_mesh.h"

#include <algorithm>
#include <glm/common.hpp>
#include <vtkCellArray.h>
#include <vtkFloatArray.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkPoints.h>
#include <vtkShaderProperty.h>
#include <vtkTypeInt64Array.h>
#include <vtkUnsignedCharArray.h>

namespace trephine::view {

using glm::dvec3;

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

void light_reversed_triangles(vtkActor* actor) {
  constexpr const char* k_reversal = "if (gl_FrontFacing == false) { normalVCVSOutput = -normalVCVSOutput; }";
  constexpr const char* k_reversal_away =
      "if (gl_FrontFacing == false && normalVCVSOutput.z < 0.0) { normalVCVSOutput = -normalVCVSOutput; }";
  constexpr bool k_is_before_vtk = false, k_is_for_all = true;
  actor->GetShaderProperty()->AddFragmentShaderReplacement(k_reversal, k_is_before_vtk, k_reversal_away,
                                                           k_is_for_all);
}

}  // namespace trephine::view
