// Pictures of bone have no holes: bone on a ray through the voxels is drawn, near and far, in the coarse
// picture of a moving view and in the full one.
#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <glm/geometric.hpp>
#include <glm/trigonometric.hpp>
#include <gtest/gtest.h>
#include <thread>
#include <vtkActor.h>
#include <vtkActorCollection.h>
#include <vtkCamera.h>
#include <vtkFloatArray.h>
#include <vtkNew.h>
#include <vtkRenderWindow.h>
#include <vtkRenderer.h>
#include <vtkShaderProperty.h>
#include <vtkUnsignedCharArray.h>

#include "apps/bench/scenes/scenes.h"
#include "apps/view/render_window.h"
#include "apps/view/viewport.h"
#include "data-tools/formats/open_volume.h"
#include "tests/data-tools/file_helpers.h"
#include "tests/whole.h"

namespace trephine::view {
namespace {

constexpr int k_width = 480, k_height = 360;

struct Picture {
  int width, height;
  std::vector<float> depth;
  std::vector<unsigned char> colours;  ///< red, green, blue
  bool is_drawn(int x, int y) const { return depth[index(x, y)] < 0.9999999f; }
  double light(int x, int y) const {
    const std::size_t i = 3 * index(x, y);
    return 0.30 * colours[i] + 0.59 * colours[i + 1] + 0.11 * colours[i + 2];
  }
  std::size_t index(int x, int y) const { return static_cast<std::size_t>(y * width + x); }
};

Picture read(vtkRenderWindow* window) {
  const int width = window->GetSize()[0], height = window->GetSize()[1];
  Picture picture{width, height, {}, {}};
  vtkNew<vtkFloatArray> depth;
  vtkNew<vtkUnsignedCharArray> colours;
  window->GetZbufferData(0, 0, width - 1, height - 1, depth);
  window->GetPixelData(0, 0, width - 1, height - 1, 0, colours);
  picture.depth.assign(depth->GetPointer(0), depth->GetPointer(0) + width * height);
  picture.colours.assign(colours->GetPointer(0), colours->GetPointer(0) + 3 * width * height);
  return picture;
}

struct Faults {
  int inside = 0;   ///< pixels well within the silhouette of the bone
  int missing = 0;  ///< pixels inside that show the background or a surface too far behind the bone
  int black = 0;    ///< pixels inside that are darker than any bone
};

/// Voxels surrounded by solid voxels: any drawn surface encloses these.
class DeepVoxels {
 public:
  explicit DeepVoxels(const haptics::TouchScene& scene)
      : frame_(scene.base->frame), size_(scene.base->size), deep_(scene.base->voxels.size()) {
    const volume::Occupancy& bits = *scene.items[0].bits;
    for (int z = 1; z + 1 < size_.z; ++z)
      for (int y = 1; y + 1 < size_.y; ++y)
        for (int x = 1; x + 1 < size_.x; ++x) {
          bool is_deep = bits.is_solid({x, y, z});
          for (int n = 0; n < 27 && is_deep; ++n)
            is_deep = bits.is_solid({x + n % 3 - 1, y + n / 3 % 3 - 1, z + n / 9 - 1});
          deep_[scene.base->index(x, y, z)] = is_deep;
        }
  }
  /// Returns the distance along the ray to the first deep voxel, mm; negative if the ray hits no deep voxel.
  /// Steps are a quarter of a voxel. A voxel that the ray only grazes is not counted, because the ray may
  /// miss the surface drawn around that voxel.
  double distance(const Ray& ray) const {
    const glm::dvec3 from = frame_.volume_from_world(ray.origin),
                     direction = frame_.vector_volume_from_world(ray.direction);
    double near = 0, far = 1e9;
    for (int a = 0; a < 3; ++a) {
      if (std::abs(direction[a]) < 1e-12) {
        if (from[a] < 0 || from[a] > size_[a] - 1) return -1;
        continue;
      }
      const double t = -from[a] / direction[a], u = (size_[a] - 1 - from[a]) / direction[a];
      near = std::max(near, std::min(t, u)), far = std::min(far, std::max(t, u));
    }
    const double step = 0.25 / glm::length(direction);
    for (double t = near; t < far; t += step) {
      const glm::dvec3 p = from + t * direction;
      const glm::ivec3 v(glm::floor(p + 0.5));
      const glm::dvec3 off = glm::abs(p - glm::dvec3(v));
      if (std::max({off.x, off.y, off.z}) > 0.35) continue;
      if (v.x < 0 || v.y < 0 || v.z < 0 || v.x >= size_.x || v.y >= size_.y || v.z >= size_.z) continue;
      if (deep_[(static_cast<std::size_t>(v.z) * size_.y + v.y) * size_.x + v.x]) return t;
    }
    return -1;
  }

