#include "apps/view/structure_layer.h"

#include <algorithm>
#include <array>
#include <map>
#include <utility>
#include <vtkActor.h>
#include <vtkCallbackCommand.h>
#include <vtkCamera.h>
#include <vtkCellArray.h>
#include <vtkFloatArray.h>
#include <vtkImageData.h>
#include <vtkMatrix4x4.h>
#include <vtkNew.h>
#include <vtkPlane.h>
#include <vtkPointData.h>
#include <vtkPoints.h>
#include <vtkPolyData.h>
#include <vtkPolyDataMapper.h>
#include <vtkProperty.h>
#include <vtkRenderWindow.h>
#include <vtkRenderer.h>
#include <vtkShaderProperty.h>
#include <vtkSmartPointer.h>
#include <vtkTexture.h>

#include "apps/view/bone_mesh.h"
#include "apps/view/picture_cache.h"

namespace trephine::view {

namespace {
constexpr int k_peels = 6;  // largest number of translucent surfaces, one behind the other, that are sorted
}  // namespace

struct StructureLayer::Parts {
  struct Shown {
    vtkSmartPointer<vtkActor> actor;
    std::size_t triangles = 0;
    double opacity = 1;
  };
  vtkRenderWindow* window;
  vtkRenderer* renderer;
  std::map<int, Shown> structures;
  vtkNew<vtkPlane> clip;
  bool is_clipped = false;
  vtkSmartPointer<vtkActor> cap;  ///< null before the first cut face
  PictureCache kept;
  std::array<double, 20> kept_view{};  ///< camera, clipping range and size of the kept picture
  bool is_active = false, is_stale = true;
  std::size_t drawn_count = 0;
  unsigned long observer = 0;  ///< of the window

