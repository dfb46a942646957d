// Included by each variant in its own anonymous namespace, after its `Lanes`.

/// Eight rays at a plane: their voxels along an axis, and how far in, in 2^-32 of a voxel.
struct Place {
  Lanes::I voxel, fraction;
};

/// `at`, `slope`: of RayPacket; k: the plane. Recomputed from doubles: nothing accumulates beyond 8 slabs.
inline Place place_at(const double* at, const double* slope, const std::int32_t* mirror, double k) {
  Place place;
  Lanes::split(at, slope, k, place.voxel, place.fraction);
  place.voxel = Lanes::exclusive_or(place.voxel, Lanes::load(mirror));
  return place;
}

/// Weights of voxels of these intensities.
inline Lanes::F weigh(const SlabVolume& volume, Lanes::I intensity) {
  const Lanes::I zero = Lanes::all(0);
  const Lanes::I over = Lanes::max(Lanes::sub(intensity, Lanes::all(volume.zero)), zero);
  const Lanes::I low = Lanes::min(over, Lanes::all(volume.knee_above));
  return Lanes::where(Lanes::is_above(intensity, volume.none),
                      Lanes::add(Lanes::mul(Lanes::real(low), Lanes::all(volume.below)),
                                 Lanes::mul(Lanes::real(Lanes::sub(over, low)), Lanes::all(volume.above))));
}

/// Offset of the next voxel along an axis, by the lane's direction.
inline Lanes::I turn_of(const std::int32_t* mirror, std::int32_t stride) {
  const Lanes::I m = Lanes::load(mirror);
  return Lanes::sub(Lanes::exclusive_or(Lanes::all(stride), m), m);
}

/// Rays that stay within the sides: a voxel is its offset in the slab.
struct Inside {
  struct At {
    Lanes::I offset;
  };
  Lanes::I step_a, step_b;

  Inside(const SlabVolume& volume, const RayPacket& rays)
      : step_a(turn_of(rays.mirror_a, volume.stride_a)), step_b(turn_of(rays.mirror_b, volume.stride_b)) {}
  static At at(const SlabVolume& volume, Lanes::I a, Lanes::I b) {
    return {Lanes::add(Lanes::times(a, volume.stride_a), Lanes::times(b, volume.stride_b))};
  }
  /// Further along a where `over_a`, along b where `over_b`.
  At moved(const At& from, Lanes::I over_a, Lanes::I over_b) const {
    return {Lanes::add(from.offset, Lanes::add(Lanes::both(over_a, step_a), Lanes::both(over_b, step_b)))};
  }
  static Lanes::F weight(const SlabVolume& volume, const std::int16_t* slab, const At& at) {
    return weigh(volume, Lanes::gather(slab, at.offset));
  }
};

/// Rays that may leave: beyond the sides voxels count nothing, and are not read.
struct Border {
  struct At {
    Lanes::I a, b;
  };
  Lanes::I step_a, step_b;

  Border(const SlabVolume&, const RayPacket& rays)
      : step_a(turn_of(rays.mirror_a, 1)), step_b(turn_of(rays.mirror_b, 1)) {}
  static At at(const SlabVolume&, Lanes::I a, Lanes::I b) { return {a, b}; }
  At moved(const At& from, Lanes::I over_a, Lanes::I over_b) const {
    return {Lanes::add(from.a, Lanes::both(over_a, step_a)), Lanes::add(from.b, Lanes::both(over_b, step_b))};
  }
  static Lanes::F weight(const SlabVolume& volume, const std::int16_t* slab, const At& at) {
    const Lanes::I mask =
        Lanes::both(Lanes::is_below(at.a, volume.size_a), Lanes::is_below(at.b, volume.size_b));
    const Lanes::I offset =
        Lanes::add(Lanes::times(at.a, volume.stride_a), Lanes::times(at.b, volume.stride_b));
    return Lanes::where(mask,
                        weigh(volume, Lanes::gather_safely(slab, Lanes::both(offset, mask), volume.last)));
  }
};