 private:
  const volume::Frame& frame_;
  glm::ivec3 size_;
  std::vector<char> deep_;
};

/// Distances of the bone from the camera, in a grid of pixels.
class Silhouette {
 public:
  Silhouette(Viewport& picture, const DeepVoxels& bone)
      : rays_(k_width * k_height), bone_(k_width * k_height) {
    for (int y = 0; y < k_height; y += k_step)
      for (int x = 0; x < k_width; x += k_step) {
        const std::size_t i = index(x, y);
        rays_[i] = picture.ray_at((x + 0.5) / k_width, (y + 0.5) / k_height);
        bone_[i] = bone.distance(rays_[i]);
      }
  }
  /// Returns the largest distance of the bone (mm) in the pixels within `margin` steps of the grid; negative
  /// if one of these pixels has no bone.
  double farthest(int x, int y, int margin) const {
    double most = 0;
    for (int j = -margin; j <= margin; ++j)
      for (int i = -margin; i <= margin; ++i) {
        const int u = x + i * k_step, v = y + j * k_step;
        if (u < 0 || v < 0 || u >= k_width || v >= k_height || bone_[index(u, v)] < 0) return -1;
        most = std::max(most, bone_[index(u, v)]);
      }
    return most;
  }
  /// `slack`: mm that the surface may be behind the bone.
  Faults faults(const Picture& picture, vtkCamera* camera, int margin, double slack) const {
    double range[2];
    camera->GetClippingRange(range);
    const double* direction = camera->GetDirectionOfProjection();
    Faults f;
    for (int y = 0; y < k_height; y += k_step)
      for (int x = 0; x < k_width; x += k_step) {
        const double bone = farthest(x, y, margin);
        if (bone < 0) continue;
        const std::size_t i = index(x, y);
        const double z = static_cast<double>(picture.depth[i]);
        const double ahead = range[0] * range[1] / (range[1] - z * (range[1] - range[0]));
        const double seen =
            ahead / glm::dot(rays_[i].direction, glm::dvec3(direction[0], direction[1], direction[2]));
        ++f.inside;
        f.missing += !picture.is_drawn(x, y) || seen > bone + slack;
        f.black += picture.light(x, y) < 12;
      }
    return f;
  }

 private:
  static std::size_t index(int x, int y) { return static_cast<std::size_t>(y * k_width + x); }

  static constexpr int k_step = 2;
  std::vector<Ray> rays_;
  std::vector<double> bone_;
};

/// A live picture of a scene, and its judge.
class Subject {
 public:
  explicit Subject(const haptics::TouchScene& scene, bool is_meshed = true) : scene_(scene), bone_(scene) {
    surface_ = make_offscreen(k_width, k_height).value();
    picture_.emplace(scene, surface_->window(), true);
    picture_->request_all(haptics::uncut_version(scene));
    if (is_meshed) picture_->wait();
  }
  Viewport& picture() { return *picture_; }
  vtkRenderWindow* window() { return surface_->window(); }
  vtkCamera* camera() { return picture_->view().renderer()->GetActiveCamera(); }
  void aim_camera(char side, double nearer) {
    picture_->look_from(side);
    camera()->Dolly(nearer);
  }
  /// Judges the picture in the window. A drawn surface may be behind the bone by 0.5 voxels at full detail,
  /// by 3 voxels if it is coarse, and by 6 voxels if it is reduced.
  Faults faults(bool is_coarse, bool is_reduced = false) {
    const glm::dvec3 spacing = scene_.base->frame.spacing();
    const double voxel = std::max({spacing.x, spacing.y, spacing.z});
    const double pixel =
        2 * camera()->GetDistance() * std::tan(0.5 * glm::radians(camera()->GetViewAngle())) / k_height;
    const Silhouette silhouette(*picture_, bone_);
    const double slack = is_reduced ? 6 : is_coarse ? 3 : 0.5;  // voxels
    const int margin = is_coarse ? 1 + static_cast<int>(std::ceil(slack * voxel / pixel / 2)) : 0;
    return silhouette.faults(read(surface_->window()), camera(), margin, slack * voxel);
  }
  void keep(const std::string& name) {
    if (const char* folder = std::getenv("TREPHINE_SCREENSHOTS"))
      write_png(surface_->window(), (std::filesystem::path(folder) / (name + ".png")).string());
  }

