// Models of titanium, steel and soft tissue in images, forbidden models, and the models and plan of a case.
#include <cstdio>
#include <cstring>

#include "tests/apps/command_fixture.h"

namespace trephine::command_tests {
namespace {

/// Returns a PLY file (LPS) of a box with its faces outward, centred at (x, y, z).
std::string box_ply(double x, double y, double z, double half_x, double half_y, double half_z) {
  std::ostringstream out;
  out << "ply\nformat ascii 1.0\ncomment SPACE=LPS\nelement vertex 8\nproperty float x\nproperty float y\n"
         "property float z\nelement face 12\nproperty list uchar int vertex_indices\nend_header\n";
  for (int i = 0; i < 8; ++i)
    out << x + (i & 1 ? half_x : -half_x) << ' ' << y + (i & 2 ? half_y : -half_y) << ' '
        << z + (i & 4 ? half_z : -half_z) << '\n';
  constexpr int k_triangles[12][3] = {{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6}, {0, 1, 4}, {1, 5, 4},
                                      {2, 6, 3}, {3, 6, 7}, {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};
  for (const auto& t : k_triangles) out << "3 " << t[0] << ' ' << t[1] << ' ' << t[2] << '\n';
  return out.str();
}

/// A rod in the spinal canal counts as outside bone if it is metal, but not if it is soft tissue, such as a
/// nerve. In an X-ray its attenuation is that of its matter.
TEST_F(Command, AModelHasMatter) {
  write("rod.ply", box_ply(0, 22, 5.8, 2, 2, 20));
  const std::string plane = "section spine --mesh rod.ply --at 0,22,5.8 --normal 0,0,1 --pixel 0.1 -o s.png";
  for (const char* metal : {"titanium", "steel"}) {
    const Json section = json(plane + " --mesh-matter " + metal);
    EXPECT_NEAR(section["models_mm2"].get<double>(), 16, 0.5) << metal;
    EXPECT_GT(section["models_outside_bone_mm2"].get<double>(), 10) << metal;
  }
  const Json soft = json(plane + " --mesh-matter soft-tissue --svg s.svg");
  EXPECT_EQ(soft.value("models_outside_bone_mm2", 0.0), 0);
  EXPECT_NE(read(file("s.svg")).find("<title>model 1"), std::string::npos) << "it is drawn";
  // In an X-ray a denser matter has larger line integrals. Soft tissue instead of the dural sac changes
  // nearly nothing.
  const auto total_of = [&](const std::string& matter) {
    const std::string model = matter.empty() ? "" : " --mesh rod.ply --mesh-matter " + matter;
    const Json image = json("fluoro spine --view ap --pixels 64 -o x.png --sums x.mha" + model);
    const std::string sums = read(file("x.mha"));
    double total = 0;
    const std::size_t data = sums.size() - 64 * 64 * sizeof(float);
    for (std::size_t i = 0; i < 64 * 64; ++i) {
      float value = 0;
      std::memcpy(&value, sums.data() + data + i * sizeof(float), sizeof value);
      total += static_cast<double>(value);
    }
    return total;
  };
  const double none = total_of(""), bone = total_of("bone"), titanium = total_of("titanium");
  EXPECT_NEAR(total_of("soft-tissue"), none, 1e-3 * none);
  EXPECT_GT(bone, none + 1);
  EXPECT_GT(titanium, bone + 1);
  EXPECT_GT(total_of("steel"), titanium + 1);
  const ProcessResult bad = run(plane + " --mesh-matter wood");
  EXPECT_NE(bad.exit_code, 0);
  EXPECT_NE(bad.err.find("titanium"), std::string::npos) << bad.err;
}

/// A case with a nerve as a model: hands touch it, and a burr that enters it is reported. The session
/// contains the model and the plan, so that it needs no case.
TEST_F(Command, ACaseHasModelsAndItsSessionKeepsThemAndThePlan) {
  ASSERT_EQ(run("phantom spine --case spine").exit_code, 0);
  write("spine/root.ply", box_ply(30, 60, -13, 3, 3, 3));
  std::string text = read(file("spine/case.toml"));
  text +=
      "\n[[models]]\nname = \"left root\"\nfile = \"root.ply\"\nmatter = \"soft-tissue\"\nforbidden = true\n"
      "\n[[outlines]]\nname = \"window\"\npoints = [[0.0, 50.0, 0.0], [10.0, 50.0, 0.0], [0.0, 50.0, 10.0]]\n"
      "\n[[planes]]\nname = \"cut\"\nat = [0.0, 0.0, 0.0]\nnormal = [0.0, 0.0, 2.0]\n";
  write("spine/case.toml", text);
  write("r.toml", R"(schema = 1
scan = "./spine"
rate = 500
[[hands]]
instrument = "burr"
parameters = "diameter=4 removal_rate=200"
method = "scene"
points = [[0, 30, 80, -13, 0], [0.3, 30, 66, -13, 1], [1, 30, 62, -13, 1], [1.2, 30, 80, -13, 0]]

[[expect]]
what = "events forbidden-entered"
least = 1
)");
  const Json played = json("run r.toml --record r.session --embed");
  ASSERT_TRUE(played.is_object());
  EXPECT_EQ(played["is_met"], true) << played.dump(1);
  EXPECT_NE(run("timeline r.session").out.find("left root"), std::string::npos);
  // Without the case, the models and the plan are those of the session.
  fs::rename(file("spine"), file("gone"));
  const ProcessResult sliced = run("slice r.session --trajectory \"L4 left pedicle\" -o t.png");
  EXPECT_EQ(sliced.exit_code, 0) << sliced.err;
  const Json section = json("section r.session --at 30,60,-13 --normal 0,0,1 -o s.png --svg s.svg");
  EXPECT_NE(read(file("s.svg")).find("left root"), std::string::npos);
  const Json xray = json("fluoro r.session --view ap --pixels 64 -o x.png");
  EXPECT_NE(xray.dump().find("L4 left pedicle"), std::string::npos);
  fs::rename(file("gone"), file("spine"));

  const auto refusal = [&](const std::string& found, const std::string& replacement) {
    std::string changed = text;
    changed.replace(changed.find(found), found.size(), replacement);
    write("spine/case.toml", changed);
    const ProcessResult r = run("info ./spine");
    EXPECT_NE(r.exit_code, 0) << replacement;
    return r.err;
  };
  EXPECT_NE(refusal("\"root.ply\"", "\"rot.ply\"").find("lacks a model"), std::string::npos);
  EXPECT_NE(refusal("\"root.ply\"", "\"../r.toml\"").find("name of a file"), std::string::npos);
  EXPECT_NE(refusal("\"soft-tissue\"", "\"wood\"").find("unknown matter"), std::string::npos);
  EXPECT_NE(refusal("\"left root\"", "\"left\\nroot\"").find("line ends"), std::string::npos);
  EXPECT_NE(refusal("normal = [0.0, 0.0, 2.0]", "normal = [0.0, 0.0, 0.0]").find("plane"), std::string::npos);
  // An open surface cannot be forbidden.
  write("spine/case.toml", text);
  std::string open = read(file("spine/root.ply"));
  open.replace(open.find("face 12"), 7, "face 11");
  open.erase(open.rfind("3 3 7 5"));
  write("spine/root.ply", open);
  const ProcessResult r = run("run r.toml");
  EXPECT_NE(r.exit_code, 0);
  EXPECT_NE(r.err.find("not the surface of a solid"), std::string::npos) << r.err;
}

/// The case of the spine: a burr between two laminae enters the dural sac; a probe from the side enters a
/// nerve root.
/// Both are models, which appear as soft tissue.
TEST_F(Command, TheSpinesCaseHasNervesAsModels) {
  ASSERT_EQ(run("phantom spine --spacing 0.8 --case spine").exit_code, 0);
  write("r.toml", R"(schema = 1
scan = "./spine"
rate = 500
[[hands]]
instrument = "burr"
parameters = "diameter=4 removal_rate=200"
points = [[0, 0, 90, -22, 0], [0.5, 0, 40, -22, 1], [1.5, 0, 27, -22, 1], [2, 0, 27, -22, 1], [2.4, 0, 90, -22, 0]]
[[hands]]
instrument = "probe"
points = [[0, 70, 15, -21.3, 0], [1, 40, 15, -21.3, 0], [2, 25.5, 15, -21.3, 0], [2.4, 70, 15, -21.3, 0]]
)");
  ASSERT_EQ(run("run r.toml --record r.session").exit_code, 0);
  const std::string timeline = run("timeline r.session").out;
  for (const char* name : {"dural sac", "L4 left nerve root"})
    EXPECT_NE(timeline.find(name), std::string::npos) << name << "\n" << timeline;
  EXPECT_EQ(timeline.find("L4 right nerve root"), std::string::npos) << "nothing was near it";
  // "The tool left the dural sac after 0.8 s, at most 3.98 mm deep."
  double depth = 0, seconds = 0;
  const Json rows = json("timeline r.session")["rows"];
  for (const Json& row : rows)
    std::sscanf(row["text"].get<std::string>().c_str(),
                "The tool left the dural sac after %lf s, at most %lf mm deep", &seconds, &depth);
  // The burr (radius 2 mm) stands at y = 27 mm, where the back of the dural sac is near y = 29 mm.
  EXPECT_NEAR(depth, 4, 0.8);
  EXPECT_NEAR(seconds, 0.8, 0.2);
  // In a section, soft tissue does not count as outside bone, and each model is drawn.
  const Json section = json("section ./spine --plane axial --at 0,22,-13 -o s.png --svg s.svg");
  EXPECT_EQ(section.value("models_outside_bone_mm2", 0.0), 0);
  const std::string svg = read(file("s.svg"));
  for (const char* name : {"<title>dural sac", "<title>L4 left nerve root", "<title>L4 right nerve root"})
    EXPECT_NE(svg.find(name), std::string::npos) << name;
  EXPECT_EQ(svg.find("nerve_root"), std::string::npos)
      << "a structure with a model is not drawn a second time by its label";
}

}  // namespace
}  // namespace trephine::command_tests
