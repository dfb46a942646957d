// NanoVDB as a peer for rays. C++17, free of our headers.
#pragma once

namespace trephine::bench {

struct NanoGrid;
/// `words`: one bit per voxel, in rows along x of `words_per_row` words of 64 bits.
NanoGrid* make_nano_grid(const unsigned long long* words, int words_per_row, const int size[3]);
void free_nano_grid(NanoGrid* grid);
/// Finds first hits; returns seconds. `rays`: six numbers each, start and end in voxels; `voxels`: three
/// each, first -1 without a hit; `epsilon`: advance of each step into the next node (voxels).
double run_nano_rays(const NanoGrid& grid, const double* rays, int count, int* voxels, float epsilon);

}  // namespace trephine::bench