  Shown& at(int id);
  void apply(const Shown& shown);
  std::array<double, 20> view() const;
  void begin_frame();
  void end_drawing();
};

StructureLayer::Parts::Shown& StructureLayer::Parts::at(int id) {
  Shown& shown = structures[id];
  if (shown.actor) return shown;
  shown.actor = vtkSmartPointer<vtkActor>::New();
  shown.actor->GetProperty()->SetSpecular(0.2);
  shown.actor->GetProperty()->SetSpecularPower(25);
  shown.actor->GetProperty()->SetAmbient(0.12);
  light_reversed_triangles(shown.actor);
  shown.actor->PickableOff();
  shown.actor->VisibilityOff();
  renderer->AddActor(shown.actor);
  return shown;
}

void StructureLayer::Parts::apply(const Shown& shown) {
  shown.actor->SetVisibility(shown.triangles > 0 && shown.opacity > 0);
  shown.actor->GetProperty()->SetOpacity(shown.opacity);
  // The far side of a translucent structure would be visible as a second surface.
  shown.actor->GetProperty()->SetBackfaceCulling(shown.opacity < 1);
  const bool is_any_translucent = std::any_of(structures.begin(), structures.end(), [](const auto& entry) {
    return entry.second.opacity > 0 && entry.second.opacity < 1;
  });
  renderer->SetUseDepthPeeling(is_any_translucent);
  is_stale = true;
}

std::array<double, 20> StructureLayer::Parts::view() const {
  std::array<double, 20> values{};
  vtkCamera* camera = renderer->GetActiveCamera();
  std::copy_n(camera->GetModelViewTransformMatrix()->GetData(), 16, values.begin());
  values[15] = camera->GetViewAngle();
  camera->GetClippingRange(values[16], values[17]);
  values[18] = window->GetSize()[0], values[19] = window->GetSize()[1];
  return values;
}

/// Decides whether the structures are drawn in this frame.
void StructureLayer::Parts::begin_frame() {
  renderer->SetDraw(is_active && (is_stale || !kept.is_filled() || view() != kept_view));
}

void StructureLayer::Parts::end_drawing() {
  kept_view = view();
  is_stale = false;
  ++drawn_count;
  kept.save(window->GetSize()[0], window->GetSize()[1]);
}

StructureLayer::StructureLayer(vtkRenderWindow* window, vtkRenderer* renderer)
    : parts_(std::make_unique<Parts>()) {
  Parts& p = *parts_;
  p.window = window, p.renderer = renderer;
  renderer->DrawOff();
  renderer->SetMaximumNumberOfPeels(k_peels);
  renderer->SetOcclusionRatio(0);
  vtkNew<vtkCallbackCommand> begin, end;
  begin->SetClientData(&p), end->SetClientData(&p);
  begin->SetCallback(
      [](vtkObject*, unsigned long, void* parts, void*) { static_cast<Parts*>(parts)->begin_frame(); });
  end->SetCallback(
      [](vtkObject*, unsigned long, void* parts, void*) { static_cast<Parts*>(parts)->end_drawing(); });
  // Low priority: the bone layer sets the camera's clipping range first.
  constexpr float k_after = -2;
  p.observer = window->AddObserver(vtkCommand::StartEvent, begin, k_after);
  renderer->AddObserver(vtkCommand::EndEvent, end);
}

StructureLayer::~StructureLayer() {
  parts_->window->RemoveObserver(parts_->observer);
  if (!parts_->kept.is_filled()) return;
  parts_->window->MakeCurrent();
  if (parts_->window->IsCurrent()) parts_->kept.release();
}

void StructureLayer::show(int id, const DrawMesh& mesh, const glm::dvec3& colour) {
  Parts::Shown& shown = parts_->at(id);
  shown.triangles = mesh.triangles.size() / 3;
  vtkNew<vtkPolyDataMapper> mapper;
  mapper->SetInputData(to_poly_data({&mesh}, {colour, colour, colour, colour}));
  if (parts_->is_clipped) mapper->AddClippingPlane(parts_->clip);
  shown.actor->SetMapper(mapper);
  parts_->apply(shown);
}

void StructureLayer::set_opacity(int id, double opacity) {
  Parts::Shown& shown = parts_->at(id);
  if (shown.opacity == opacity) return;
  shown.opacity = opacity;
  parts_->apply(shown);
}

void StructureLayer::set_clip(const glm::dvec3& origin, const glm::dvec3& normal) {
  Parts& p = *parts_;
  const bool is_clipped = normal != glm::dvec3(0);
  if (is_clipped) {
    p.clip->SetOrigin(origin.x, origin.y, origin.z);
    p.clip->SetNormal(normal.x, normal.y, normal.z);
  }
  p.is_stale = true;
  if (std::exchange(p.is_clipped, is_clipped) == is_clipped) return;
  for (const auto& [id, shown] : p.structures) {
    vtkMapper* mapper = shown.actor->GetMapper();
    if (mapper == nullptr) continue;
    mapper->RemoveAllClippingPlanes();
    if (is_clipped) mapper->AddClippingPlane(p.clip);
  }
}

void StructureLayer::show_cap(const CapImage& image) {
  Parts& p = *parts_;
  p.is_stale = true;
  if (image.columns == 0) {
    if (p.cap) p.cap->VisibilityOff();
    return;
  }
  if (!p.cap) {
    p.cap = vtkSmartPointer<vtkActor>::New();
    p.cap->GetProperty()->SetAmbient(0.45);
    p.cap->GetProperty()->SetDiffuse(0.6);
    // Pixels without matter are not drawn. Between pixels alpha is interpolated: draw from 0.5 on.
    p.cap->GetShaderProperty()->AddFragmentShaderReplacement("//VTK::TCoord::Impl", true,
                                                             "//VTK::TCoord::Impl\n"
                                                             "  if (gl_FragData[0].a < 0.5) discard;\n"
                                                             "  gl_FragData[0].a = 1.0;\n",
                                                             false);
    p.cap->ForceOpaqueOn();
    p.cap->PickableOff();
    p.renderer->AddActor(p.cap);
  }
  vtkNew<vtkImageData> data;
  data->SetDimensions(image.columns, image.rows, 1);
  data->AllocateScalars(VTK_UNSIGNED_CHAR, 4);
  std::copy_n(image.pixels.data()->data(), 4 * image.pixels.size(),
              static_cast<std::uint8_t*>(data->GetScalarPointer()));
  vtkNew<vtkTexture> texture;
  texture->SetInputData(data);
  texture->InterpolateOn();
  texture->MipmapOn();
  vtkNew<vtkPoints> points;
  vtkNew<vtkFloatArray> coordinates, normals;
  coordinates->SetNumberOfComponents(2);
  normals->SetNumberOfComponents(3);
  for (const auto& [right, up] : {std::pair{0, 0}, {1, 0}, {1, 1}, {0, 1}}) {
    const glm::dvec3 at =
        image.corner_world + double(right) * image.right_world + double(up) * image.up_world;
    points->InsertNextPoint(at.x, at.y, at.z);
    coordinates->InsertNextTuple2(right, up);
    normals->InsertNextTuple3(image.normal_world.x, image.normal_world.y, image.normal_world.z);
  }
  vtkNew<vtkPolyData> face;
  vtkNew<vtkCellArray> cells;
  const vtkIdType corners[] = {0, 1, 2, 3};
  cells->InsertNextCell(4, corners);
  face->SetPoints(points);
  face->SetPolys(cells);
  face->GetPointData()->SetTCoords(coordinates);
  face->GetPointData()->SetNormals(normals);
  vtkNew<vtkPolyDataMapper> mapper;
  mapper->SetInputData(face);
  p.cap->SetMapper(mapper);
  p.cap->SetTexture(texture);
  p.cap->VisibilityOn();
}

void StructureLayer::set_active(bool is_active) {
  if (std::exchange(parts_->is_active, is_active) == is_active) return;
  parts_->is_stale = true;
  if (!is_active) parts_->renderer->DrawOff();
}

bool StructureLayer::is_active() const noexcept { return parts_->is_active; }
void StructureLayer::restore() const { parts_->kept.restore(); }
std::size_t StructureLayer::drawn_count() const noexcept { return parts_->drawn_count; }

std::size_t StructureLayer::triangle_count() const noexcept {
  std::size_t count = 0;
  for (const auto& [id, shown] : parts_->structures) count += shown.triangles;
  return count;
}

}  // namespace trephine::view
