#include "data-tools/meshes/polygon_builder.h"

#include <glm/geometric.hpp>
#include <vtkIdList.h>
#include <vtkNew.h>
#include <vtkPoints.h>
#include <vtkPolygon.h>

#include "data-tools/files/words.h"

namespace trephine::data_tools {

namespace {

/// Returns true if every corner of the outline is convex. A fan then covers exactly the polygon, unless the
/// outline turns around more than once.
bool is_convex(const std::vector<glm::dvec3>& vertices, std::span<const std::uint32_t> corners) {
  const std::size_t n = corners.size();
  const auto at = [&](std::size_t i) -> const glm::dvec3& { return vertices[corners[i % n]]; };
  glm::dvec3 normal(0);  // Newell's normal: its length is twice the area
  for (std::size_t i = 0; i < n; ++i) normal += glm::cross(at(i) - at(0), at(i + 1) - at(0));
  for (std::size_t i = 0; i < n; ++i)
    if (glm::dot(glm::cross(at(i + 1) - at(i), at(i + 2) - at(i + 1)), normal) < 0) return false;
  return true;
}

}  // namespace

void PolygonBuilder::add_fan(std::span<const std::uint32_t> corners) {
  for (std::size_t k = 2; k < corners.size(); ++k) add_triangle(corners[0], corners[k - 1], corners[k]);
}

void PolygonBuilder::add(std::span<const std::uint32_t> corners) {
  if (corners.size() < 3) {
    ++short_count_;
    return;
  }
  if (corners.size() == 3 || is_convex(*vertices_, corners)) return add_fan(corners);
  vtkNew<vtkPolygon> polygon;
  vtkNew<vtkIdList> triangles;
  const auto n = static_cast<vtkIdType>(corners.size());
  polygon->GetPoints()->SetDataTypeToDouble();
  polygon->GetPoints()->SetNumberOfPoints(n);
  polygon->GetPointIds()->SetNumberOfIds(n);
  for (vtkIdType i = 0; i < n; ++i) {
    const glm::dvec3& p = (*vertices_)[corners[static_cast<std::size_t>(i)]];
    polygon->GetPoints()->SetPoint(i, p.x, p.y, p.z);
    polygon->GetPointIds()->SetId(i, i);
  }
  if (polygon->Triangulate(triangles) == 0) {
    ++crossed_count_;
    return add_fan(corners);
  }
  for (vtkIdType i = 0; i + 2 < triangles->GetNumberOfIds(); i += 3)
    add_triangle(corners[static_cast<std::size_t>(triangles->GetId(i))],
                 corners[static_cast<std::size_t>(triangles->GetId(i + 1))],
                 corners[static_cast<std::size_t>(triangles->GetId(i + 2))]);
}

void PolygonBuilder::add_strip(std::span<const std::uint32_t> corners) {
  for (std::size_t k = 2; k < corners.size(); ++k) {
    const bool is_odd = k % 2 != 0;
    add_triangle(corners[k - (is_odd ? 1 : 2)], corners[k - (is_odd ? 2 : 1)], corners[k]);
  }
}

std::vector<std::string> PolygonBuilder::notices() const {
  std::vector<std::string> sentences;
  if (short_count_ > 0)
    sentences.push_back(counted(short_count_, "face") + " with fewer than three corners skipped");
  if (crossed_count_ > 0)
    sentences.push_back("outlines that intersect themselves: " + counted(crossed_count_, "face") +
                        ", which may cover too much");
  return sentences;
}

}  // namespace trephine::data_tools
