#include "volume/fields/offset_field.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/vector_relational.hpp>

#include "volume/base/deterministic_math.h"
#include "volume/base/text.h"
#include "volume/base/work_counters.h"
#include "volume/fields/crease_sheets.h"
#include "volume/fields/offset_builder.h"

namespace trephine::volume {

using glm::dvec3;
using glm::ivec3;

namespace {

constexpr int k_edge = SampleBrick::k_edge;
constexpr double k_steps_per_radius = 12;     // steps of the lattice
constexpr double k_min_creased_radius = 1.9;  // steps; below, sheets would read samples inside the solid

}  // namespace

double OffsetField::step_for(double radius, const Volume& volume) noexcept {
  const dvec3& spacing = volume.frame.spacing();
  const double voxel = std::min({spacing.x, spacing.y, spacing.z});
  // The error of a quadratic spline of samples with spacing h is h^2 / 8 times the sum of the second
  // derivatives. For the distance r to a point, the sum is 2 / r.
  const double max_step = 0.9 * std::sqrt(4 * radius * (0.1 + 0.02 * radius));
  // Limits the duration of a build to seconds, and the size of the tables of scans that are metres wide.
  constexpr double k_max_points = 1 << 28;
  const dvec3 extent = spacing * dvec3(volume.size);
  const double least =
      deterministic_exp(deterministic_log(extent.x * extent.y * extent.z / k_max_points) / 3);
  double step = std::min(voxel, std::max(max_step, least));
  // Reduces the step for a tool that is slightly too small for sheets, so that it has sheets.
  constexpr double k_finer = 0.7;
  if (radius < k_min_creased_radius * step && radius >= k_finer * k_min_creased_radius * step)
    step = std::max(least, radius / (1.02 * k_min_creased_radius));
  return std::max(radius / k_steps_per_radius, step);
}

Result<std::shared_ptr<const OffsetField>> OffsetField::build(const Field& field, const Occupancy& bits,
                                                              const Version* version, double radius,
                                                              int threads, Work* work, const SoftField* soft,
                                                              const std::atomic<bool>* is_cancelled) {
  const auto begin = std::chrono::steady_clock::now();
  ++work_counters().offset_fields;
  const Frame& base = field.volume().frame;
  const dvec3 extent = base.spacing() * dvec3(field.volume().size);
  if (!(radius > 0 && radius <= 20) || radius > std::max({extent.x, extent.y, extent.z}))
    return Error{.what = "the tool's radius is out of range",
                 .where = "radius",
                 .found = rounded_text(radius) + " mm",
                 .expected = "above 0, at most 20 mm and no larger than the volume",
                 .remedy = "use a ball with a radius in this range"};
  const dvec3& spacing = base.spacing();
  const double step = step_for(radius, field.volume());
  std::shared_ptr<OffsetField> result(new OffsetField);
  result->radius_ = radius;
  result->step_ = step;
  result->far_ = Builder::k_band * step;
  // The lattice has the axes of the volume, with steps of equal length, and a margin for the tool beyond
  // every border.
  glm::dmat3 axes;
  dvec3 origin(0);
  for (int a = 0; a < 3; ++a) axes[a] = base.axes()[a] * (step / spacing[a]);
  auto unshifted = Frame::from_axes(base.origin(), axes);
  if (!unshifted) return unshifted.error();
  result->frame_ = unshifted.value();
  const ivec3 margin = result->steps_within(radius + (Builder::k_band + 2) * step);
  for (int a = 0; a < 3; ++a) {
    result->size_[a] = static_cast<int>(std::ceil(extent[a] / step)) + 2 * margin[a];
    origin[a] = -static_cast<double>(margin[a]) * (step / spacing[a]);
  }
  auto frame = Frame::from_axes(base.world_from_volume(origin), axes);
  if (!frame) return frame.error();
  result->frame_ = frame.value();
  result->slots_size_ = (result->size_ + (k_edge - 1)) / k_edge;
  result->pages_size_ = (result->slots_size_ + 3) / 4;
  result->pages_.resize(static_cast<std::size_t>(result->pages_size_.x) *
                        static_cast<std::size_t>(result->pages_size_.y) *
                        static_cast<std::size_t>(result->pages_size_.z));
  if (radius >= k_min_creased_radius * step)
    result->sheets_ = std::make_shared<CreaseSheets>(result->slots_size_);
  Work total;
  Builder(*result, field, bits, version, nullptr, {}, soft).run(threads, total, is_cancelled);
  if (is_cancelled != nullptr && *is_cancelled)
    return Error{.what = "the preparation of the tool was cancelled", .kind = ErrorKind::interrupted};
  if (total.creased == 0) result->sheets_ = nullptr;
  total.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  if (work) *work = total;
  return std::shared_ptr<const OffsetField>(std::move(result));
}

std::shared_ptr<const OffsetField> OffsetField::updated(const Field& field, const Occupancy& bits,
                                                        const Version& version, const VoxelBox& changed,
                                                        int threads, Work* work,
                                                        const SoftField* soft) const {
  const auto begin = std::chrono::steady_clock::now();
  ++work_counters().offset_fields;
  std::shared_ptr<OffsetField> result(new OffsetField(*this));
  Work total;
  Builder(*result, field, bits, &version, this, changed, soft).run(threads, total);
  total.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  if (work) *work = total;
  return result;
}

void OffsetField::copy_pages(const ivec3& low, const ivec3& high) {
  for (int z = low.z >> 2; z <= high.z >> 2; ++z)
    for (int y = low.y >> 2; y <= high.y >> 2; ++y)
      for (int x = low.x >> 2; x <= high.x >> 2; ++x) {
        auto& page = pages_[page_index({4 * x, 4 * y, 4 * z})];
        page = page ? std::make_shared<Page>(*page) : std::make_shared<Page>();
      }
}

/// Lattice steps along each axis within a ball of radius `mm`, also on sheared axes.
ivec3 OffsetField::steps_within(double mm) const noexcept {
  ivec3 steps;
  for (int a = 0; a < 3; ++a) {
    dvec3 along(0);
    along[a] = 1;
    steps[a] = static_cast<int>(std::ceil(mm * glm::length(frame_.gradient_world_from_volume(along))));
  }
  return steps;
}

std::size_t OffsetField::bytes() const noexcept {
  std::size_t bricks = 0;
  for (const auto& page : pages_)
    for (const SampleSlot& slot : page->entries) bricks += slot.brick != nullptr;
  return pages_.size() * (sizeof(Page) + sizeof pages_[0]) + bricks * sizeof(SampleBrick) +
         (sheets_ ? sheets_->bytes() : 0);
}

double OffsetField::at(int x, int y, int z) const noexcept {
  if (!contains({x, y, z})) return -far_;
  const SampleSlot& slot = this->slot({x >> 3, y >> 3, z >> 3});
  if (!slot.brick) return slot.is_solid ? far_ : -far_;
  return static_cast<double>(slot.brick->values[SampleBrick::index_of({x, y, z})]);
}

void OffsetField::load(const ivec3& v, QuadraticPatch& patch) const noexcept {
  const SampleBrick* brick = contains(v) ? slot({v.x >> 3, v.y >> 3, v.z >> 3}).brick.get() : nullptr;
  load_around(v, brick, patch, [this](int x, int y, int z) { return at(x, y, z); });
}

double OffsetField::sheet_at(int sheet, const ivec3& cube, const ivec3& v) const noexcept {
  return std::min(at(v.x, v.y, v.z), static_cast<double>(sheets_->sample(sheet, cube, v)));
}

void OffsetField::load_sheet(int sheet, const ivec3& v, QuadraticPatch& patch) const noexcept {
  CreaseSheets::Samples samples;
  sheets_->load(sheet, v, samples);
  std::size_t n = 0;
  for (int k = -1; k <= 1; ++k)
    for (int j = -1; j <= 1; ++j, n += 3) {
      const auto value = [&](std::size_t i) {
        const double u = at(v.x + static_cast<int>(i) - 1, v.y + j, v.z + k);
        return std::min(u, static_cast<double>(samples[n + i]));
      };
      patch.set_row(j + 1, k + 1, value(0), value(1), value(2));
    }
}

bool OffsetField::is_free_around(const ivec3& v) const noexcept {
  const ivec3 low = glm::clamp(v - 1, ivec3(0), size_ - 1) >> 3,
              high = glm::clamp(v + 1, ivec3(0), size_ - 1) >> 3;
  for (int z = low.z; z <= high.z; ++z)
    for (int y = low.y; y <= high.y; ++y)
      for (int x = low.x; x <= high.x; ++x) {
        const SampleSlot& slot = this->slot({x, y, z});
        if (slot.brick || slot.is_solid) return false;
      }
  return true;
}

VoxelBox OffsetField::free_box(const ivec3& v) const noexcept {
  if (!contains(v) || !is_free_around(v)) return {ivec3(0), ivec3(-1)};
  const ivec3 b = v >> 3;
  const SampleSlot& slot = this->slot(b);
  if (slot.brick || slot.is_solid) return {ivec3(0), ivec3(-1)};
  // Excludes the outermost lattice points of the brick, because their cubes read samples of neighbouring
  // bricks.
  const ivec3 low = b * k_edge + 1, high = b * k_edge + (k_edge - 2);
  const bool is_inner = glm::all(glm::greaterThanEqual(v, low)) && glm::all(glm::lessThanEqual(v, high));
  return is_inner ? VoxelBox{low, high} : VoxelBox{v, v};
}

}  // namespace trephine::volume
