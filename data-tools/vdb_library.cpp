// The library trephine-vdb: OpenVDB, and nothing else of ours.
#include <cmath>
#include <cstdio>
#include <openvdb/openvdb.h>
#include <openvdb/tools/Dense.h>

#include "data-tools/loaded_formats.h"

namespace trephine::data_tools {

namespace {

constexpr const char *k_frame_key = "trephine_world", *k_frame_value = "LPS, mm", *k_unit_key = "RescaleType",
                     *k_unit_value = "HU";

void fail(VdbFacts& facts, const std::string& why) {
  std::snprintf(facts.fault, sizeof facts.fault, "%s", why.c_str());
}

/// Calls use(grid) with the grid as its type; false when it holds no numbers.
template <class Use>
bool with_numbers(const openvdb::GridBase::Ptr& grid, const Use& use) {
  if (const auto f = openvdb::gridPtrCast<openvdb::FloatGrid>(grid)) return use(*f), true;
  if (const auto d = openvdb::gridPtrCast<openvdb::DoubleGrid>(grid)) return use(*d), true;
  if (const auto i = openvdb::gridPtrCast<openvdb::Int32Grid>(grid)) return use(*i), true;
  return false;
}

/// Trees are never taken down: this process ends, and that would call on threads that it does not have.
openvdb::GridBase::Ptr& kept() {
  static auto* grid = new openvdb::GridBase::Ptr;
  return *grid;
}

/// Grid `index` among those with numbers; counts them.
void find_grid(openvdb::io::File& file, int index, VdbFacts& facts) {
  for (auto name = file.beginName(); name != file.endName(); ++name) {
    const auto head = file.readGridMetadata(name.gridName());
    if (!head) continue;
    const std::string type = head->valueType();
    if (type != "float" && type != "double" && type != "int32") continue;
    if (facts.grids++ == index) kept() = file.readGrid(name.gridName());
  }
}

void open(const char* path, int index, VdbFacts& facts) {
  openvdb::initialize();
  auto* file = new openvdb::io::File(path);
  file->open(false);  // all at once: nothing is fetched later
  facts.grids = 0;
  find_grid(*file, index, facts);
  if (facts.grids == 0) return fail(facts, "no grid of float, double or int32");
  if (!kept()) return;  // the caller says that there are fewer
  const openvdb::GridBase& grid = *kept();
  if (grid.getGridClass() == openvdb::GRID_LEVEL_SET)
    return fail(facts, "a level set: distances, not values");
  if (!grid.transform().isLinear()) return fail(facts, "a map that is not linear");
  const openvdb::CoordBBox box = grid.evalActiveVoxelBoundingBox();
  if (box.empty()) return fail(facts, "a grid without active voxels");
  for (int a = 0; a < 3; ++a) {
    const std::int64_t extent = std::int64_t{box.max()[a]} - box.min()[a] + 1;
    facts.low[a] = box.min()[a];
    facts.size[a] = static_cast<int>(std::min<std::int64_t>(extent, 2'000'000'000));
  }
  const auto place = [&grid](const openvdb::Vec3d& p) {
    const openvdb::Vec3d w = grid.transform().indexToWorld(p);
    return glm::dvec3(w.x(), w.y(), w.z());
  };
  const openvdb::Vec3d low(box.min().x(), box.min().y(), box.min().z());
  facts.origin = place(low);
  for (int a = 0; a < 3; ++a) {
    openvdb::Vec3d step(0, 0, 0);
    step[a] = 1;
    facts.axes[a] = place(low + step) - facts.origin;
  }
  const auto says = [&grid](const char* key, const char* value) {
    const auto meta = grid.getMetadata<openvdb::StringMetadata>(key);
    return meta && meta->value() == value;
  };
  facts.is_ours = says(k_frame_key, k_frame_value);
  facts.is_hounsfield = says(k_unit_key, k_unit_value);
}

void describe(const char* path, int index, VdbFacts& facts) {
  try {
    open(path, index, facts);
  } catch (const std::exception&) {
    fail(facts, "no .vdb file that OpenVDB can read");
  }
}

void read(const char* path, int index, VdbFacts& facts, float* to) {
  try {
    open(path, index, facts);
    if (facts.fault[0] != 0 || !kept()) return;
    const openvdb::CoordBBox box(
        openvdb::Coord(facts.low.x, facts.low.y, facts.low.z),
        openvdb::Coord(facts.low.x + facts.size.x - 1, facts.low.y + facts.size.y - 1,
                       facts.low.z + facts.size.z - 1));
    openvdb::tools::Dense<float, openvdb::tools::LayoutXYZ> dense(box, to);
    with_numbers(kept(), [&](const auto& grid) { openvdb::tools::copyToDense(grid, dense, true); });
  } catch (const std::exception&) {
    fail(facts, "damaged contents");
  }
}

/// int16 and uint8 are no grids of OpenVDB's: scans become float, labels int32, exactly.
bool write(const char* path, const glm::ivec3& size, const glm::dvec3& origin, const glm::dmat3& axes,
           bool is_short, const void* voxels, bool is_hounsfield) {
  try {
    openvdb::initialize();
    const openvdb::math::Mat4d map(axes[0].x, axes[0].y, axes[0].z, 0.0, axes[1].x, axes[1].y, axes[1].z, 0.0,
                                   axes[2].x, axes[2].y, axes[2].z, 0.0, origin.x, origin.y, origin.z, 1.0);
    const auto fill = [&]<class Grid, class From>(Grid& grid, const From* from) {
      auto to = grid.getAccessor();
      for (int z = 0; z < size.z; ++z)
        for (int y = 0; y < size.y; ++y)
          for (int x = 0; x < size.x; ++x) {
            const auto value = static_cast<typename Grid::ValueType>(*from++);
            // The corners keep the extent.
            const bool is_corner =
                (x == 0 || x == size.x - 1) && (y == 0 || y == size.y - 1) && (z == 0 || z == size.z - 1);
            if (is_corner || value != grid.background()) to.setValueOn({x, y, z}, value);
          }
    };
    openvdb::GridBase::Ptr& grid = kept();
    if (is_short) {
      const auto made = openvdb::FloatGrid::create(is_hounsfield ? -1000.0F : 0.0F);
      fill(*made, static_cast<const std::int16_t*>(voxels));
      made->setGridClass(openvdb::GRID_FOG_VOLUME);
      grid = made;
    } else {
      const auto made = openvdb::Int32Grid::create(0);
      fill(*made, static_cast<const std::uint8_t*>(voxels));
      grid = made;
    }
    grid->setName(is_short ? "scan" : "labels");
    grid->setTransform(openvdb::math::Transform::createLinearTransform(map));
    grid->insertMeta(k_frame_key, openvdb::StringMetadata(k_frame_value));
    if (is_hounsfield) grid->insertMeta(k_unit_key, openvdb::StringMetadata(k_unit_value));
    openvdb::io::File file(path);
    file.write({grid});
    file.close();
    // It says nothing of a full disk: what was written is read again.
    openvdb::io::File written(path);
    written.open(false);
    const auto again = written.readGrid(grid->getName());
    return again && again->activeVoxelCount() == grid->activeVoxelCount();
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
