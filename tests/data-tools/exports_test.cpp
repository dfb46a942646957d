// Geometry of DICOM stacks, files of meshes, and basic properties of phantoms.
#include <cmath>
#include <filesystem>
#include <fstream>
#include <glm/geometric.hpp>
#include <gtest/gtest.h>

#include "data-tools/dicom/dicom_stack.h"
#include "data-tools/files/atomic_file.h"
#include "data-tools/meshes/mesh_files.h"
#include "data-tools/phantoms/phantoms.h"

namespace trephine::data_tools {
namespace {

std::vector<SlicePosition> stack(int count) {
  std::vector<SlicePosition> slices;
  for (int i = 0; i < count; ++i) {
    SlicePosition s;
    const int k = (i * 7) % count;  // not sorted
    s.position = {-100, 50, 12.0 + 1.25 * k};
    s.row_spacing = 0.5;
    s.column_spacing = 0.4;
    s.name = "slice " + std::to_string(k);
    slices.push_back(s);
  }
  return slices;
}

TEST(DicomStack, SortsAndBuildsTheFrame) {
  const auto s = stack_slices(stack(10));
  ASSERT_TRUE(s.is_ok()) << s.error().message();
  EXPECT_EQ(s.value().frame.origin(), glm::dvec3(-100, 50, 12));
  EXPECT_NEAR(s.value().frame.spacing().x, 0.4, 1e-12);
  EXPECT_NEAR(s.value().frame.spacing().y, 0.5, 1e-12);
  EXPECT_NEAR(s.value().frame.spacing().z, 1.25, 1e-12);
  for (int k = 0; k < 10; ++k) EXPECT_EQ((s.value().order[static_cast<std::size_t>(k)] * 7) % 10, k);
}

void expect_refused(const std::vector<SlicePosition>& slices, const char* word) {
  const auto s = stack_slices(slices);
  ASSERT_FALSE(s.is_ok()) << word;
  EXPECT_NE(s.error().message().find(word), std::string::npos) << s.error().message();
}

TEST(DicomStack, RefusesIrregularStacksAndReportsByHowMuch) {
  auto s = stack(10);
  s.erase(s.begin() + 4);
  expect_refused(s, "1 slice missing");
  s = stack(10);
  s[3].position = s[4].position;
  expect_refused(s, "1 slice of 10 too many: slice");
  s = stack(10);
  for (auto& p : s) p.position.z += p.position.z > 17 ? 0.4 : 0;
  expect_refused(s, "steps from 1.250 mm to 1.650 mm");
  s = stack(10);

  s[2].row_axis = {0, 1, 0}, s[2].column_axis = {0, 0, -1};
  expect_refused(s, "parallel");
  s = stack(10);
  s[6].row_spacing = 0.6;
  expect_refused(s, "different pixel spacings");
  s = stack(10);
  s[0].column_axis = {0.1, 0.99, 0};
  expect_refused(s, "orthogonal");
  s = stack(10);
  s[5].row_spacing = 0;
  expect_refused(s, "invalid pixel spacing");
  s = stack(10);
  s[5].position.x = std::nan("");
  expect_refused(s, "finite");
  s = stack(10);
  s[5].position.x += 8;
  expect_refused(s, "outside the line");
  expect_refused({}, "no slices");
}

TEST(DicomStack, ATiltIsACommonShearOfAllPositions) {
  auto s = stack(10);
  for (auto& p : s) p.position.y += std::tan(18.5 * 3.14159265358979 / 180) * p.position.z;
  const auto tilted = stack_slices(s);
  ASSERT_TRUE(tilted.is_ok());
  EXPECT_NEAR(tilted.value().tilt_degrees, 18.5, 1e-9);
  for (int k = 0; k < 10; ++k) {
    const glm::dvec3 at =
        s[static_cast<std::size_t>(tilted.value().order[static_cast<std::size_t>(k)])].position;
    EXPECT_LT(glm::length(tilted.value().frame.world_from_volume({0, 0, k}) - at), 1e-9);
  }
}

TEST(DicomStack, RoundedPositionsAreStillRegular) {
  auto s = stack(60);
  for (auto& p : s) p.position.z = std::floor(p.position.z / 0.01 + 0.5) * 0.01;
  EXPECT_TRUE(stack_slices(s).is_ok());
}

TEST(MeshFiles, EveryFormatKeepsAllTriangles) {
  PhantomOptions o;
  o.size = glm::ivec3(24);
  o.psf_sigma_voxels = 1;
  const volume::Volume v = make_phantom("sphere", o).value();
  const volume::Field field(v, volume::Shape{});
  const volume::Mesh mesh = volume::surface_net({&field});
  const auto folder = std::filesystem::temp_directory_path();
  const auto size_of = [&](const char* name) {
    const std::string path = (folder / name).string();
    EXPECT_FALSE(write_mesh(path, mesh, v.frame).has_value());
    const auto bytes = std::filesystem::file_size(path);
    std::filesystem::remove(path);
    return bytes;
  };
  EXPECT_EQ(size_of("trephine-mesh-test.stl"), 84 + 50 * mesh.triangle_count());
  EXPECT_GT(size_of("trephine-mesh-test.ply"), 12 * mesh.vertices.size() + 13 * mesh.triangle_count());
  EXPECT_GT(size_of("trephine-mesh-test.obj"), 10 * mesh.vertices.size());
  EXPECT_GT(size_of("trephine-mesh-test.vtp"), 12 * mesh.vertices.size() + 32 * mesh.triangle_count());
  EXPECT_TRUE(write_mesh("mesh.xyz", mesh, v.frame).has_value());
}

TEST(Phantoms, AreDeterministicAndErrorsNameThem) {
  PhantomOptions o;
  o.size = glm::ivec3(40);
  for (const PhantomInfo& info : phantom_catalogue()) {
    o.threads = 1;
    const volume::Volume a = make_phantom(info.name, o).value();
    o.threads = 3;
    const volume::Volume b = make_phantom(info.name, o).value();
    for (std::size_t i = 0; i < a.voxels.size(); ++i) ASSERT_EQ(a.voxels[i], b.voxels[i]) << info.name;
  }
  EXPECT_NE(make_phantom("cube", o).error().message().find("sphere"), std::string::npos);
  o.parameters = {{"diameter", 3}};
  EXPECT_NE(make_phantom("sphere", o).error().message().find("radius"), std::string::npos);
  o.parameters = {{"radius", std::nan("")}};
  EXPECT_FALSE(make_phantom("sphere", o).is_ok());
  o.parameters = {};
  o.psf_sigma_voxels = 3;
  EXPECT_FALSE(make_phantom("sphere", o).is_ok());
  o.psf_sigma_voxels = 0;
  o.spacing_mm = glm::dvec3(0);
  EXPECT_FALSE(make_phantom("sphere", o).is_ok());
}

TEST(Phantoms, SizeAndSpacingDetermineEachOther) {
  PhantomOptions o;
  o.size = glm::ivec3(60, 60, 40);
  EXPECT_NEAR(make_phantom("plane", o).value().frame.spacing().z, 3, 1e-12);
  o.size.reset();
  o.spacing_mm = glm::dvec3(1.5);
  EXPECT_EQ(make_phantom("plane", o).value().size, glm::ivec3(80));
  o.spacing_mm = glm::dvec3(2);
  o.shear_degrees = 20;
  EXPECT_FALSE(make_phantom("plane", o).value().frame.is_orthogonal());
}

// The value of an unblurred voxel is the exact fraction of its volume below the plane. The interpolated
// surface then has a known error, which a blur reduces.
TEST(Phantoms, TheSurfaceOfAPlaneIsNearTheTruth) {
  PhantomOptions o;
  o.size = glm::ivec3(64);
  for (const double sigma : {0.0, 1.0, 2.0}) {
    o.psf_sigma_voxels = sigma;
    o.parameters = {{"angle", 33}};
    const volume::Volume v = make_phantom("plane", o).value();
    const volume::Field field(v, volume::Shape{});
    double sum = 0;
    int count = 0;
    for (int x = 20; x < 44; ++x)
      for (int y = 20; y < 44; ++y) {
        double low = 5, high = 58;  // along z through the plane
        for (int k = 0; k < 50; ++k) {
          const double mid = 0.5 * (low + high);
          (field.value({x + 0.37, y + 0.21, mid}) >= 0 ? low : high) = mid;
        }
        const double error =
            phantom_distance("plane", o.parameters, v.frame.world_from_volume({x + 0.37, y + 0.21, low})) /
            (120.0 / 64);
        sum += error * error;
        ++count;
      }
    const double rms = std::sqrt(sum / count);
    EXPECT_LT(rms, sigma == 0   ? 0.06
                   : sigma == 1 ? 0.012
                                : 0.004)
        << sigma;  // voxels; the known errors are 0.043, 0.007 and 0.002
  }
}

TEST(Phantoms, TheHeadHasEveryTissueAndRealisticIntensities) {
  PhantomOptions o;
  o.spacing_mm = glm::dvec3(2);
  const volume::Volume head = make_phantom("head", o).value();
  std::vector<double> sum(head.label_names.size()), count(head.label_names.size());
  for (std::size_t i = 0; i < head.voxels.size(); ++i)
    sum[head.labels[i]] += head.voxels[i], ++count[head.labels[i]];
  const auto mean = [&](const char* name) {
    const int label = head.label_value(name);
    EXPECT_GE(label, 0) << name;
    EXPECT_GT(count[static_cast<std::size_t>(label)], 50) << name;
    return sum[static_cast<std::size_t>(label)] / count[static_cast<std::size_t>(label)];
  };
  EXPECT_GT(mean("cortical_bone"), 600);
  EXPECT_NEAR(mean("diploe"), 650, 250);
  EXPECT_NEAR(mean("brain"), 33, 15);
  EXPECT_GT(mean("tooth"), 1000);
  EXPECT_LT(mean("air"), -800);
  for (const char* name : {"soft_tissue", "dura", "csf", "ventricle_left", "ventricle_right"}) mean(name);
}

}  // namespace
}  // namespace trephine::data_tools
