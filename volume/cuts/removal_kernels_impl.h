// Implementation of RemovalKernels, included by both variants in an unnamed namespace that defines `Lanes`.

inline float dot3(const float a[3], const float b[3]) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

/// Merges a sweep's distances into a brick, for any shape, in slices of eight rows.
class BrickMerge {
 public:
  using V = Lanes::V;
  BrickMerge(const SweepShape& shape, const float* old, BrickSweep& out)
      : zero_(Lanes::all(0)),
        band_(Lanes::all(shape.band)),
        deep_(Lanes::all(-shape.band)),
        reach_(Lanes::all(shape.cell_reach - shape.allowance)),
        within_(Lanes::all(-shape.cell_reach - shape.allowance)),
        old_(old),
        out_(out) {}
  /// Merges one vector of distances. `d`: distances minus the allowance. `bit`: first of their samples in
  /// slice z.
  void add(V d, int z, int bit) {
    const int at = 64 * z + bit;
    d = Lanes::max(d, deep_);
    const V before = old_ ? Lanes::load(old_ + at) : band_;
    const V merged = Lanes::min(before, d);
    Lanes::store(out_.distance + at, merged);
    near_ |= Lanes::less(d, band_);
    shallow_ |= Lanes::less(deep_, merged);
    nearer_ |= Lanes::less(d, before);
    kept_ |= static_cast<std::uint64_t>(Lanes::less(zero_, merged)) << bit;
    touched_ |= static_cast<std::uint64_t>(Lanes::less(d, reach_)) << bit;
    inside_ |= static_cast<std::uint64_t>(Lanes::less_equal(d, within_)) << bit;
  }
  void end_slice(int z, std::uint64_t ahead, std::uint64_t past_end) {
    out_.kept[z] = kept_;
    out_.touched[z] = touched_;
    out_.inside[z] = inside_;
    out_.ahead[z] = ahead;
    out_.past_end[z] = past_end;
    kept_ = touched_ = inside_ = 0;
  }
  void finish() {
    out_.is_in_band = near_ != 0;
    out_.is_nearer = old_ == nullptr || nearer_ != 0;
    out_.is_hollow = shallow_ == 0;
  }

 private:
  const V zero_, band_, deep_, reach_, within_;
  const float* old_;
  BrickSweep& out_;
  unsigned near_ = 0, nearer_ = 0, shallow_ = 0;
  std::uint64_t kept_ = 0, touched_ = 0, inside_ = 0;
};

void sweep_brick(const SweepShape& shape, const float corner[3], bool is_ball, const float* old,
                 BrickSweep& out) {
  using V = Lanes::V;
  const V zero = Lanes::all(0), length = Lanes::all(shape.length),
          radius = Lanes::all(shape.radius + shape.allowance), behind = Lanes::all(-shape.cell_reach);
  // A sweep of zero length is a ball everywhere.
  const V beyond = Lanes::all(shape.length > 0 ? shape.length + shape.cell_reach : -1e30f);
  const V ux = Lanes::all(shape.along[0]), uy = Lanes::all(shape.along[1]), uz = Lanes::all(shape.along[2]);
  constexpr int k_parts = 8 / Lanes::k_count;  // vectors in a row of eight samples
  V step[3][k_parts];
  float from[3];
  for (int a = 0; a < 3; ++a) {
    for (int p = 0; p < k_parts; ++p)
      step[a][p] = Lanes::mul(Lanes::counting(p * Lanes::k_count), Lanes::all(shape.ax[a]));
    from[a] = is_ball ? corner[a] - shape.length * shape.along[a] : corner[a];
  }
  BrickMerge merge(shape, old, out);
  for (int z = 0; z < 8; ++z) {
    std::uint64_t ahead = 0, past_end = 0;
    for (int y = 0; y < 8; ++y) {
      float row[3];
      for (int a = 0; a < 3; ++a)
        row[a] = (from[a] + static_cast<float>(y) * shape.ay[a]) + static_cast<float>(z) * shape.az[a];
      for (int p = 0; p < k_parts; ++p) {
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
        merge.add(Lanes::sub(Lanes::root(square), radius), z, bit);
      }
    }
    merge.end_slice(z, is_ball ? ~std::uint64_t{0} : ahead, is_ball ? ~std::uint64_t{0} : past_end);
  }
  merge.finish();
}

// Squared distances use the expansions |c + o|^2 = |c|^2 + 2 c.o + |o|^2 and |w - t u|^2 = |w|^2 + t (t - 2
// w.u). The points of a cell form a grid, so that terms that depend only on x, on y or on z are computed
// once.
template <int N>
struct CellGrid {
  static constexpr int k_row = N < Lanes::k_count ? N : Lanes::k_count;  // points of a row in one vector
  static constexpr int k_x = N / k_row;                                  // vectors along x
  static constexpr int k_rows = Lanes::k_count / k_row;                  // rows in one vector
  static constexpr int k_y = N / k_rows;                                 // vectors along y
};

