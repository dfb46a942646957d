// Reslicing of a scan by any plane, or a slab around one: the slices that people look at.
#pragma once

#include <cstdint>
#include <span>

#include "volume/image_plane.h"
#include "volume/version.h"

namespace trephine::volume {

/// Combination of the samples before and behind a pixel.
struct Slab {
  enum class Kind : std::uint8_t { mean, maximum };
  double thickness = 0;  ///< mm, half of it on each side; 0: the plane alone
  Kind kind = Kind::mean;
};
inline constexpr std::string_view k_slabs[] = {"mean", "maximum"};

/// Eight pixels at once, or one after another: the same bits.
enum class ResliceCode : std::uint8_t { any, wide };
ResliceCode best_reslice_code() noexcept;

/// Intensities at the pixels' middles, linear between voxels (within half a grey level of double precision),
/// row by row from the upper left; `outside` farther than half a voxel beyond the outermost ones. A slab is
/// sampled at half the least spacing. The plane passed check(). The same bits for any number of threads.
void reslice(const Volume& volume, const ImagePlane& plane, const Slab& slab, std::int16_t outside,
             int threads, std::span<std::int16_t> pixels, ResliceCode code = best_reslice_code());

/// Applies cuts to the plane alone: what was cut away becomes `air`, with an edge as soft as the scan's own
/// (half a voxel to each side of the surface of the cut).
void reslice_cuts(const Version& version, const ImagePlane& plane, std::int16_t air, int threads,
                  std::span<std::int16_t> pixels);

/// One row of pixels within the volume, for the wide code. Places in 2^-20 of a voxel. Plain data: compiled
/// for newer CPUs.
struct ResliceRow {
  const std::int16_t* voxels;
  const float* sheet;  ///< values of one x, instead of voxels
  std::int32_t stride_y, stride_z;
  std::int32_t at[3], step[3];
};
/// `count` is a multiple of 8.
void reslice_row_wide(const ResliceRow& row, int count, float* values);
void reslice_row_wide(const ResliceRow& row, int count, std::int16_t* pixels);

}  // namespace trephine::volume
