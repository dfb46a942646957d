#include "tests/checker/solid_judge.h"

namespace trephine::checker {

namespace {

__extension__ typedef __int128 Int128;
using Place = std::array<std::int64_t, 3>;

Int128 determinant(const std::array<Int128, 3>& a, const std::array<Int128, 3>& b,
                   const std::array<Int128, 3>& c) {
  return a[0] * (b[1] * c[2] - b[2] * c[1]) - a[1] * (b[0] * c[2] - b[2] * c[0]) +
         a[2] * (b[0] * c[1] - b[1] * c[0]);
}
std::array<Int128, 3> minus(const Place& a, const Place& b) {
  return {Int128{a[0]} - b[0], Int128{a[1]} - b[1], Int128{a[2]} - b[2]};
}
int sign_of(Int128 v) { return v > 0 ? 1 : v < 0 ? -1 : 0; }

/// On which side of the plane through b, c, d lies p + (e, e^2, e^3)? 0: the three are on a line.
int side_of(const Place& p, const Place& b, const Place& c, const Place& d) {
  if (const int at = sign_of(determinant(minus(p, b), minus(c, b), minus(d, b)))) return at;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    std::array<Int128, 3> step{0, 0, 0};
    step[axis] = 1;
    if (const int moved = sign_of(determinant(step, minus(c, b), minus(d, b)))) return moved;
  }
  return 0;
}

}  // namespace

int winding(const WholeMesh& mesh, const Place& p) {
  static constexpr Place far{1'987'654'321, -1'876'543'219, 1'765'432'198};
  int sum = 0;
  for (std::size_t t = 0; t + 2 < mesh.triangles.size(); t += 3) {
    const Place &a = mesh.corners[mesh.triangles[t]], &b = mesh.corners[mesh.triangles[t + 1]],
                &c = mesh.corners[mesh.triangles[t + 2]];
    const int whole = sign_of(determinant(minus(a, far), minus(b, far), minus(c, far)));
    if (whole == 0) continue;
    // With p in the place of each corner in turn, the tetrahedron must not turn inside out.
    if (side_of(p, far, b, c) == whole && side_of(p, far, c, a) == whole && side_of(p, far, a, b) == whole &&
        side_of(p, a, c, b) == whole)
      sum += whole;
  }
  return sum;
}

}  // namespace trephine::checker
