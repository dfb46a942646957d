// Library trephine-vdb: implements VdbLibrary with OpenVDB, without other code of this project.
#include <cmath>
#include <cstdio>
#include <openvdb/openvdb.h>
#include <openvdb/tools/Dense.h>

#include "data-tools/formats/loaded_formats.h"

namespace trephine::data_tools {

namespace {

constexpr const char *k_frame_key = "trephine_world", *k_frame_value = "LPS, mm", *k_unit_key = "RescaleType",
                     *k_unit_value = "HU";

void fail(VdbFacts& facts, const std::string& reason) {
  std::snprintf(facts.fault, sizeof facts.fault, "%s", reason.c_str());
}

/// Calls use(grid) with the grid's own type; false if its values are not float, double or int32.
template <class Use>
bool with_numbers(const openvdb::GridBase::Ptr& grid, const Use& use) {
  if (const auto f = openvdb::gridPtrCast<openvdb::FloatGrid>(grid)) return use(*f), true;
  if (const auto d = openvdb::gridPtrCast<openvdb::DoubleGrid>(grid)) return use(*d), true;
  if (const auto i = openvdb::gridPtrCast<openvdb::Int32Grid>(grid)) return use(*i), true;
  return false;
}

/// Returns the open grid, which is never destroyed: its destructor uses threads; a forked process lacks them.
openvdb::GridBase::Ptr& open_grid() {
  static auto* grid = new openvdb::GridBase::Ptr;
  return *grid;
}

/// Counts the grids with numbers and opens grid `index` of them.
void find_grid(openvdb::io::File& file, int index, VdbFacts& facts) {
  for (auto name = file.beginName(); name != file.endName(); ++name) {
    const auto metadata = file.readGridMetadata(name.gridName());
    if (!metadata) continue;
    const std::string type = metadata->valueType();
    if (type != "float" && type != "double" && type != "int32") continue;
    if (facts.grids++ == index) open_grid() = file.readGrid(name.gridName());
  }
}

void open_file(const char* path, int index, VdbFacts& facts) {
  openvdb::initialize();
  auto* file = new openvdb::io::File(path);
  file->open(false);  // loads everything now, not on demand
  facts.grids = 0;
  find_grid(*file, index, facts);
  if (facts.grids == 0) return fail(facts, "no grid of float, double or int32");
  if (!open_grid()) return;  // the caller reports the invalid index
  const openvdb::GridBase& grid = *open_grid();
  if (grid.getGridClass() == openvdb::GRID_LEVEL_SET)
    return fail(facts, "a level set: distances, not values");
  if (!grid.transform().isLinear()) return fail(facts, "a map that is not linear");
  const openvdb::CoordBBox box = grid.evalActiveVoxelBoundingBox();
  if (box.empty()) return fail(facts, "a grid without active voxels");
  const glm::ivec3 last(box.max().x(), box.max().y(), box.max().z());
  facts.low = {box.min().x(), box.min().y(), box.min().z()};
  for (int a = 0; a < 3; ++a) {
    const std::int64_t extent = std::int64_t{last[a]} - facts.low[a] + 1;
    facts.size[a] = static_cast<int>(std::min<std::int64_t>(extent, 2'000'000'000));
  }
  const auto to_world = [&grid](const openvdb::Vec3d& p) {
    const openvdb::Vec3d w = grid.transform().indexToWorld(p);
    return glm::dvec3(w.x(), w.y(), w.z());
  };
  const openvdb::Vec3d low(box.min().x(), box.min().y(), box.min().z());
  facts.origin = to_world(low);
  for (int a = 0; a < 3; ++a) {
    openvdb::Vec3d step(0, 0, 0);
    step[a] = 1;
    facts.axes[a] = to_world(low + step) - facts.origin;
  }
  const auto has_metadata = [&grid](const char* key, const char* value) {
    const auto metadata = grid.getMetadata<openvdb::StringMetadata>(key);
    return metadata && metadata->value() == value;
  };
  facts.is_ours = has_metadata(k_frame_key, k_frame_value);
  facts.is_hounsfield = has_metadata(k_unit_key, k_unit_value);
}

void describe(const char* path, int index, VdbFacts& facts) {
  try {
    open_file(path, index, facts);
  } catch (const std::exception&) {
    fail(facts, "not a .vdb file that OpenVDB can read");
  }
}

void read(const char* path, int index, VdbFacts& facts, float* values) {
  try {
    open_file(path, index, facts);
    if (facts.fault[0] != 0 || !open_grid()) return;
    const openvdb::CoordBBox box(
        openvdb::Coord(facts.low.x, facts.low.y, facts.low.z),
        openvdb::Coord(facts.low.x + facts.size.x - 1, facts.low.y + facts.size.y - 1,
                       facts.low.z + facts.size.z - 1));
    openvdb::tools::Dense<float, openvdb::tools::LayoutXYZ> dense(box, values);
    with_numbers(open_grid(), [&](const auto& grid) { openvdb::tools::copyToDense(grid, dense, true); });
  } catch (const std::exception&) {
    fail(facts, "damaged contents");
  }
}

/// Writes scans as float and labels as int32, exactly: OpenVDB has no grids of int16 and uint8.
bool write(const char* path, const glm::ivec3& size, const glm::dvec3& origin, const glm::dmat3& axes,
           bool is_short, const void* voxels, bool is_hounsfield) {
  try {
    openvdb::initialize();
    const openvdb::math::Mat4d map(axes[0].x, axes[0].y, axes[0].z, 0.0, axes[1].x, axes[1].y, axes[1].z, 0.0,
                                   axes[2].x, axes[2].y, axes[2].z, 0.0, origin.x, origin.y, origin.z, 1.0);
    const auto fill = [&]<class Grid, class Source>(Grid& grid, const Source* source) {
      auto accessor = grid.getAccessor();
      for (int z = 0; z < size.z; ++z)
        for (int y = 0; y < size.y; ++y)
          for (int x = 0; x < size.x; ++x) {
            const auto value = static_cast<typename Grid::ValueType>(*source++);
            // Active corners preserve the extent.
            const bool is_corner =
                (x == 0 || x == size.x - 1) && (y == 0 || y == size.y - 1) && (z == 0 || z == size.z - 1);
            if (is_corner || value != grid.background()) accessor.setValueOn({x, y, z}, value);
          }
    };
    openvdb::GridBase::Ptr& grid = open_grid();
    if (is_short) {
      const auto result = openvdb::FloatGrid::create(is_hounsfield ? -1000.0F : 0.0F);
      fill(*result, static_cast<const std::int16_t*>(voxels));
      result->setGridClass(openvdb::GRID_FOG_VOLUME);
      grid = result;
    } else {
      const auto result = openvdb::Int32Grid::create(0);
      fill(*result, static_cast<const std::uint8_t*>(voxels));
      grid = result;
    }
    grid->setName(is_short ? "scan" : "labels");
    grid->setTransform(openvdb::math::Transform::createLinearTransform(map));
    grid->insertMeta(k_frame_key, openvdb::StringMetadata(k_frame_value));
    if (is_hounsfield) grid->insertMeta(k_unit_key, openvdb::StringMetadata(k_unit_value));
    openvdb::io::File file(path);
    file.write({grid});
    file.close();
    // OpenVDB does not report a full disk: read the file again.
    openvdb::io::File written_file(path);
    written_file.open(false);
    const auto reread = written_file.readGrid(grid->getName());
    return reread && reread->activeVoxelCount() == grid->activeVoxelCount();
  } catch (const std::exception&) {
    return false;
  }
}

}  // namespace

extern "C" const VdbLibrary* trephine_vdb_library() {
  static const VdbLibrary k_library{describe, read, write};
  return &k_library;
}

}  // namespace trephine::data_tools