/// Dot product o.v for the offsets o of a grid, as sum of its parts along x, y and z.
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
  constexpr int k_slices_per_word = 64 / (N * N);
  for (int word = 0; word < N * N * N / 64; ++word) {
    std::uint64_t bits = 0;
    for (int slice = 0; slice < k_slices_per_word; ++slice) {
      const int k = word * k_slices_per_word + slice;
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

/// Signed distances (mm) to a body, from the positions of points along its axis and their distances from it.
class BodyLanes {
 public:
  using V = Lanes::V;
  explicit BodyLanes(const BodyShape& body) : body_(body) {}

  V distance(V along, V off_square) const {
    return body_.is_drum ? drum(along, Lanes::root(off_square)) : cone(along, off_square);
  }
  /// Returns the lanes inside the body: those for which distance() <= 0. Omits terms that only distances
  /// outside require.
  unsigned contains(V along, V off_square) const {
    const V zero = Lanes::all(0);
    if (!body_.is_drum) {
      const V t = nearest_ball(along, off_square), axial = Lanes::sub(along, t);
      const V ball = Lanes::add(Lanes::all(body_.radius), Lanes::mul(t, Lanes::all(body_.growth)));
      return Lanes::less_equal(Lanes::add(off_square, Lanes::mul(axial, axial)), Lanes::mul(ball, ball));
    }
    const V off = Lanes::root(off_square), edge = Lanes::all(body_.edge);
    const Edge at = edge_of(along, off);
    const unsigned is_beyond = Lanes::less(zero, at.beyond);
    const unsigned in_corner = Lanes::less_equal(at.square, Lanes::mul(edge, edge));
    const unsigned in_faces =
        Lanes::less_equal(at.along, edge) & Lanes::less_equal(twice_side(along, off), zero);
    return (is_beyond & in_corner) | (~is_beyond & in_faces);
  }
  /// Distances of points given relative to the start of the sweep.
  V distance(const BodyShape::Stamp& stamp, V x, V y, V z) const {
    const V ux = Lanes::all(stamp.axis[0]), uy = Lanes::all(stamp.axis[1]), uz = Lanes::all(stamp.axis[2]);
    x = Lanes::sub(x, Lanes::all(stamp.at[0]));
    y = Lanes::sub(y, Lanes::all(stamp.at[1]));
    z = Lanes::sub(z, Lanes::all(stamp.at[2]));
    const V along = Lanes::add(Lanes::add(Lanes::mul(x, ux), Lanes::mul(y, uy)), Lanes::mul(z, uz));
    // Avoids |w|^2 - along^2, which cancels near the axis.
    const V ox = Lanes::sub(x, Lanes::mul(along, ux)), oy = Lanes::sub(y, Lanes::mul(along, uy)),
            oz = Lanes::sub(z, Lanes::mul(along, uz));
    return distance(along,
                    Lanes::add(Lanes::add(Lanes::mul(ox, ox), Lanes::mul(oy, oy)), Lanes::mul(oz, oz)));
  }

 private:
  /// Cone: position along the axis of the centre of the nearest ball.
  V nearest_ball(V along, V off_square) const {
    if (body_.slope != 0)
      along = Lanes::sub(along, Lanes::mul(Lanes::all(body_.slope), Lanes::root(off_square)));
    return Lanes::min(Lanes::max(along, Lanes::all(0)), Lanes::all(body_.length));
  }
  V cone(V along, V off_square) const {
    const V t = nearest_ball(along, off_square), axial = Lanes::sub(along, t);
    const V far = Lanes::root(Lanes::add(off_square, Lanes::mul(axial, axial)));
    return Lanes::sub(far, Lanes::add(Lanes::all(body_.radius), Lanes::mul(t, Lanes::all(body_.growth))));
  }
  /// Drum: position relative to the centre of its rounded edge, along the axis and as squared distance;
  /// `beyond` is above 0 where the edge is the nearest part of the surface.
  struct Edge {
    V along, square, beyond;
  };
  Edge edge_of(V along, V off) const {
    const V s = Lanes::magnitude(Lanes::sub(along, Lanes::all(body_.half)));
    const V vs = Lanes::sub(s, Lanes::all(body_.corner)), vo = Lanes::sub(off, Lanes::all(body_.core));
    return {vs, Lanes::add(Lanes::mul(vs, vs), Lanes::mul(vo, vo)),
            Lanes::min(vo, Lanes::sub(Lanes::mul(vs, Lanes::all(body_.lean_cosine)),
                                      Lanes::mul(vo, Lanes::all(body_.lean_sine))))};
  }
  /// Twice the distance to a straight side; for an arc, a value of the same sign.
  V twice_side(V along, V off) const {
    const V u = Lanes::sub(off, Lanes::all(body_.radius)), twice = Lanes::add(u, u);
    if (body_.bulge == 0) return twice;
    const V s = Lanes::sub(along, Lanes::all(body_.half));
    return Lanes::add(Lanes::mul(Lanes::all(body_.bulge), Lanes::add(Lanes::mul(s, s), Lanes::mul(u, u))),
                      twice);
  }
  V drum(V along, V off) const {
    const V one = Lanes::all(1), edge = Lanes::all(body_.edge), k = Lanes::all(body_.bulge);
    V side = twice_side(along, off);
    // Division by 1 + sqrt(1 + k side) gives the distance to the circle without subtracting its large radius.
    side = body_.bulge == 0
               ? Lanes::sub(off, Lanes::all(body_.radius))
               : Lanes::divide(side, Lanes::add(Lanes::root(Lanes::add(Lanes::mul(k, side), one)), one));
    const Edge at = edge_of(along, off);
    const V face = Lanes::max(at.along, Lanes::add(side, edge));
    return Lanes::sub(Lanes::where_positive(at.beyond, Lanes::root(at.square), face), edge);
  }

  const BodyShape& body_;
};

void stamp_brick(const SweepShape& shape, const BodyShape& body, const BodyShape::Stamp* stamps, int count,
                 const float corner[3], const float* old, BrickSweep& out) {
  using V = Lanes::V;
  const V allowance = Lanes::all(shape.allowance);
  const BodyLanes lanes(body);
  BrickMerge merge(shape, old, out);
  for (int z = 0; z < 8; ++z) {
    for (int y = 0; y < 8; ++y) {
      float row[3];
      for (int a = 0; a < 3; ++a)
        row[a] = (corner[a] + static_cast<float>(y) * shape.ay[a]) + static_cast<float>(z) * shape.az[a];
      for (int x = 0; x < 8; x += Lanes::k_count) {
        const V steps = Lanes::counting(x);
        const V px = Lanes::add(Lanes::all(row[0]), Lanes::mul(steps, Lanes::all(shape.ax[0]))),
                py = Lanes::add(Lanes::all(row[1]), Lanes::mul(steps, Lanes::all(shape.ax[1]))),
                pz = Lanes::add(Lanes::all(row[2]), Lanes::mul(steps, Lanes::all(shape.ax[2])));
        V d = Lanes::all(1e30f);
        for (int i = 0; i < count; ++i) d = Lanes::min(d, lanes.distance(stamps[i], px, py, pz));
        merge.add(Lanes::sub(d, allowance), z, 8 * y + x);
      }
    }
    merge.end_slice(z, ~std::uint64_t{0}, 0);
  }
  merge.finish();
}

/// Adds the points of a cell that are in a body at one stamp.
template <int N>
void sample_stamp(const SweepShape& shape, const BodyShape& body, const BodyShape::Stamp& stamp,
                  const CellPoints& points, const float at[3], std::uint64_t* words) {
  using V = Lanes::V;
  using G = CellGrid<N>;
  const float c[3] = {at[0] - stamp.at[0], at[1] - stamp.at[1], at[2] - stamp.at[2]};
  const GridDot<N> twice(points, 2 * dot3(c, shape.ax), 2 * dot3(c, shape.ay), 2 * dot3(c, shape.az));
  const GridDot<N> forward(points, dot3(shape.ax, stamp.axis), dot3(shape.ay, stamp.axis),
                           dot3(shape.az, stamp.axis));
  const V cc = Lanes::all(dot3(c, c)), ct = Lanes::all(dot3(c, stamp.axis)), zero = Lanes::all(0);
  const BodyLanes lanes(body);
  constexpr int k_slices_per_word = 64 / (N * N);
  for (int word = 0; word < N * N * N / 64; ++word) {
    std::uint64_t bits = 0;
    for (int slice = 0; slice < k_slices_per_word; ++slice) {
      const int k = word * k_slices_per_word + slice;
      for (int j = 0; j < G::k_y; ++j) {
        const V base = Lanes::add(cc, Lanes::add(twice.along_y[j], twice.along_z[k])),
                ahead = Lanes::add(ct, Lanes::add(forward.along_y[j], forward.along_z[k]));
        for (int i = 0; i < G::k_x; ++i) {
          const int in_word = slice * N * N + j * G::k_rows * N + i * Lanes::k_count;
          const V square = Lanes::add(Lanes::add(base, twice.along_x[i]),
                                      Lanes::load(points.squared + 64 * word + in_word));
          const V along = Lanes::add(ahead, forward.along_x[i]);
          const V off_square = Lanes::max(Lanes::sub(square, Lanes::mul(along, along)), zero);
          bits |= static_cast<std::uint64_t>(lanes.contains(along, off_square)) << in_word;
        }
      }
    }
    words[word] |= bits;
  }
}

void sample_stamps(const SweepShape& shape, const BodyShape& body, const BodyShape::Stamp* stamps, int count,
                   const CellPoints& points, const float c[3], std::uint64_t* words) {
  const bool is_fine = points.n == 8;
  for (int w = 0; w < (is_fine ? 8 : 1); ++w) words[w] = 0;
  const Lanes::V reach = Lanes::all(shape.cell_reach);
  const BodyLanes lanes(body);
  for (int i = 0; i < count; ++i) {
    const Lanes::V d = lanes.distance(stamps[i], Lanes::all(c[0]), Lanes::all(c[1]), Lanes::all(c[2]));
    if (!Lanes::less_equal(d, reach)) continue;
    if (is_fine)
      sample_stamp<8>(shape, body, stamps[i], points, c, words);
    else
      sample_stamp<4>(shape, body, stamps[i], points, c, words);
  }
}
