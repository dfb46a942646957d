// Report pages: data, charts and pages of recorded sessions.
#include <algorithm>
#include <cstring>
#include <random>
#include <regex>
#include <set>

#include "apps/cli/report/course_page.h"
#include "apps/cli/report/report_charts.h"
#include "apps/cli/report/report_html.h"
#include "apps/workbench/report_data.h"
#include "apps/workbench/text.h"
#include "data-tools/meshes/glb_file.h"
#include "tests/apps/command_fixture.h"
#include "volume/cuts/removal.h"

namespace trephine::command_tests {
namespace {

using glm::dvec3;
using workbench::Envelope;
using workbench::RemovalDistances;

/// Each column has the extremes of its ticks, also if the number of ticks is not a multiple of the number of
/// columns.
TEST(Report, EnvelopesKeepEveryPeak) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> values(-5, 5);
  for (const auto& [ticks, columns] : {std::pair(1000u, 7u), std::pair(64u, 64u), std::pair(5u, 900u),
                                       std::pair(1u, 3u), std::pair(901u, 900u)}) {
    Envelope envelope(ticks, columns);
    std::vector<std::optional<double>> all(ticks);
    for (unsigned t = 0; t < ticks; ++t)
      if (t % 11 != 4) envelope.add(t, *(all[t] = values(random)));
    envelope.add(ticks, 1e9);  // beyond the end
    const auto found = envelope.columns();
    ASSERT_EQ(found.size(), std::min(ticks, columns));
    for (std::size_t c = 0; c < found.size(); ++c) {
      std::optional<double> low, high;
      for (unsigned t = 0; t < ticks; ++t)
        if (all[t] && t * found.size() / ticks == c)
          low = std::min(low.value_or(*all[t]), *all[t]), high = std::max(high.value_or(*all[t]), *all[t]);
      ASSERT_EQ(found[c].has_value, low.has_value());
      if (!low) continue;
      EXPECT_EQ(found[c].low, *low);
      EXPECT_EQ(found[c].high, *high);
    }
  }
}

/// A ball is cut into a block above a forbidden slab. The removed volumes by distance from the slab are
/// compared with a sum over all samples of the lattice, and with slices of the ball in closed form.
TEST(Report, RemovedMatterByDistanceIsThatOfABall) {
  constexpr double k_spacing = 0.5, k_radius = 4, k_top = 3;  // the slab is below z = k_top
  const dvec3 middle(8.25, 8, 10);
  const auto frame = volume::Frame::from_axes(dvec3(0), glm::dmat3(k_spacing)).value();
  auto scan = std::make_shared<volume::Volume>(volume::make_volume(glm::ivec3(32), frame, true).value());
  scan->label_names = {"bone", "cord"};
  for (int z = 0; z < 32; ++z)
    for (int y = 0; y < 32; ++y)
      for (int x = 0; x < 32; ++x) {
        const dvec3 p = frame.world_from_volume({x, y, z});
        scan->voxels[scan->index(x, y, z)] = p.x < middle.x ? 1000 : 0;  // half of it is air
        scan->labels[scan->index(x, y, z)] = p.z < k_top;
      }
  const volume::Shape bone{.name = "bone", .low = 500};
  const volume::Shape cord{.name = "cord", .label = 1};
  const volume::Field field(*scan, bone);
  auto start = std::make_shared<volume::Version>(scan, volume::CutLattice::for_burr(*scan, 8).value());
  volume::RemovalEditor editor(start, {field});
  editor.remove(volume::Sweep{middle, middle, k_radius});
  const auto version = editor.freeze();
  const auto structure = sim::Forbidden::build(scan, cord).value();
  const volume::Field solids[] = {field};
  const RemovalDistances found = workbench::removal_distances(*version, solids, *structure);
  EXPECT_EQ(found.structure, "cord");

  std::array<double, RemovalDistances::k_bins> brute{};
  double inside = 0, beyond = 0, total = 0;
  const volume::CutLattice& lattice = version->lattice();
  for (int z = 0; z < lattice.size().z; ++z)
    for (int y = 0; y < lattice.size().y; ++y)
      for (int x = 0; x < lattice.size().x; ++x) {
        const dvec3 p = lattice.volume_from_lattice(dvec3(x, y, z));
        if (version->sample_distance({x, y, z}) > 0 || field.value(p) < 0) continue;
        const double distance = structure->clearance({.centre = frame.world_from_volume(p)}, 5);
        const double cell = lattice.frame().voxel_mm3();
        (distance < 0 ? inside : distance >= 20 ? beyond : brute[static_cast<std::size_t>(distance)]) += cell;
        total += cell;
      }
  EXPECT_GT(total, 50);
  EXPECT_NEAR(found.inside_mm3, inside, 1e-9);
  EXPECT_NEAR(found.beyond_mm3, beyond, 1e-9);
  for (std::size_t i = 0; i < brute.size(); ++i) EXPECT_NEAR(found.mm3[i], brute[i], 1e-9) << i;
  // below(height): volume of the ball below this height, halved because half of the block is air. The whole
  // half ball has 134 mm³.
  constexpr double k_pi = 3.14159265358979323846;
  const auto below = [&](double height) {
    const double h = std::clamp(height - (middle.z - k_radius), 0.0, 2 * k_radius);
    return 0.5 * k_pi * h * h * (k_radius - h / 3);
  };
  const double surface = k_top - k_spacing / 2;  // top of the slab, between two voxels
  for (std::size_t i = 0; i < brute.size(); ++i) {
    const double z = surface + static_cast<double>(i);
    EXPECT_NEAR(found.mm3[i], below(z + 1) - below(z), 0.12 * 134) << i;
  }
  EXPECT_NEAR(found.within(20), 0.5 * 4 / 3.0 * k_pi * 64, 0.05 * 134);
  EXPECT_EQ(found.within(3), 0);
  // Without a solid, or without a cut, nothing is counted.
  EXPECT_EQ(workbench::removal_distances(*version, {}, *structure).within(20), 0);
  EXPECT_EQ(workbench::removal_distances(*start, solids, *structure).within(20), 0);
}

/// Strokes end where the tool neither touches nor works, and a long path keeps its shape with few points.
TEST(Report, PathsOfToolsAreStrokesOfFewPoints) {
  workbench::ToolPath path;
  for (int i = 0; i <= 100; ++i) path.add({0.1 * i, 0, 0}, true, i > 50);
  path.add({10, 0, 5}, false, false);
  path.add({20, 0, 0}, true, false);
  const auto& strokes = path.strokes();
  ASSERT_EQ(strokes.size(), 3u);
  EXPECT_FALSE(strokes[0].is_working);
  EXPECT_TRUE(strokes[1].is_working);
  EXPECT_EQ(strokes[1].points_world.front(), strokes[0].points_world.back());
  EXPECT_EQ(strokes[2].points_world, std::vector{dvec3(20, 0, 0)});
  EXPECT_NEAR(strokes[1].points_world.back().x, 10, workbench::ToolPath::k_least_step);
  // A path of 10 m on a circle, interrupted about once per turn.
  workbench::ToolPath circle;
  constexpr double k_radius = 40;
  std::vector<bool> is_visited(360);
  for (int i = 0; i < 400'000; ++i) {
    const double angle = i * 6.25e-4;
    circle.add(k_radius * dvec3(std::cos(angle), std::sin(angle), 0), i % 10'000 > 100, false);
  }
  std::size_t count = 0;
  for (const auto& stroke : circle.strokes())
    for (std::size_t i = 0; i < stroke.points_world.size(); ++i) {
      const dvec3& p = stroke.points_world[i];
      ++count;
      EXPECT_NEAR(glm::length(p), k_radius, 1e-9);
      is_visited[static_cast<std::size_t>(std::atan2(p.y, p.x) * 180 / 3.14159265358979 + 359.999) % 360] =
          true;
      if (i > 0) {
        EXPECT_LT(glm::distance(p, stroke.points_world[i - 1]), 1.1 * circle.step());
      }
    }
  EXPECT_LE(count, workbench::ToolPath::k_most_points);
  EXPECT_GT(count, workbench::ToolPath::k_most_points / 4);
  EXPECT_GT(std::count(is_visited.begin(), is_visited.end(), true), 80);
  // Each view shows the path; a working stroke is a separate line.
  const std::vector<std::string> views = cli::svgs_of(std::vector{path});
  ASSERT_EQ(views.size(), 3u);
  for (const std::string& svg : views) EXPECT_NE(svg.find("tool hand1 working"), std::string::npos);
  EXPECT_TRUE(cli::svgs_of({}).empty());
}

TEST(Report, TextsStayTexts) {
  EXPECT_EQ(cli::escaped("<script>alert(\"a\" & 'b')</script>"),
            "&lt;script&gt;alert(&quot;a&quot; &amp; &#39;b&#39;)&lt;/script&gt;");
  EXPECT_EQ(cli::escaped("caf\u00e9 \u2026 \U0001f9b4"), "caf\u00e9 \u2026 \U0001f9b4");
  EXPECT_EQ(cli::escaped(std::string("a\0b\x1b\x7f", 5)), "a b  ");
  // Invalid UTF-8: a stray continuation byte, an overlong sequence, a surrogate, and a truncated sequence.
  for (const char* wrong : {"\x80", "\xc0\xaf", "\xed\xa0\x80", "\xf0\x9f\xa6"}) {
    const std::string text = cli::escaped(wrong);
    EXPECT_NE(text.find("\ufffd"), std::string::npos);
    EXPECT_EQ(text.find(wrong), std::string::npos);
  }
  EXPECT_EQ(cli::base64(""), "");
  EXPECT_EQ(cli::base64("f"), "Zg==");
  EXPECT_EQ(cli::base64("fo"), "Zm8=");
  EXPECT_EQ(cli::base64("foo"), "Zm9v");
  EXPECT_EQ(cli::base64("foobar"), "Zm9vYmFy");
  EXPECT_EQ(cli::base64("\xff\xfe\xfd"), "//79");
  cli::HtmlTable table({{"a<b"}, {"n", true}});
  table.begin_row();
  table.cell("<i>");
  table.cell("1");
  EXPECT_EQ(table.finish(),
            "<table><thead><tr><th>a&lt;b</th><th class=\"number\">n</th></tr></thead><tbody>\n"
            "<tr><td>&lt;i&gt;</td><td class=\"number\">1</td></tr>\n</tbody></table>\n");
}

/// A peak of one tick reaches the height of its value; marks have their shapes and escaped texts.
TEST(Report, ChartsShowPeaksAndMarks) {
  Envelope values(100'000, 900);
  for (std::uint64_t t = 0; t < 100'000; ++t) values.add(t, t == 50'000 ? 6 : 1);
  const std::string svg = cli::svg_of({.title = "force, N",
                                       .label = "force",
                                       .values = &values,
                                       .seconds = 100,
                                       .axis_seconds = 100,
                                       .marks = {{.seconds = 50, .text = "<torn>", .is_danger = true},
                                                 {.seconds = 20, .text = "drill", .is_step = true},
                                                 {.seconds = 30, .text = "bite"}}});
  // The axis for 6 N is 130 units high, from y = 172 up to y = 42. The edge of the band is 0.6 units above
  // its values, so y = 41.4.
  EXPECT_NE(svg.find(" 41.4L"), std::string::npos) << svg.substr(0, 2000);
  EXPECT_EQ(std::count(svg.begin(), svg.end(), 'Z'), 1);
  EXPECT_NE(svg.find("<title>50.0 s: &lt;torn&gt;</title>"), std::string::npos);
  EXPECT_EQ(svg.find("<torn>"), std::string::npos);
  for (const char* part : {"class=\"danger\"", "class=\"step\"", "<circle", ">drill</text>"})
    EXPECT_NE(svg.find(part), std::string::npos) << part;
  // A gap in the values interrupts the band.
  Envelope gaps(90, 90);
  for (const std::uint64_t t : {3u, 4u, 50u, 51u}) gaps.add(t, 1);
  const std::string two =
      cli::svg_of({.title = "", .label = "", .values = &gaps, .seconds = 9, .axis_seconds = 9});
  EXPECT_EQ(std::count(two.begin(), two.end(), 'Z'), 2);
}

TEST(Report, ScenesHaveNamedParts) {
  const data_tools::ScenePart parts[] = {
      {.name = "bone\"},", .vertices = {{0, 0, 0}, {10, 0, 0}, {0, 20, 0}}, .indices = {0, 1, 2}},
      {.name = "empty"},
      {.name = "track", .are_lines = true, .vertices = {{0, 0, 0}, {0, 0, 30}}, .indices = {0, 1}}};
  const std::string glb = data_tools::glb_of(parts);
  ASSERT_EQ(glb.substr(0, 4), "glTF");
  std::uint32_t length = 0;
  std::memcpy(&length, glb.data() + 12, 4);
  const Json gltf = Json::parse(glb.substr(20, length));
  ASSERT_EQ(gltf["nodes"].size(), 2u);
  EXPECT_EQ(gltf["nodes"][0]["name"], "bone");
  EXPECT_EQ(gltf["meshes"][1]["primitives"][0]["mode"], 1);
  EXPECT_NEAR(gltf["accessors"][2]["max"][1].get<double>(), 0.03, 1e-8);  // metres, y up
  EXPECT_EQ(gltf["buffers"][0]["byteLength"], glb.size() - 28 - length);
  EXPECT_EQ(gltf["accessors"][1]["count"], 3);
}

/// Records a hole and a hostile note in a case with a hostile name. The folder of the case has a patient's
/// name.
class ReportPage : public Command {
 protected:
  void record() {
    ASSERT_EQ(run("phantom sphere --size 48 --psf 1 -o s.mha").exit_code, 0);
    ASSERT_EQ(run("import s.mha -o Erika-Mustermann --name '<script>alert(1)</script>'").exit_code, 0);
    write(
        "a.toml",
        "schema = 1\nscan = \"Erika-Mustermann\"\n[[hands]]\ninstrument = \"burr\"\nparameters = \"diameter=6 "
        "removal_rate=60\"\n"
        "points = [[0, 0, 0, 60, 0], [0.3, 0, 0, 46, 1], [0.8, 0, 0, 41, 1], [0.9, 0, 0, 50, 0], [1.4, 0, "
        "0, 60, 0]]\n[[do]]\nat = 1.2\ncommand = \"note\"\nwith = 'text=\"<img src=x>\"'\n");
    const ProcessResult played = run("run a.toml --record Erika.session");
    ASSERT_EQ(played.exit_code, 0) << played.err;
  }
};

TEST_F(ReportPage, HasTheScoreThePicturesAndNoNames) {
  record();
  const Json report = json("report Erika.session --scan Erika-Mustermann -o page.html");
  const std::string page = read(file("page.html"));
  EXPECT_EQ(report["bytes"], page.size());
  EXPECT_LT(page.size(), 15'000'000u);
  // Every finding of the score is in it, with its value.
  const Json score = json("score Erika.session --scan Erika-Mustermann");
  std::size_t count = 0;
  for (const Json& finding : score["findings"]) {
    std::string name = finding["name"];
    std::replace(name.begin(), name.end(), '_', ' ');
    EXPECT_NE(page.find(">" + cli::escaped(name) + "<"), std::string::npos) << name;
    ++count;
  }
  EXPECT_GT(count, 3u);
  EXPECT_EQ(report["findings"], count);
  // Markup in texts of the session is escaped.
  EXPECT_EQ(page.find("<script>alert(1)"), std::string::npos);
  EXPECT_NE(page.find("&lt;script&gt;alert(1)"), std::string::npos);
  EXPECT_EQ(page.find("<img src=x"), std::string::npos);
  // The page names no folder and no file, and requests nothing.
  for (const std::string& name : {std::string("Mustermann"), std::string("Erika"), std::string("page.html"),
                                  std::string("s.mha"), std::string("a.toml"), folder_.filename().string()})
    EXPECT_EQ(page.find(name), std::string::npos) << name;
  const std::regex request(R"re((src|href|action|data)="(?!data:image/png;base64,)[^"]*"|url\(|@import)re");
  std::string outside = page;  // scripts: limited by the content security policy, too long for a regex
  for (std::size_t at; (at = outside.find("<script")) != std::string::npos;)
    outside.erase(at, outside.find("</script>", at) + 9 - at);
  for (std::size_t at = 0; (at = outside.find("base64,", at)) != std::string::npos; at += 7)
    outside.erase(at + 7, outside.find('"', at) - at - 7);
  EXPECT_FALSE(std::regex_search(outside, request));
  EXPECT_TRUE(std::regex_search(std::string("<img src=\"http://a\">"), request)) << "the check can fail";
  EXPECT_EQ(outside.find("http"),
            outside.find("http-equiv=\"Content-Security-Policy\" content=\"default-src 'none'"));
  EXPECT_NE(page.find("data:image/png;base64,iVBOR"), std::string::npos);
  // The page has the removed volume of the first row of the timeline.
  const Json timeline = json("timeline Erika.session");
  EXPECT_NE(
      page.find(">" + workbench::format_text("%.2f", timeline["rows"][0]["removed_mm3"].get<double>()) + "<"),
      std::string::npos);

  // Inputs and files of other kinds are not replaced; a failure leaves no file.
  const std::string session = read(file("Erika.session"));
  EXPECT_EQ(run("report Erika.session --scan Erika-Mustermann -o Erika.session").exit_code, 2);
  EXPECT_EQ(run("report Erika.session --scan Erika-Mustermann -o page.pdf").exit_code, 2);
  EXPECT_EQ(run("report s.mha -o other.html").exit_code, 2);
  EXPECT_EQ(run("report Erika.session -o other.html").exit_code, 2) << "its scan is missing";
  EXPECT_FALSE(fs::exists(folder_ / "other.html"));
  EXPECT_EQ(read(file("Erika.session")), session);
}

/// The picture of an early injury contains matter that was removed later.
TEST_F(ReportPage, AnInjuryIsShownInItsOwnState) {
  write("a.toml", R"(schema = 1
scan = "spine"
plan = true
rate = 250
[[hands]]
instrument = "burr"
parameters = "diameter=4 kinematic=yes"
points = [[0, 0, 60, 16, 0], [0.4, 0, 47, 16, 1], [1.2, 0, 24, 16, 1], [1.6, 0, 47, 16, 1], [1.7, 0, 60, 16, 0],
          [6, 30, 50, 6, 0], [6.4, 30, 45, 6, 1], [7.2, 30, 32, 6, 1], [7.6, 30, 60, 6, 0]]
)");
  const ProcessResult played = run("run a.toml --record a.session");
  ASSERT_EQ(played.exit_code, 0) << played.err;
  const auto report = workbench::collect_report({.session = file("a.session"), .case_source = {}}, {});
  ASSERT_TRUE(report.is_ok()) << report.error().message();
  const workbench::ReportData& data = report.value();
  const auto& frame = data.session->replay->engine().scene().base->frame;
  const auto is_removed = [&](const volume::Version& version, const dvec3& p) {
    return version.distance(frame.volume_from_world(p)) <= 0;
  };
  const dvec3 later(30, 33, 6);
  EXPECT_TRUE(is_removed(*data.session->replay->engine().version(), later));
  int injuries = 0;
  std::set<std::string> texts;
  for (const workbench::ReportMoment& moment : data.moments) {
    EXPECT_TRUE(texts.insert(moment.text).second) << "twice: " << moment.text;
    if (moment.seconds > 5 || moment.level != workbench::EventLevel::danger) continue;
    ++injuries;
    EXPECT_FALSE(is_removed(*moment.version, later)) << moment.text;
  }
  EXPECT_GE(injuries, 1);
  EXPECT_LE(injuries, 2) << "one tear, and one for the next structure at most";
}

/// Three sessions have scores, and the second lacks a finding. The fourth session could not be opened.
TEST(Report, ACoursePageHasAllSessionsAndFindings) {
  std::vector<workbench::CourseSession> sessions(4);
  for (std::size_t i = 0; i < 3; ++i) {
    sim::Score score = sim::score({{.name = "a<b>: breach",
                                    .value = 4.0 - static_cast<double>(i),
                                    .unit = "mm",
                                    .full_at = 2,
                                    .zero_at = 4,
                                    .weight = 10},
                                   {.name = "time", .value = 60}},
                                  {});
    if (i == 1) score.findings.erase(score.findings.begin());
    sessions[i].title = "Craniotomy";
    sessions[i].date = "2026-11-2" + std::to_string(i);
    workbench::SessionScore& scored = sessions[i].score.emplace();
    scored.score = std::move(score);
    scored.seconds = 60;
    scored.is_complete = i != 2;
  }
  sessions[3].error = "the session is <damaged>";
  const std::string page = cli::course_html(sessions, "trephine");
  for (const char* text :
       {"sessions: 4", "2026-11-20 to 2026-11-22", "a&lt;b&gt;: breach, mm", "the session is &lt;damaged&gt;",
        "The recording is not complete.", "<title>session 1: 4</title>", "<title>session 3: 2</title>"})
    EXPECT_NE(page.find(text), std::string::npos) << text;
  EXPECT_EQ(page.find("<damaged>"), std::string::npos);
  EXPECT_EQ(page.find("<title>session 2: "), page.rfind("<title>session 2: "))
      << "only in the curve of points";
  // No line crosses a gap: the curve of the finding consists of two separate points.
  const std::size_t finding = page.find("a&lt;b&gt;: breach by session"),
                    curve = page.find("class=\"curve\"", finding);
  const std::string line = page.substr(curve, page.find("/>", curve) - curve);
  EXPECT_EQ(std::count(line.begin(), line.end(), 'M'), 2) << line;
  EXPECT_EQ(std::count(line.begin(), line.end(), 'L'), 0) << line;
  // For this finding, the first session gets no points and is bad. The third session gets all points.
  EXPECT_NE(page.find("class=\"session bad\"", finding), std::string::npos);
  EXPECT_NE(page.find("class=\"session good\"", finding), std::string::npos);
}

TEST_F(ReportPage, OfAFolderHasNoNames) {
  record();
  fs::create_directory(folder_ / "course");
  fs::rename(folder_ / "Erika.session", folder_ / "course" / "Erika.session");
  const Json report = json("report course --scan Erika-Mustermann -o page.html");
  EXPECT_EQ(report["sessions"], 1);
  EXPECT_EQ(report["scored_sessions"], 1);
  const std::string page = read(file("page.html"));
  EXPECT_EQ(report["bytes"], page.size());
  for (const std::string& name :
       {std::string("Mustermann"), std::string("Erika"), std::string("course"), folder_.filename().string()})
    EXPECT_EQ(page.find(name), std::string::npos) << name;
  EXPECT_EQ(run("report course --expert course/Erika.session -o other.html").exit_code, 2);
  EXPECT_FALSE(fs::exists(folder_ / "other.html"));
}

/// In Chromium, if it is installed, a comparison prints on at most two pages, and no script fails.
TEST_F(ReportPage, OpensAndPrintsInABrowser) {
  if (std::system("command -v chromium >/dev/null && command -v pdfinfo >/dev/null") != 0)
    GTEST_SKIP() << "no chromium, or no pdfinfo";
  record();
  ASSERT_EQ(run("report Erika.session --scan Erika-Mustermann --expert Erika.session -o page.html").exit_code,
            0);
  EXPECT_NE(read(file("page.html")).find("Comparison with an expert"), std::string::npos);
  const std::string chromium = "cd '" + folder_.string() +
                               "' && HOME=\"$PWD\" chromium --headless --no-sandbox --disable-gpu "
                               "--virtual-time-budget=2000 ";
  ASSERT_EQ(
      std::system((chromium + "--no-pdf-header-footer --print-to-pdf=page.pdf page.html >log 2>&1 && pdfinfo "
                              "page.pdf >info")
                      .c_str()),
      0)
      << read(file("log"));
  const std::string info = read(file("info"));
  EXPECT_TRUE(std::regex_search(info, std::regex("Pages: +[12]\n"))) << info;
  EXPECT_NE(info.find("A4"), std::string::npos) << info;
  ASSERT_EQ(std::system((chromium + "--dump-dom page.html >dom 2>>log").c_str()), 0);
  const std::string dom = read(file("dom"));
  EXPECT_NE(dom.find("&lt;script&gt;alert(1)"), std::string::npos);
  EXPECT_EQ(read(file("log")).find("Uncaught"), std::string::npos) << read(file("log"));
}

}  // namespace
}  // namespace trephine::command_tests
