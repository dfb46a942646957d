// Included by the two variants, each inside its own unnamed namespace after it has defined `Lanes`.

inline float dot3(const float a[3], const float b[3]) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

void sweep_brick(const SweepShape& shape, const float corner[3], bool is_ball, const float* old,
                 BrickSweep& out) {
  using V = Lanes::V;
  const V zero = Lanes::all(0), length = Lanes::all(shape.length),
          radius = Lanes::all(shape.radius + shape.allowance);
  const V band = Lanes::all(shape.band), deep = Lanes::all(-shape.band);
  const V reach = Lanes::all(shape.cell_reach - shape.allowance),
          within = Lanes::all(-shape.cell_reach - shape.allowance), behind = Lanes::all(-shape.cell_reach);
  // A sweep of no length is a ball everywhere.
  const V beyond = Lanes::all(shape.length > 0 ? shape.length + shape.cell_reach : -1e30f);
  const V ux = Lanes::all(shape.along[0]), uy = Lanes::all(shape.along[1]), uz = Lanes::all(shape.along[2]);
  constexpr int k_parts = 8 / Lanes::k_count;  // vectors in a row of eight voxels
  V step[3][k_parts];
  float from[3];
  for (int a = 0; a < 3; ++a) {
    for (int p = 0; p < k_parts; ++p)
      step[a][p] = Lanes::mul(Lanes::counting(p * Lanes::k_count), Lanes::all(shape.ax[a]));
    from[a] = is_ball ? corner[a] - shape.length * shape.along[a] : corner[a];
  }
  unsigned near = 0, nearer = 0, shallow = 0;
  for (int z = 0; z < 8; ++z) {
    std::uint64_t kept = 0, touched = 0, inside = 0, ahead = 0, past_end = 0;
    for (int y = 0; y < 8; ++y) {
      float row[3];
      for (int a = 0; a < 3; ++a)
        row[a] = (from[a] + static_cast<float>(y) * shape.ay[a]) + static_cast<float>(z) * shape.az[a];
      for (int p = 0; p < k_parts; ++p) {
        const int at = 64 * z + 8 * y + p * Lanes::k_count;
        V qx = Lanes::add(Lanes::all(row[0]), step[0][p]), qy = Lanes::add(Lanes::all(row[1]), step[1][p]);
        V qz = Lanes::add(Lanes::all(row[2]), step[2][p]);
        const int bit = 8 * y + p * Lanes::k_count;
        if (!is_ball) {
          const V wt = Lanes::add(Lanes::add(Lanes::mul(qx, ux), Lanes::mul(qy, uy)), Lanes::mul(qz, uz));
          ahead |= static_cast<std::uint64_t>(Lanes::less_equal(behind, wt)) << bit;
          past_end |= static_cast<std::uint64_t>(Lanes::less_equal(beyond, wt)) << bit;
          const V t = Lanes::min(Lanes::max(wt, zero), length);
          qx = Lanes::sub(qx, Lanes::mul(t, ux));
          qy = Lanes::sub(qy, Lanes::mul(t, uy));
          qz = Lanes::sub(qz, Lanes::mul(t, uz));
        }
        const V square = Lanes::add(Lanes::add(Lanes::mul(qx, qx), Lanes::mul(qy, qy)), Lanes::mul(qz, qz));
        const V d = Lanes::max(Lanes::sub(Lanes::root(square), radius), deep);
        const V before = old ? Lanes::load(old + at) : band;
        const V merged = Lanes::min(before, d);
        Lanes::store(out.distance + at, merged);
        near |= Lanes::less(d, band);
        shallow |= Lanes::less(deep, merged);
        nearer |= Lanes::less(d, before);
        kept |= static_cast<std::uint64_t>(Lanes::less(zero, merged)) << bit;
        touched |= static_cast<std::uint64_t>(Lanes::less(d, reach)) << bit;
        inside |= static_cast<std::uint64_t>(Lanes::less_equal(d, within)) << bit;
      }
    }
    out.kept[z] = kept;
    out.touched[z] = touched;
    out.inside[z] = inside;
    out.ahead[z] = is_ball ? ~std::uint64_t{0} : ahead;
    out.past_end[z] = is_ball ? ~std::uint64_t{0} : past_end;
  }
  out.is_in_band = near != 0;
  out.is_nearer = old == nullptr || nearer != 0;
  out.is_hollow = shallow == 0;
}

// Squared distances by the expansion |c + o|^2 = |c|^2 + 2 c.o + |o|^2, and |w - t u|^2 = |w|^2 + t (t - 2
// w.u).
template <bool IsBall>
void sample_cell(const SweepShape& shape, const CellPoints& points, const float c[3], std::uint64_t* words) {
  using V = Lanes::V;
  const V cc = Lanes::all(dot3(c, c) - shape.radius * shape.radius), ct = Lanes::all(dot3(c, shape.along));
  const V x = Lanes::all(2 * dot3(c, shape.ax)), y = Lanes::all(2 * dot3(c, shape.ay)),
          z = Lanes::all(2 * dot3(c, shape.az));
  const V tx = Lanes::all(dot3(shape.ax, shape.along)), ty = Lanes::all(dot3(shape.ay, shape.along));
  const V tz = Lanes::all(dot3(shape.az, shape.along)), zero = Lanes::all(0), end = Lanes::all(shape.length);
  const int count = points.n * points.n * points.n;
  for (int word = 0; word < count / 64; ++word) {
    std::uint64_t bits = 0;
    for (int i = 0; i < 64; i += Lanes::k_count) {
      const int at = 64 * word + i;
      const V ox = Lanes::load(points.x + at), oy = Lanes::load(points.y + at),
              oz = Lanes::load(points.z + at);
      const V base = Lanes::add(cc, Lanes::add(Lanes::mul(oy, y), Lanes::mul(oz, z)));
      V d = Lanes::add(Lanes::add(base, Lanes::mul(ox, x)), Lanes::load(points.squared + at));
      if constexpr (!IsBall) {
        const V wt = Lanes::add(Lanes::add(ct, Lanes::add(Lanes::mul(oy, ty), Lanes::mul(oz, tz))),
                                Lanes::mul(ox, tx));
        const V t = Lanes::min(Lanes::max(wt, zero), end);
        d = Lanes::add(d, Lanes::mul(t, Lanes::sub(t, Lanes::add(wt, wt))));
      }
      bits |= static_cast<std::uint64_t>(Lanes::less_equal(d, zero)) << i;
    }
    words[word] = bits;
  }
}

void sample(const SweepShape& shape, const CellPoints& points, const float c[3], bool is_ball,
            std::uint64_t* words) {
  if (!is_ball) return sample_cell<false>(shape, points, c, words);
  float end[3];
  for (int a = 0; a < 3; ++a) end[a] = c[a] - shape.length * shape.along[a];
  sample_cell<true>(shape, points, end, words);
}
