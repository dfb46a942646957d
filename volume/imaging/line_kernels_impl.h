// Implementation of LineKernels, included by each variant in an anonymous namespace that defines `Lanes`.

/// Coordinates of eight rays along one axis in a plane d = k: voxel, and fraction of it in units of 2^-32.
struct Crossing {
  Lanes::I voxel, fraction;
};

/// Computes the crossing in double precision. `start`: coordinates of the rays in the plane d = 0
/// (RayPacket::a or b; joseph_in() shifts them by half a voxel); `slope`, `mirror`: those of RayPacket along
/// the same axis. joseph_in() computes every crossing. exact_in() computes one per axis and call, and
/// advances it in fixed point; a call has at most 8 slabs, which bounds the accumulated error.
inline Crossing crossing_at(const double* start, const double* slope, const std::int32_t* mirror, double k) {
  Crossing crossing;
  Lanes::split(start, slope, k, crossing.voxel, crossing.fraction);
  crossing.voxel = Lanes::bit_xor(crossing.voxel, Lanes::load(mirror));
  return crossing;
}

/// Weights of voxels with these intensities.
inline Lanes::F weigh(const SlabVolume& volume, Lanes::I intensity) {
  const Lanes::I zero = Lanes::all(0);
  const Lanes::I over = Lanes::max(Lanes::sub(intensity, Lanes::all(volume.zero)), zero);
  const Lanes::I low = Lanes::min(over, Lanes::all(volume.knee_above));
  return Lanes::keep_where(
      Lanes::is_above(intensity, volume.highest_weightless),
      Lanes::add(Lanes::mul(Lanes::real(low), Lanes::all(volume.below)),
                 Lanes::mul(Lanes::real(Lanes::sub(over, low)), Lanes::all(volume.above))));
}

/// Offset to the next voxel along an axis, in the direction of each lane.
inline Lanes::I signed_stride(const std::int32_t* mirror, std::int32_t stride) {
  const Lanes::I m = Lanes::load(mirror);
  return Lanes::sub(Lanes::bit_xor(Lanes::all(stride), m), m);
}

/// Voxel access for rays that stay inside the volume: a voxel is its offset in the slab.
struct Inside {
  struct Voxel {
    Lanes::I offset;
  };
  Lanes::I step_a, step_b;

  Inside(const SlabVolume& volume, const RayPacket& rays)
      : step_a(signed_stride(rays.mirror_a, volume.stride_a)),
        step_b(signed_stride(rays.mirror_b, volume.stride_b)) {}
  static Voxel voxel(const SlabVolume& volume, Lanes::I a, Lanes::I b) {
    return {Lanes::add(Lanes::times(a, volume.stride_a), Lanes::times(b, volume.stride_b))};
  }
  /// Moves one voxel along a in lanes of `over_a` and along b in lanes of `over_b`.
  Voxel neighbour(const Voxel& v, Lanes::I over_a, Lanes::I over_b) const {
    return {Lanes::add(v.offset, Lanes::add(Lanes::bit_and(over_a, step_a), Lanes::bit_and(over_b, step_b)))};
  }
  static Lanes::F weight(const SlabVolume& volume, const std::int16_t* slab, const Voxel& v) {
    return weigh(volume, Lanes::gather(slab, v.offset));
  }
};

/// Voxel access for rays that may leave the volume: voxels outside have weight 0 and are not read.
struct Border {
  struct Voxel {
    Lanes::I a, b;
  };
  Lanes::I step_a, step_b;

  Border(const SlabVolume&, const RayPacket& rays)
      : step_a(signed_stride(rays.mirror_a, 1)), step_b(signed_stride(rays.mirror_b, 1)) {}
  static Voxel voxel(const SlabVolume&, Lanes::I a, Lanes::I b) { return {a, b}; }
  Voxel neighbour(const Voxel& v, Lanes::I over_a, Lanes::I over_b) const {
    return {Lanes::add(v.a, Lanes::bit_and(over_a, step_a)), Lanes::add(v.b, Lanes::bit_and(over_b, step_b))};
  }
  static Lanes::F weight(const SlabVolume& volume, const std::int16_t* slab, const Voxel& v) {
    const Lanes::I mask =
        Lanes::bit_and(Lanes::is_below(v.a, volume.size_a), Lanes::is_below(v.b, volume.size_b));
    const Lanes::I offset =
        Lanes::add(Lanes::times(v.a, volume.stride_a), Lanes::times(v.b, volume.stride_b));
    return Lanes::keep_where(
        mask, weigh(volume, Lanes::gather_safely(slab, Lanes::bit_and(offset, mask), volume.last)));
  }
};

