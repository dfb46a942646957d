#include "apps/verify/solid_judge.h"

namespace trephine::verify {

namespace {

__extension__ typedef __int128 Int128;
using Point = std::array<std::int64_t, 3>;

Int128 determinant(const std::array<Int128, 3>& a, const std::array<Int128, 3>& b,
                   const std::array<Int128, 3>& c) {
  return a[0] * (b[1] * c[2] - b[2] * c[1]) - a[1] * (b[0] * c[2] - b[2] * c[0]) +
         a[2] * (b[0] * c[1] - b[1] * c[0]);
}
std::array<Int128, 3> minus(const Point& a, const Point& b) {
  return {Int128{a[0]} - b[0], Int128{a[1]} - b[1], Int128{a[2]} - b[2]};
}
int sign_of(Int128 v) { return v > 0 ? 1 : v < 0 ? -1 : 0; }

/// Returns the side of the plane through b, c and d on which p + (e, e^2, e^3) is, with a positive
/// infinitesimal e; 0 if b, c and d are collinear.
int side_of(const Point& p, const Point& b, const Point& c, const Point& d) {
  if (const int side = sign_of(determinant(minus(p, b), minus(c, b), minus(d, b)))) return side;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    std::array<Int128, 3> step{0, 0, 0};
    step[axis] = 1;
    if (const int moved = sign_of(determinant(step, minus(c, b), minus(d, b)))) return moved;
  }
  return 0;
}

}  // namespace

int winding(const IntegerMesh& mesh, const Point& p) {
  static constexpr Point far{1'987'654'321, -1'876'543'219, 1'765'432'198};
  int sum = 0;
  for (std::size_t t = 0; t + 2 < mesh.triangles.size(); t += 3) {
    const Point &a = mesh.corners[mesh.triangles[t]], &b = mesh.corners[mesh.triangles[t + 1]],
                &c = mesh.corners[mesh.triangles[t + 2]];
    const int whole = sign_of(determinant(minus(a, far), minus(b, far), minus(c, far)));
    if (whole == 0) continue;
    // The tetrahedron contains p if it keeps its orientation with p in place of each corner.
    if (side_of(p, far, b, c) == whole && side_of(p, far, c, a) == whole && side_of(p, far, a, b) == whole &&
        side_of(p, a, c, b) == whole)
      sum += whole;
  }
  return sum;
}

}  // namespace trephine::verify
