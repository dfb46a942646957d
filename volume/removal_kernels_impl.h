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
// w.u). The points of a cell are a grid: what depends on x, on y or on z alone is made once.
template <int N>
struct CellGrid {
  static constexpr int k_row = N < Lanes::k_count ? N : Lanes::k_count;  // points of a row in one vector
  static constexpr int k_x = N / k_row;                                  // vectors along x
  static constexpr int k_rows = Lanes::k_count / k_row;                  // rows in one vector
  static constexpr int k_y = N / k_rows;                                 // vectors along y
};

/// o.v for the offsets o of a grid, by their parts along x, y and z.
template <int N>
struct GridDot {
  Lanes::V along_x[CellGrid<N>::k_x], along_y[CellGrid<N>::k_y], along_z[N];

  GridDot(const CellPoints& points, float x, float y, float z) {
    using G = CellGrid<N>;
    for (int i = 0; i < G::k_x; ++i)
      along_x[i] = Lanes::mul(Lanes::load(points.x + i * Lanes::k_count), Lanes::all(x));
    for (int j = 0; j < G::k_y; ++j)
      along_y[j] = Lanes::mul(Lanes::load(points.y + j * G::k_rows * N), Lanes::all(y));
    for (int k = 0; k < N; ++k) along_z[k] = Lanes::mul(Lanes::all(points.z[k * N * N]), Lanes::all(z));
  }
};

template <bool IsBall, int N>
void sample_cell(const SweepShape& shape, const CellPoints& points, const float c[3], std::uint64_t* words) {
  using V = Lanes::V;
  using G = CellGrid<N>;
  const V cc = Lanes::all(dot3(c, c) - shape.radius * shape.radius);
  const GridDot<N> twice(points, 2 * dot3(c, shape.ax), 2 * dot3(c, shape.ay), 2 * dot3(c, shape.az));
  const GridDot<N> forward(points, dot3(shape.ax, shape.along), dot3(shape.ay, shape.along),
                           dot3(shape.az, shape.along));
  const V ct = Lanes::all(dot3(c, shape.along)), zero = Lanes::all(0), end = Lanes::all(shape.length);
  constexpr int k_slices_a_word = 64 / (N * N);
  for (int word = 0; word < N * N * N / 64; ++word) {
    std::uint64_t bits = 0;
    for (int slice = 0; slice < k_slices_a_word; ++slice) {
      const int k = word * k_slices_a_word + slice;
      for (int j = 0; j < G::k_y; ++j) {
        const V base = Lanes::add(cc, Lanes::add(twice.along_y[j], twice.along_z[k]));
        for (int i = 0; i < G::k_x; ++i) {
          const int in_word = slice * N * N + j * G::k_rows * N + i * Lanes::k_count;
          V d = Lanes::add(Lanes::add(base, twice.along_x[i]),
                           Lanes::load(points.squared + 64 * word + in_word));
          if constexpr (!IsBall) {
            const V wt = Lanes::add(Lanes::add(ct, Lanes::add(forward.along_y[j], forward.along_z[k])),
                                    forward.along_x[i]);
            const V t = Lanes::min(Lanes::max(wt, zero), end);
            d = Lanes::add(d, Lanes::mul(t, Lanes::sub(t, Lanes::add(wt, wt))));
          }
          bits |= static_cast<std::uint64_t>(Lanes::less_equal(d, zero)) << in_word;
        }
      }
    }
    words[word] = bits;
  }
}

void sample(const SweepShape& shape, const CellPoints& points, const float c[3], bool is_ball,
            std::uint64_t* words) {
  const bool is_fine = points.n == 8;
  if (!is_ball)
    return is_fine ? sample_cell<false, 8>(shape, points, c, words)
                   : sample_cell<false, 4>(shape, points, c, words);
  float end[3];
  for (int a = 0; a < 3; ++a) end[a] = c[a] - shape.length * shape.along[a];
  return is_fine ? sample_cell<true, 8>(shape, points, end, words)
                 : sample_cell<true, 4>(shape, points, end, words);
}