template <class Sides>
void exact_in(const SlabVolume& volume, const RayPacket& rays, int k, int count, double* sums) {
  const Place a = place_at(rays.a, rays.slope_a, rays.mirror_a, k);
  const Place b = place_at(rays.b, rays.slope_b, rays.mirror_b, k);
  Lanes::I fraction_a = a.fraction, fraction_b = b.fraction;
  const Lanes::I step_a = Lanes::load(rays.step_a), step_b = Lanes::load(rays.step_b);
  const Lanes::F per_a = Lanes::load(rays.per_a), per_b = Lanes::load(rays.per_b);
  const Lanes::F one = Lanes::all(1.0f);
  const std::int16_t* slab = volume.voxels + k * volume.stride_d;
  const Sides sides(volume, rays);
  typename Sides::At at = Sides::at(volume, a.voxel, b.voxel);
  Lanes::F sum = Lanes::all(0.0f);
  for (int i = 0; i < count; ++i, slab += volume.stride_d) {
    const Lanes::I next_a = Lanes::add(fraction_a, step_a), next_b = Lanes::add(fraction_b, step_b);
    const Lanes::I over_a = Lanes::has_wrapped(next_a, step_a), over_b = Lanes::has_wrapped(next_b, step_b);
    const Lanes::F first = Sides::weight(volume, slab, at);
    if (!Lanes::any(Lanes::either(over_a, over_b))) {
      sum = Lanes::add(sum, first);
    } else {
      // Position in the slab, 0 to 1, at which the ray crosses into the next voxel along a, along b; 1: it
      // does not.
      const Lanes::F at_a = Lanes::min(
          one, Lanes::choose(over_a, Lanes::mul(Lanes::real(Lanes::rest(fraction_a)), per_a), one));
      const Lanes::F at_b = Lanes::min(
          one, Lanes::choose(over_b, Lanes::mul(Lanes::real(Lanes::rest(fraction_b)), per_b), one));
      const Lanes::F early = Lanes::min(at_a, at_b), late = Lanes::max(at_a, at_b);
      const Lanes::I is_a_first = Lanes::less(at_a, at_b);
      const typename Sides::At middle =
          sides.moved(at, Lanes::both(over_a, is_a_first), Lanes::except(over_b, is_a_first));
      sum = Lanes::add(sum, Lanes::mul(first, early));
      sum = Lanes::add(sum, Lanes::mul(Sides::weight(volume, slab, middle), Lanes::sub(late, early)));
      at = sides.moved(at, over_a, over_b);
      if (Lanes::any(Lanes::both(over_a, over_b)))
        sum = Lanes::add(sum, Lanes::mul(Sides::weight(volume, slab, at), Lanes::sub(one, late)));
    }
    fraction_a = next_a, fraction_b = next_b;
  }
  Lanes::add_to(sums, sum);
}

template <class Sides>
void joseph_in(const SlabVolume& volume, const RayPacket& rays, int k, int count, double* sums) {
  const std::int16_t* slab = volume.voxels + k * volume.stride_d;
  const Sides sides(volume, rays);
  const Lanes::I yes = Lanes::all(-1), no = Lanes::all(0);
  // Half a voxel back: between voxels' middles.
  double a_back[8], b_back[8];
  for (int lane = 0; lane < 8; ++lane) a_back[lane] = rays.a[lane] - 0.5, b_back[lane] = rays.b[lane] - 0.5;
  Lanes::F sum = Lanes::all(0.0f);
  const Lanes::F one = Lanes::all(1.0f);
  for (int i = 0; i < count; ++i, slab += volume.stride_d) {
    const Place a = place_at(a_back, rays.slope_a, rays.mirror_a, k + i + 0.5);
    const Place b = place_at(b_back, rays.slope_b, rays.mirror_b, k + i + 0.5);
    const Lanes::F share_a = Lanes::share(a.fraction), share_b = Lanes::share(b.fraction);
    const typename Sides::At at = Sides::at(volume, a.voxel, b.voxel);
    const auto along_a = [&](Lanes::I over_b) {
      return Lanes::add(
          Lanes::mul(Sides::weight(volume, slab, sides.moved(at, no, over_b)), Lanes::sub(one, share_a)),
          Lanes::mul(Sides::weight(volume, slab, sides.moved(at, yes, over_b)), share_a));
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