template <class VoxelAccess>
void exact_in(const SlabVolume& volume, const RayPacket& rays, int k, int count, double* sums) {
  const Crossing a = crossing_at(rays.a, rays.slope_a, rays.mirror_a, k);
  const Crossing b = crossing_at(rays.b, rays.slope_b, rays.mirror_b, k);
  Lanes::I fraction_a = a.fraction, fraction_b = b.fraction;
  const Lanes::I step_a = Lanes::load(rays.step_a), step_b = Lanes::load(rays.step_b);
  const Lanes::F per_a = Lanes::load(rays.per_a), per_b = Lanes::load(rays.per_b);
  const Lanes::F one = Lanes::all(1.0f);
  const std::int16_t* slab = volume.voxels + k * volume.stride_d;
  const VoxelAccess access(volume, rays);
  typename VoxelAccess::Voxel voxel = VoxelAccess::voxel(volume, a.voxel, b.voxel);
  Lanes::F sum = Lanes::all(0.0f);
  for (int i = 0; i < count; ++i, slab += volume.stride_d) {
    const Lanes::I next_a = Lanes::add(fraction_a, step_a), next_b = Lanes::add(fraction_b, step_b);
    const Lanes::I over_a = Lanes::has_wrapped(next_a, step_a), over_b = Lanes::has_wrapped(next_b, step_b);
    const Lanes::F first = VoxelAccess::weight(volume, slab, voxel);
    if (!Lanes::any(Lanes::bit_or(over_a, over_b))) {
      sum = Lanes::add(sum, first);
    } else {
      // Positions in the slab, 0 to 1, at which rays enter the next voxel along a and b; 1 if they do not.
      const Lanes::F t_a = Lanes::min(
          one, Lanes::choose(over_a, Lanes::mul(Lanes::real(Lanes::to_next(fraction_a)), per_a), one));
      const Lanes::F t_b = Lanes::min(
          one, Lanes::choose(over_b, Lanes::mul(Lanes::real(Lanes::to_next(fraction_b)), per_b), one));
      const Lanes::F early = Lanes::min(t_a, t_b), late = Lanes::max(t_a, t_b);
      const Lanes::I is_a_first = Lanes::less(t_a, t_b);
      const typename VoxelAccess::Voxel middle =
          access.neighbour(voxel, Lanes::bit_and(over_a, is_a_first), Lanes::bit_and_not(over_b, is_a_first));
      sum = Lanes::add(sum, Lanes::mul(first, early));
      sum = Lanes::add(sum, Lanes::mul(VoxelAccess::weight(volume, slab, middle), Lanes::sub(late, early)));
      voxel = access.neighbour(voxel, over_a, over_b);
      if (Lanes::any(Lanes::bit_and(over_a, over_b)))
        sum = Lanes::add(sum, Lanes::mul(VoxelAccess::weight(volume, slab, voxel), Lanes::sub(one, late)));
    }
    fraction_a = next_a, fraction_b = next_b;
  }
  Lanes::add_to(sums, sum);
}

template <class VoxelAccess>
void joseph_in(const SlabVolume& volume, const RayPacket& rays, int k, int count, double* sums) {
  const std::int16_t* slab = volume.voxels + k * volume.stride_d;
  const VoxelAccess access(volume, rays);
  const Lanes::I yes = Lanes::all(-1), no = Lanes::all(0);
  // Shifted by half a voxel, to interpolate between voxel centres.
  double start_a[8], start_b[8];
  for (int lane = 0; lane < 8; ++lane) start_a[lane] = rays.a[lane] - 0.5, start_b[lane] = rays.b[lane] - 0.5;
  Lanes::F sum = Lanes::all(0.0f);
  const Lanes::F one = Lanes::all(1.0f);
  for (int i = 0; i < count; ++i, slab += volume.stride_d) {
    const Crossing a = crossing_at(start_a, rays.slope_a, rays.mirror_a, k + i + 0.5);
    const Crossing b = crossing_at(start_b, rays.slope_b, rays.mirror_b, k + i + 0.5);
    const Lanes::F share_a = Lanes::to_float(a.fraction), share_b = Lanes::to_float(b.fraction);
    const typename VoxelAccess::Voxel voxel = VoxelAccess::voxel(volume, a.voxel, b.voxel);
    const auto along_a = [&](Lanes::I over_b) {
      return Lanes::add(
          Lanes::mul(VoxelAccess::weight(volume, slab, access.neighbour(voxel, no, over_b)),
                     Lanes::sub(one, share_a)),
          Lanes::mul(VoxelAccess::weight(volume, slab, access.neighbour(voxel, yes, over_b)), share_a));
    };
    sum = Lanes::add(sum, Lanes::add(Lanes::mul(along_a(no), Lanes::sub(one, share_b)),
                                     Lanes::mul(along_a(yes), share_b)));
  }
  Lanes::add_to(sums, sum);
}

void exact(const SlabVolume& volume, const RayPacket& rays, int k, int count, bool is_inside, double* sums) {
  is_inside ? exact_in<Inside>(volume, rays, k, count, sums) : exact_in<Border>(volume, rays, k, count, sums);
}

void joseph(const SlabVolume& volume, const RayPacket& rays, int k, int count, bool is_inside, double* sums) {
  is_inside ? joseph_in<Inside>(volume, rays, k, count, sums)
            : joseph_in<Border>(volume, rays, k, count, sums);
}
