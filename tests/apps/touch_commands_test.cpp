// trephine touch: what it says of forces.
#include <cmath>

#include "tests/apps/command_fixture.h"

namespace trephine::command_tests {
namespace {

/// A spring that is sampled and smoothed returns more than it took, and no more than theory lets it.
TEST_F(Command, TheForceAloneReturnsNoMoreThanSamplingAllows) {
  ASSERT_EQ(run("phantom sphere --size 48 --psf 1 -o s.mha").exit_code, 0);
  std::ostringstream path;
  path << "t,x,y,z\n";
  for (int i = 0; i < 10 * 160; ++i)
    path << 1e-3 * i << ',' << 0.3 * std::cos(i / 160) << ",0,"
         << 41 + 8 * std::abs(2 * (i % 160) / 160.0 - 1) << '\n';
  write("p.csv", path.str());
  const auto energy = [&](const std::string& options) {
    return json("touch s.mha --path p.csv -o o" + std::to_string(std::hash<std::string>{}(options)) +
                ".csv --friction 0,0 " + options)["energy_nmm"];
  };
  for (const char* options : {"", "--stiffness 2", "--rate 5000", "--alpha 0.8"}) {
    const Json e = energy(options);
    EXPECT_LE(e["returned"].get<double>(), e["returned_at_most"].get<double>()) << options;
    EXPECT_GT(e["returned_at_most"].get<double>(), 1) << options;
  }
  const double plain = energy("")["returned"], passive = energy("--passive")["returned"];
  EXPECT_GT(plain, 1) << "the figure sees it";
  EXPECT_LT(passive, 0.05 * plain);
}

}  // namespace
}  // namespace trephine::command_tests
