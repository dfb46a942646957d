// Reslicing of a scan by an arbitrary plane or by a slab around a plane.
#pragma once

#include <cstdint>
#include <span>

#include "volume/cuts/version.h"
#include "volume/imaging/image_plane.h"

namespace trephine::volume {

/// Combination of samples along the normal through a pixel.
struct Slab {
  enum class Kind : std::uint8_t { mean, maximum };
  double thickness = 0;  ///< mm, half on each side of the plane; 0: only the plane
  Kind kind = Kind::mean;
};
inline constexpr std::string_view k_slab_kinds[] = {"mean", "maximum"};  ///< names of Slab::Kind

/// Implementation: `wide` computes eight pixels at once (AVX2), `any` one by one. Their results are
/// bit-identical.
enum class ResliceCode : std::uint8_t { any, wide };
ResliceCode best_reslice_code() noexcept;

/// Writes the intensities at the pixel centres, row by row from the upper left, trilinear between voxels.
/// They differ by at most one grey level from interpolation in double precision. Pixels farther than half a
/// voxel beyond the outermost voxel centres are set to `outside`. A slab is sampled at intervals of at most
/// half the smallest spacing. Requires a plane that passed check(). The result is identical for any number of
/// threads.
void reslice(const Volume& volume, const ImagePlane& plane, const Slab& slab, std::int16_t outside,
             int threads, std::span<std::int16_t> pixels, ResliceCode code = best_reslice_code());

/// Applies the cuts to pixels of reslice() without a slab: removed matter becomes `air`, with an edge as soft
/// as that of the scan (half a voxel on each side of the surface of the cut).
void reslice_cuts(const Version& version, const ImagePlane& plane, std::int16_t air, int threads,
                  std::span<std::int16_t> pixels);

/// One row of pixels inside the volume. Plain data: the wide code is compiled for newer CPUs and shares no
/// inline code with the rest.
struct ResliceRow {
  const std::int16_t* voxels;
  const float*
      sheet;  ///< if not null, a 2-D array of values in a plane x = constant, used instead of `voxels`
  std::int32_t stride_y, stride_z;
  std::int32_t at[3], step[3];  ///< first pixel and step per pixel, in 2^-20 of a voxel
};
/// Samples a row; AVX2 only. `count`: a multiple of 8.
void reslice_row_wide(const ResliceRow& row, int count, float* values);
void reslice_row_wide(const ResliceRow& row, int count, std::int16_t* pixels);

}  // namespace trephine::volume
