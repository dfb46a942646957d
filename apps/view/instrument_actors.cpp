#include "apps/view/instrument_actors.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/gtc/quaternion.hpp>
#include <utility>
#include <vtkCellArray.h>
#include <vtkMatrix4x4.h>
#include <vtkNew.h>
#include <vtkPoints.h>
#include <vtkPolyDataNormals.h>
#include <vtkProperty.h>

namespace trephine::view {

using glm::dvec3;

namespace {

/// Sets the matrix of an actor only if it differs, so that no unnecessary frame is drawn.
void set_matrix(vtkActor* actor, vtkMatrix4x4* matrix) {
  const vtkMatrix4x4* before = actor->GetUserMatrix();
  if (before == nullptr || !std::equal(before->GetData(), before->GetData() + 16, matrix->GetData()))
    actor->SetUserMatrix(matrix);
}

void place(vtkActor* actor, const dvec3& origin, const dvec3& x, const dvec3& y, const dvec3& z) {
  vtkNew<vtkMatrix4x4> m;
  for (int row = 0; row < 3; ++row) {
    m->SetElement(row, 0, x[row]);
    m->SetElement(row, 1, y[row]);
    m->SetElement(row, 2, z[row]);
    m->SetElement(row, 3, origin[row]);
  }
  set_matrix(actor, m);
}
/// Returns a surface with normals of its own at edges of more than 40 degrees.
vtkSmartPointer<vtkPolyData> with_normals(vtkPolyData* data) {
  vtkNew<vtkPolyDataNormals> normals;
  normals->SetInputData(data);
  normals->SetFeatureAngle(40);
  normals->ConsistencyOff();
  normals->Update();
  return normals->GetOutput();
}

/// Returns two unit vectors perpendicular to a direction.
std::pair<dvec3, dvec3> perpendiculars(const dvec3& direction) {
  const dvec3 axis = std::abs(direction.z) < 0.9 ? dvec3(0, 0, 1) : dvec3(0, 1, 0);
  const dvec3 v = glm::normalize(glm::cross(axis, direction));
  return {v, glm::cross(direction, v)};
}

}  // namespace

vtkSmartPointer<vtkPolyData> make_revolution(const std::vector<glm::dvec2>& profile, bool is_fluted) {
  constexpr int k_sides = 96, k_flutes = 8;
  constexpr double k_deep = 0.14;  // depth of a flute as a share of the radius
  double widest = 1e-9;
  for (const glm::dvec2& p : profile) widest = std::max(widest, p.y);
  vtkNew<vtkPoints> points;
  vtkNew<vtkCellArray> faces;
  for (const glm::dvec2& p : profile)
    for (int i = 0; i < k_sides; ++i) {
      const double a = 2 * 3.14159265358979 * i / k_sides;
      const double wave = 0.5 - 0.5 * std::cos(k_flutes * (a - 0.5 * p.x / widest));
      const double r = p.y * (is_fluted ? 1 - k_deep * std::pow(wave, 3) : 1);
      points->InsertNextPoint(r * std::cos(a), r * std::sin(a), p.x);
    }
  for (std::size_t row = 0; row + 1 < profile.size(); ++row)
    for (int i = 0; i < k_sides; ++i) {
      const auto low = static_cast<vtkIdType>(row) * k_sides, high = low + k_sides;
      const vtkIdType next = (i + 1) % k_sides;
      const vtkIdType face[4] = {low + i, low + next, high + next, high + i};  // outward
      faces->InsertNextCell(4, face);
    }
  auto data = vtkSmartPointer<vtkPolyData>::New();
  data->SetPoints(points);
  data->SetPolys(faces);
  return with_normals(data);
}

vtkSmartPointer<vtkPolyData> make_mesh(const haptics::MeshTree& tree) {
  vtkNew<vtkPoints> points;
  vtkNew<vtkCellArray> faces;
  for (const dvec3& p : tree.vertices()) points->InsertNextPoint(p.x, p.y, p.z);
  const std::vector<std::uint32_t>& corners = tree.triangles();
  for (std::size_t t = 0; t + 2 < corners.size(); t += 3) {
    const vtkIdType face[3] = {corners[t], corners[t + 1], corners[t + 2]};
    faces->InsertNextCell(3, face);
  }
  vtkNew<vtkPolyData> data;
  data->SetPoints(points);
  data->SetPolys(faces);
  return with_normals(data);
}

void place(vtkActor* actor, const haptics::Placement& placement) {
  const glm::dmat3 axes = glm::mat3_cast(placement.rotation);
  place(actor, placement.position_world, axes[0], axes[1], axes[2]);
}
void place(vtkActor* actor, const dvec3& origin, dvec3 direction, double length, double width) {
  direction = glm::length(direction) > 0 ? glm::normalize(direction) : dvec3(1, 0, 0);
  const auto [v, w] = perpendiculars(direction);
  place(actor, origin, length * direction, width * v, width * w);
}
void place(vtkActor* actor, const dvec3& origin, const dvec3& axis) {
  const auto [v, w] = perpendiculars(axis);
  place(actor, origin, v, w, axis);
}

vtkSmartPointer<vtkActor> make_actor(vtkPolyDataMapper* mapper, const dvec3& colour) {
  mapper->ScalarVisibilityOff();
  auto actor = vtkSmartPointer<vtkActor>::New();
  actor->SetMapper(mapper);
  actor->GetProperty()->SetColor(colour.r, colour.g, colour.b);
  actor->GetProperty()->SetSpecular(0.4);
  actor->GetProperty()->SetSpecularPower(30);
  return actor;
}
vtkSmartPointer<vtkActor> make_actor(vtkAlgorithmOutput* source, double r, double g, double b) {
  vtkNew<vtkPolyDataMapper> mapper;
  mapper->SetInputConnection(source);
  return make_actor(mapper, {r, g, b});
}

}  // namespace trephine::view