 private:
  const haptics::TouchScene& scene_;
  DeepVoxels bone_;
  std::unique_ptr<DrawSurface> surface_;
  std::optional<Viewport> picture_;
};

void expect_whole(const haptics::TouchScene& scene, const std::string& name) {
  Subject subject(scene);
  int view_number = 0;
  for (const char side : {'\0', 'A', 'P', 'L', 'S', 'I'})
    for (const double nearer : {1.0, 2.5}) {
      if (!runs_all_cases() && view_number++ % 5 != 0) continue;  // 0 from afar, P near, I from afar
      const std::string view = name + "-" + (side ? side : '0') + (nearer > 1 ? "-near" : "");
      SCOPED_TRACE(view);
      subject.aim_camera(side, nearer);
      subject.picture().view().bone().show_reduced(
          {make_reduced_mesh(scene, 0, *haptics::uncut_version(scene))});
      subject.picture().view().bone().render();
      EXPECT_FALSE(subject.picture().view().bone().is_complete());
      subject.keep(view + "-reduced");
      const Faults reduced = subject.faults(true, true);
      subject.picture().draw();  // all chunks are finished and replace the reduced surface
      subject.keep(view + "-coarse");
      const Faults coarse = subject.faults(true);
      ASSERT_TRUE(subject.picture().complete());
      EXPECT_EQ(subject.picture().drawn_share(), 1.0);
      subject.keep(view + "-fine");
      const Faults fine = subject.faults(false);
      EXPECT_GT(fine.inside, 80);
      EXPECT_EQ(reduced.missing, 0);
      EXPECT_EQ(coarse.missing, 0);
      // The limit is 1, because one of 13,000 pixels was missing in one of eight runs on a busy machine.
      EXPECT_LE(fine.missing, 1);
      // In the base of the skull and in noisy skin, some crevices are darker than the limit for black.
      EXPECT_LE(coarse.black, fine.black + coarse.inside / 5000);
      EXPECT_LE(reduced.black, fine.black + reduced.inside / 5000);
    }
}

TEST(WholePicture, OfThePhantomsHasNoHoles) {
  for (const char* name : {"head", "spine"}) expect_whole(scenes::phantom_scene(name, {}), name);
}

TEST(WholePicture, OfEveryRealScanHasNoHoles) {
  const std::string data = data_tools::real_data();
  if (data.empty()) GTEST_SKIP() << "no real data: set TREPHINE_DATA";
  struct Scan {
    const char* file;
    double threshold;
    bool is_quick;
  };
  for (const Scan& scan : {Scan{"head_real/pcir_head_0.6mm.dicom.tar.xz", 300, false},
                           Scan{"skull_phantom/bone_1mm.dicom.tar.xz", 300, false},
                           Scan{"spine_thoracic/tspine_roi_078x078x1.nii.gz", 200, true},
                           Scan{"spine_lumbar/example_ct.nii.gz", 200, true},
                           Scan{"spine_vhf/vhf_lumbar_pelvis_1mm.dicom.tar.xz", 200, false},
                           Scan{"mr_head/ch2.nii.gz", 60, true}}) {
    if (!runs_all_cases() && !scan.is_quick) continue;
    auto opened = data_tools::open_volume(data + "/" + scan.file);
    ASSERT_TRUE(opened.is_ok()) << scan.file;
    volume::Shape shape;
    shape.low = scan.threshold;
    expect_whole(scenes::scene_of(std::move(opened.value().volume), {}, shape),
                 std::filesystem::path(scan.file).parent_path().string());
  }
}

int folded_triangles(const DrawMesh& mesh) {
  int count = 0;
  for (std::size_t t = 0; t + 2 < mesh.triangles.size(); t += 3) {
    const std::uint32_t a = mesh.triangles[t], b = mesh.triangles[t + 1], c = mesh.triangles[t + 2];
    const glm::vec3 out =
        glm::cross(mesh.vertices[b] - mesh.vertices[a], mesh.vertices[c] - mesh.vertices[a]);
    count += glm::dot(out, mesh.normals[a] + mesh.normals[b] + mesh.normals[c]) < 0;
  }
  return count;
}

/// A folded triangle would be lit from inside: a dark speck.
TEST(WholePicture, CoarseSurfacesHaveNoFoldedTriangles) {
  const haptics::TouchScene scene = scenes::phantom_scene("head", {});
  ChunkWorker worker(scene, 1);
  worker.request_all(haptics::uncut_version(scene));
  worker.finish();
  int folded = 0, triangles = 0, turned = 0;
  for (ChunkMesh& mesh : worker.take()) {
    folded += folded_triangles(mesh.coarse);
    triangles += static_cast<int>(mesh.coarse.triangles.size() / 3);
    if (mesh.coarse.triangles.empty()) continue;
    std::swap(mesh.coarse.triangles[0], mesh.coarse.triangles[1]);  // the planted fault
    turned += folded_triangles(mesh.coarse);
  }
  EXPECT_GT(triangles, 10000);
  EXPECT_EQ(folded, 0);
  EXPECT_GT(turned, 100);
}

/// Counts pixels of bone that are much darker than all eight pixels around them.
int dark_specks(const Picture& picture) {
  constexpr double k_darker = 35;  // of 255
  int count = 0;
  for (int y = 1; y + 1 < picture.height; ++y)
    for (int x = 1; x + 1 < picture.width; ++x) {
      double around = 255;
      for (int n = 0; n < 9; ++n) {
        const int u = x + n % 3 - 1, v = y + n / 3 - 1;
        if (n != 4) around = std::min(around, picture.is_drawn(u, v) ? picture.light(u, v) : 0);
      }
      count += picture.light(x, y) < around - k_darker;
    }
  return count;
}

/// Narrow triangles that the rounding to pixels reverses are lit like those around them.
TEST(WholePicture, CoarseSurfacesHaveNoDarkSpecks) {
  const haptics::TouchScene scene = scenes::phantom_scene("head", {});
  Subject subject(scene);
  subject.window()->SetSize(1200, 900);
  const auto specks = [&] {
    int count = 0;
    for (const char side : {'A', 'P'})
      for (const double nearer : {1.0, 2.0}) {
        subject.aim_camera(side, nearer);
        subject.picture().draw();
        EXPECT_FALSE(subject.picture().is_complete());
        count += dark_specks(read(subject.window()));
      }
    return count;
  };
  EXPECT_EQ(specks(), 0);
  // The planted fault: the lighting of VTK.
  vtkActorCollection* actors = subject.picture().view().renderer()->GetActors();
  actors->InitTraversal();
  while (vtkActor* actor = actors->GetNextActor()) actor->GetShaderProperty()->ClearAllShaderReplacements();
  EXPECT_GT(specks(), 0);
}

/// The worker makes the reduced surfaces before the chunks, and discards them when the last chunk is
/// finished.
TEST(WholePicture, ReducedSurfacesComeFirst) {
  const haptics::TouchScene scene = scenes::phantom_scene("head", {});
  ChunkWorker worker(scene, 1);
  std::vector<ChunkMesh> reduced;
  std::size_t early = 0;
  // A busy machine may finish all chunks before this thread looks.
  for (int attempt = 0; attempt < 20 && reduced.empty(); ++attempt) {
    worker.request_all(haptics::uncut_version(scene));
    while (reduced.empty() && worker.remaining() > 0) reduced = worker.take_reduced();
    early = worker.take().size();
  }
  ASSERT_EQ(reduced.size(), 1u);
  EXPECT_GT(reduced[0].coarse.triangles.size(), 3000u);
  worker.finish();
  worker.take();
  worker.request_all(haptics::uncut_version(scene));
  worker.finish();
  EXPECT_TRUE(worker.take_reduced().empty());
  EXPECT_LT(early, worker.take().size());
}

/// From the first frame on, the picture shows either no bone or the whole bone.
TEST(WholePicture, TheFirstPicturesHaveNoPartsOfBone) {
  const haptics::TouchScene scene = scenes::phantom_scene("head", {});
  Subject subject(scene, false);
  subject.aim_camera('A', 1);
  int pictures = 0;
  while (!subject.picture().is_complete()) {
    subject.picture().draw();
    if (subject.picture().view().bone().drawn_triangles() == 0) continue;
    const Faults faults = subject.faults(true, true);
    EXPECT_GT(faults.inside, 1000);
    EXPECT_EQ(faults.missing, 0) << "picture " << pictures;
    ++pictures;
  }
  EXPECT_GT(pictures, 0);
}

/// As soon as the picture is complete, the window shows it at full detail, also if it was drawn in batches.
TEST(WholePicture, ACompletePictureIsShown) {
  const haptics::TouchScene scene = scenes::phantom_scene("head", {});
  Subject subject(scene);
  for (const char side : {'A', 'L'}) {
    subject.aim_camera(side, 1);
    subject.picture().draw();
    ASSERT_TRUE(subject.picture().complete());
    const Picture complete = read(subject.window());
    subject.picture().view().bone().render(true);
    EXPECT_EQ(complete.colours, read(subject.window()).colours) << side;
  }
}

/// Planted fault: a clip that hides a part.
TEST(WholePicture, MissingPartsAreDetected) {
  const haptics::TouchScene scene = scenes::phantom_scene("head", {});
  Subject subject(scene);
  subject.aim_camera('L', 1);
  subject.picture().set_clip({ClipChoice::Axis::view, 0.2});
  ASSERT_TRUE(subject.picture().complete());
  EXPECT_GT(subject.faults(false).missing, 1000);
}

/// After a change of its size, the window system redraws the window before the next frame of the view. The
/// redrawn picture has the projection of the new size. It is not complete until it is drawn at full detail.
TEST(WholePicture, IsDrawnInTheNewSizeWhenTheWindowSystemRedrawsIt) {
  const haptics::TouchScene scene = scenes::phantom_scene("spine", {});
  Subject subject(scene);
  subject.aim_camera('P', 1);
  subject.window()->SetSize(2 * k_width / 3, k_height + 60);
  ASSERT_TRUE(subject.picture().complete());
  subject.window()->SetSize(k_width, k_height);
  EXPECT_FALSE(subject.picture().is_complete());
  EXPECT_LT(subject.picture().drawn_share(), 1);
  subject.window()->Render();
  subject.keep("spine-redrawn");
  const Faults redrawn = subject.faults(true);
  EXPECT_GT(redrawn.inside, 80);
  EXPECT_EQ(redrawn.missing, 0);
  // A further redraw shows the same picture; the view then completes it.
  subject.window()->Render();
  EXPECT_EQ(subject.faults(true).missing, 0);
  ASSERT_TRUE(subject.picture().complete());
  EXPECT_LE(subject.faults(false).missing, 1);
}

/// A picture of any aspect ratio shows the whole head. The ray through the projection of a point passes the
/// point.
TEST(WholePicture, ShowsTheWholeHeadInANarrowWindow) {
  const haptics::TouchScene scene = scenes::phantom_scene("head", {});
  Subject subject(scene);
  glm::dvec3 low, high;
  ASSERT_TRUE(subject.picture().complete());
  subject.picture().view().bounds(low, high);
  for (const double aspect : {2.0, 1.0, 0.64, 0.3}) {
    subject.window()->SetSize(static_cast<int>(k_height * aspect), k_height);
    for (const char side : {'\0', 'A', 'L', 'S'}) {
      SCOPED_TRACE(std::to_string(aspect) + side);
      subject.aim_camera(side, 1);
      for (int face = 0; face < 6; ++face) {
        glm::dvec3 at = 0.5 * (low + high);
        at[face / 2] = face % 2 ? high[face / 2] : low[face / 2];
        const glm::dvec2 in_picture = subject.picture().project(at);
        EXPECT_GE(std::min({in_picture.x, in_picture.y, 1 - in_picture.x, 1 - in_picture.y}), 0);
        const Ray ray = subject.picture().ray_at(in_picture.x, in_picture.y);
        const glm::dvec3 to = at - ray.origin;
        EXPECT_LT(glm::length(to - glm::dot(to, ray.direction) * ray.direction), 0.5);
      }
    }
  }
}

/// The picture stays whole if other code moves the camera's clipping planes into the head.
TEST(WholePicture, StaysWholeWhenOthersMoveTheCamerasPlanes) {
  const haptics::TouchScene scene = scenes::phantom_scene("head", {});
  Subject subject(scene);
  subject.aim_camera('A', 1);
  subject.picture().draw();
  double range[2];
  subject.camera()->GetClippingRange(range);
  const double middle = 0.5 * (range[0] + range[1]);
  for (int i = 0; i < 1000 && !subject.picture().is_complete(); ++i) {
    subject.camera()->SetClippingRange(middle, middle + 20);
    subject.picture().draw();
    std::this_thread::sleep_for(std::chrono::milliseconds(2));
  }
  EXPECT_EQ(subject.faults(false).missing, 0);
}

}  // namespace
}  // namespace trephine::view
