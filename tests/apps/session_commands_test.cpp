// Cases and sessions by command: import, --record, info, replay, resume, doctor.
#include <csignal>
#include <cstring>
#include <glm/geometric.hpp>

#include "apps/workbench/sessions.h"
#include "tests/apps/command_fixture.h"

namespace trephine::command_tests {
namespace {

TEST_F(Command, ARecordedDrillReplaysVerifiesAndContinues) {
  ASSERT_EQ(run("phantom sphere --size 48 --psf 1 -o s.mha").exit_code, 0);
  write_press("p.csv", 2);
  const Json drill = json("drill s.mha --burr-diameter 4 --path p.csv -o d.mha --record d.session");
  const Json info = json("info d.session");
  EXPECT_EQ(info["case"], "") << "a file's name may be a patient's";
  EXPECT_EQ(info["is_closed"], true);
  EXPECT_EQ(info["ticks"], drill["steps"]);
  EXPECT_DOUBLE_EQ(info["removed_mm3"], drill["removed_mm3_total"].get<double>());
  EXPECT_EQ(read(file("d.session")).find("s.mha"), std::string::npos);

  // Without the scan the error names --scan; another scan is refused; with its own scan the replay is the
  // same.
  const ProcessResult missing = run("replay d.session --verify");
  EXPECT_EQ(missing.exit_code, 2);
  EXPECT_NE(missing.err.find("--scan"), std::string::npos);
  ASSERT_EQ(run("phantom sphere --size 48 --psf 1.2 -o other.mha").exit_code, 0);
  const ProcessResult wrong = run("replay d.session --scan other.mha");
  EXPECT_EQ(wrong.exit_code, 2);
  EXPECT_NE(wrong.err.find("not the one of the session"), std::string::npos);
  const Json replay = json("replay d.session --scan s.mha --verify -o again.mha --table steps.csv");
  EXPECT_EQ(replay["is_same"], true);
  EXPECT_EQ(replay["content_hash"], drill["content_hash"]);
  EXPECT_EQ(read(file("again.mha")), read(file("d.mha")));
  const std::string steps = read(file("steps.csv"));
  EXPECT_EQ(static_cast<std::size_t>(std::count(steps.begin(), steps.end(), '\n')),
            drill["steps"].get<std::size_t>() + 1);
  // The parts of the force of a tick add up to the total force of that tick.
  const Json parts = json("explain d.session --scan s.mha --at 0.5");
  double sum = 0;
  for (const Json& part : parts["parts"]) sum += part["force_world_n"][2].get<double>();
  EXPECT_NEAR(sum, parts["force_world_n"][2].get<double>(), 1e-9);
  EXPECT_GT(sum, 0.1);
  EXPECT_EQ(parts["tick"], 500);
  EXPECT_EQ(parts["has_contact"], true);
  EXPECT_NE(run("explain d.session --scan s.mha --at 0.5").out.find("spring "), std::string::npos);
  const ProcessResult outside = run("explain d.session --scan s.mha --at 99");
  EXPECT_EQ(outside.exit_code, 2);
  EXPECT_NE(outside.err.find("the time is not in the session"), std::string::npos) << outside.err;
  EXPECT_EQ(run("explain d.session --scan s.mha --at 0.5 --hand 2").exit_code, 2);
  // The session is replayed up to 0.5 s only.
  const Json half = json("replay d.session --scan s.mha --until 0.5 --screenshot half.png");
  EXPECT_EQ(half["ticks"], 500);
  EXPECT_LT(half["removed_mm3_total"], replay["removed_mm3_total"]);
  EXPECT_GT(fs::file_size(folder_ / "half.png"), 2000u);

  // The session is continued in its own file, and replayed as one session.
  write("more.csv", "t,x,y,z\n0,-20,0.2,46\n0.3,-20,0.2,38\n0.6,-20,0.2,36\n");
  const Json resume = json("resume d.session --scan s.mha --path more.csv");
  EXPECT_DOUBLE_EQ(resume["removed_mm3_before"], drill["removed_mm3_total"].get<double>());
  EXPECT_GT(resume["removed_mm3_total"], resume["removed_mm3_before"]);
  const Json whole = json("replay d.session --scan s.mha --verify");
  EXPECT_EQ(whole["is_same"], true);
  EXPECT_DOUBLE_EQ(whole["removed_mm3_total"], resume["removed_mm3_total"].get<double>());

  // Another path continues from 1 s of the session, and is recorded as a session of its own.
  const Json other = json("resume d.session --scan s.mha --path more.csv --at 1 --record other.session");
  EXPECT_LE(other["from_seconds"].get<double>(), 1);
  EXPECT_GT(other["from_seconds"].get<double>(), 0);
  EXPECT_EQ(json("replay other.session --scan s.mha --verify")["is_same"], true);
  EXPECT_DOUBLE_EQ(json("replay d.session --scan s.mha")["removed_mm3_total"].get<double>(),
                   resume["removed_mm3_total"].get<double>());
  for (const char* wrong : {"--at 1", "--record third.session", "--at -1 --record third.session",
                            "--at 1 --record other.session"}) {
    EXPECT_EQ(run(std::string("resume d.session --scan s.mha --path more.csv ") + wrong).exit_code, 2)
        << wrong;
    EXPECT_FALSE(fs::exists(folder_ / "third.session")) << wrong;
  }

  // A recording never overwrites a file.
  const ProcessResult taken = run("drill s.mha --burr-diameter 4 --path p.csv -o d2.mha --record d.session");
  EXPECT_EQ(taken.exit_code, 2);
  EXPECT_NE(taken.err.find("already"), std::string::npos);
}

TEST_F(Command, TheSurfaceAtATimeEnclosesWhatWasNotRemoved) {
  ASSERT_EQ(run("phantom sphere --size 48 --psf 1 -o s.mha").exit_code, 0);
  write("p.csv", "t,x,y,z\n0,-8,0,46\n0.2,-8,0,34\n1.2,8,0,34\n1.4,8,0,46\n");
  const Json drill =
      json("drill s.mha --burr-diameter 8 --kinematic --path p.csv -o d.mha --record d.session");
  const auto volume_at = [&](const std::string& until) {
    json("replay d.session --scan s.mha --mesh m.stl" + until);
    const std::string stl = read(file("m.stl"));
    double six_volumes = 0;
    for (std::size_t at = 84; at + 50 <= stl.size(); at += 50) {
      glm::vec3 corners[4];  // the normal, then the corners
      std::memcpy(corners, stl.data() + at, sizeof corners);
      six_volumes +=
          glm::dot(glm::dvec3(corners[1]), glm::cross(glm::dvec3(corners[2]), glm::dvec3(corners[3])));
    }
    return six_volumes / 6;
  };
  const double removed = drill["removed_mm3_total"], whole = volume_at(" --until 0");
  EXPECT_GT(removed, 300);
  EXPECT_NEAR(whole - volume_at(""), removed, 0.03 * removed);
  const double half = json("replay d.session --scan s.mha --until 0.7")["removed_mm3_total"];
  EXPECT_GT(half, 0.2 * removed);
  EXPECT_NEAR(whole - volume_at(" --until 0.7"), half, 0.05 * half);
}

/// An autosave that was not closed, because its program was killed, is found if it is the newest autosave.
TEST_F(Command, AnInterruptedAutosaveIsFound) {
  ASSERT_EQ(run("phantom sphere --size 48 --psf 1 -o s.mha").exit_code, 0);
  write_press("p.csv", 2);
  json("drill s.mha --burr-diameter 4 --path p.csv -o d.mha --record d.session");
  const std::string whole = read(file("d.session"));
  const std::string before = std::getenv("XDG_STATE_HOME") ? std::getenv("XDG_STATE_HOME") : "";
  ::setenv("XDG_STATE_HOME", folder_.c_str(), 1);
  EXPECT_EQ(workbench::interrupted_autosave(), "");
  const fs::path autosaves = workbench::autosave_folder();
  const auto save = [&](const char* name, const std::string& bytes, int age) {
    std::ofstream(autosaves / name, std::ios::binary) << bytes;
    fs::last_write_time(autosaves / name, fs::file_time_type::clock::now() - std::chrono::minutes(age));
  };
  save("whole.session", whole, 3);
  EXPECT_EQ(workbench::interrupted_autosave(), "");
  save("cut.session", whole.substr(0, whole.size() - 40), 2);
  EXPECT_EQ(workbench::interrupted_autosave(), (autosaves / "cut.session").string());
  save("newer.session", whole, 1);
  EXPECT_EQ(workbench::interrupted_autosave(), "") << "the last operation was closed";
  ::setenv("XDG_STATE_HOME", before.c_str(), 1);
}

TEST_F(Command, ATimelineListsStrokesAndCommands) {
  ASSERT_EQ(run("phantom sphere --size 48 --psf 1 -o s.mha").exit_code, 0);
  write("a.toml",
        "schema = 1\nscan = \"s.mha\"\n[[hands]]\ninstrument = \"burr\"\nparameters = \"diameter=6 "
        "removal_rate=60\"\n"
        "points = [[0, 0, 0, 60, 0], [0.3, 0, 0, 46, 1], [0.8, 0, 0, 41, 1], [0.9, 0, 0, 50, 0], [1.2, 9, 0, "
        "46, 0], "
        "[1.3, 9, 0, 46, 1], [1.8, 9, 0, 40, 1], [1.9, 9, 0, 50, 0], [2.4, 0, 0, 60, 0]]\n"
        "[[do]]\nat = 2.0\ncommand = \"undo\"\n[[do]]\nat = 2.1\ncommand = \"redo\"\n"
        "[[do]]\nat = 2.2\ncommand = \"note\"\nwith = 'text=\"well done\"'\n");
  ASSERT_EQ(run("run a.toml --record a.session").exit_code, 0);
  const Json timeline = json("timeline a.session");
  EXPECT_EQ(timeline["strokes"], 2);
  std::vector<std::string> kinds;
  std::vector<double> removed;
  double before = 0;
  for (const Json& row : timeline["rows"]) {
    EXPECT_GE(row["at_seconds"], before);
    before = row["at_seconds"];
    kinds.push_back(row["kind"]);
    removed.push_back(row.contains("removed_mm3") ? row["removed_mm3"].get<double>() : 0);
  }
  ASSERT_EQ(kinds, (std::vector<std::string>{"stroke", "stroke", "command", "command", "command"}));
  EXPECT_GT(removed[0], 5);
  EXPECT_GT(removed[1], 5);
  EXPECT_NEAR(removed[2], -removed[1], 1e-9);  // volume restored by undo
  EXPECT_NEAR(removed[3], removed[1], 1e-9);
  EXPECT_NEAR(removed[0] + removed[1], json("info a.session")["removed_mm3"].get<double>(), 1e-6);
  EXPECT_NEAR(timeline["rows"][0]["seconds"].get<double>(), 0.6, 0.11);
  EXPECT_NE(timeline["rows"][4]["text"].get<std::string>().find("well done"), std::string::npos);
  const std::string text = run("timeline a.session").out;
  EXPECT_NE(text.find("restored"), std::string::npos) << text;
  // A file that is not a session, and a session without strokes.
  EXPECT_EQ(run("timeline s.mha").exit_code, 2);
  EXPECT_EQ(run("timeline nowhere.session").exit_code, 2);
  write_press("p.csv", 1);
  ASSERT_EQ(run("touch s.mha --path p.csv -o t.csv --record t.session").exit_code, 0);
  // With a path without a button column, the button is pressed throughout. As in a window, a press that
  // changes nothing is not a stroke.
  EXPECT_EQ(json("timeline t.session")["strokes"], 0);
  EXPECT_EQ(json("timeline t.session")["rows"][0]["kind"], "press");
  EXPECT_EQ(json("timeline t.session")["rows"][0]["removed_mm3"], Json());
}

TEST_F(Command, VerifyRefusesAChangedFileAndReportsWhere) {
  ASSERT_EQ(run("phantom sphere --size 48 --psf 1 -o s.mha").exit_code, 0);
  write_press("p.csv", 2);
  ASSERT_EQ(run("drill s.mha --burr-diameter 4 --path p.csv -o d.mha --record d.session --embed").exit_code,
            0);
  EXPECT_EQ(run("replay d.session --verify").exit_code, 0) << "the session contains the scan";
  const std::string whole = read(file("d.session"));
  // A session with a changed header is refused.
  std::string bytes = whole;
  const std::size_t at = bytes.find("stiffness=0.5");
  ASSERT_NE(at, std::string::npos);
  bytes[at + 12] = '6';
  write("changed.session", bytes);
  EXPECT_EQ(run("replay changed.session --verify").exit_code, 2);
  // A changed byte in the last block: the recording was not interrupted there, it is damaged.
  bytes = whole;
  bytes[bytes.size() - 100] = static_cast<char>(bytes[bytes.size() - 100] ^ 0x55);
  write("end.session", bytes);
  EXPECT_EQ(run("replay end.session --verify").exit_code, 1);
  // Damage in the middle of the log: the part before the damage is replayed and is the same, but the session
  // as a whole is not reported as the same.
  bytes = whole;
  bytes[bytes.size() - 4500] = static_cast<char>(bytes[bytes.size() - 4500] ^ 0x55);
  write("damaged.session", bytes);
  const ProcessResult damaged = run("replay damaged.session --verify --json");
  EXPECT_EQ(damaged.exit_code, 1);
  const Json report = Json::parse(damaged.out, nullptr, false);
  EXPECT_EQ(report["is_same"], false);
  EXPECT_EQ(report["mismatch"]["what"], "file");
  EXPECT_GT(report["ticks"], 100) << "blocks are short, so most ticks are readable";
  EXPECT_EQ(run("resume damaged.session --path p.csv").exit_code, 2);
  const ProcessResult audited = run("audit damaged.session");
  EXPECT_EQ(audited.exit_code, 1);
  EXPECT_NE(audited.out.find("the session is damaged"), std::string::npos) << audited.out;
  // A truncated session is not damaged: it is replayed up to its end, and can be continued.
  write("torn.session", whole.substr(0, whole.size() - 3000));
  EXPECT_EQ(run("replay torn.session --verify").exit_code, 0);
  EXPECT_EQ(run("resume torn.session --path p.csv").exit_code, 0);
  EXPECT_EQ(run("replay torn.session --verify").exit_code, 0);
}

/// A session in use by another program is neither read nor truncated.
TEST_F(Command, ResumeLocksTheSessionBeforeReadingIt) {
  ASSERT_EQ(run("phantom sphere --size 48 -o s.mha").exit_code, 0);
  write_press("p.csv", 2);
  ASSERT_EQ(run("drill s.mha --burr-diameter 4 --path p.csv -o d.mha --record d.session").exit_code, 0);
  const std::string before = read(file("d.session"));
  const ProcessResult refused =
      run("resume d.session --scan s.mha --path p.csv", "flock d.session env -u DISPLAY");
  EXPECT_EQ(refused.exit_code, 2);
  EXPECT_NE(refused.err.find("being recorded"), std::string::npos) << refused.err;
  EXPECT_EQ(refused.err.find("note"), std::string::npos) << "the session was read: " << refused.err;
  EXPECT_EQ(read(file("d.session")), before);
  EXPECT_EQ(run("resume d.session --scan s.mha --path p.csv").exit_code, 0);
}

/// A limit of the file size stands for a full disk: each command ends with exit code 3, reports the error,
/// keeps the old files and leaves no new file.
TEST_F(Command, AFullDiskIsReportedAndReplacesNothing) {
  ASSERT_EQ(run("phantom sphere --size 48 -o s.mha").exit_code, 0);
  write_press("p.csv", 2);
  const std::string full = "ulimit -f 8 && env -u DISPLAY";  // 4 kB per file
  for (const char* command :
       {"drill s.mha --burr-diameter 4 --path p.csv -o old.mha --record d.session",
        "drill s.mha --burr-diameter 4 --path p.csv -o old.nrrd", "phantom sphere --size 48 -o old.nii.gz",
        "phantom head --spacing 4 -o old.nii --write-labels labels.mha", "mesh s.mha -o old.stl",
        "touch s.mha --path p.csv -o old.csv", "view s.mha --screenshot old.png", "import s.mha -o case",
        "convert s.mha -o old.vdb", "convert s.mha -o series --as dicom",
        "phantom head --spacing 9 --case hc"}) {
    for (const char* name :
         {"old.mha", "old.nrrd", "old.nii.gz", "old.nii", "old.stl", "old.csv", "old.png", "old.vdb"})
      write(name, "old");
    const ProcessResult r = run(command, full);
    EXPECT_EQ(r.exit_code, 3) << command << r.err;
    EXPECT_NE(r.err.find("free space"), std::string::npos) << command << r.err;
    for (const char* name :
         {"old.mha", "old.nrrd", "old.nii.gz", "old.nii", "old.stl", "old.csv", "old.png", "old.vdb"})
      EXPECT_EQ(read(file(name)), "old") << command;
    fs::remove(folder_ / "d.session");
    EXPECT_EQ(leftovers({"s.mha", "p.csv", "old.mha", "old.nrrd", "old.nii.gz", "old.nii", "old.stl",
                         "old.csv", "old.png", "old.vdb"}),
              "")
        << command;
  }
}

/// The material of a case applies unless an option overrides it.
TEST_F(Command, TouchKeepsTheMaterialOfACase) {
  ASSERT_EQ(run("phantom sphere --size 48 -o s.mha").exit_code, 0);
  ASSERT_EQ(run("import s.mha -o case").exit_code, 0);
  std::ofstream(folder_ / "case" / "case.toml", std::ios::app)
      << "stiffness = 0.9\nstatic_friction = 0.06\ndynamic_friction = 0.05\n";
  write_press("p.csv", 2);
  const auto settings = [&](const std::string& options) {
    fs::remove(folder_ / "t.session");
    EXPECT_EQ(run("touch case --path p.csv -o t.csv --record t.session " + options).exit_code, 0);
    return json("info t.session")["settings"].dump();
  };
  const std::string before = settings(""), viscous = settings("--viscosity 0.01"),
                    soft = settings("--stiffness 0.4");
  for (const std::string& text : {before, viscous, soft}) {
    EXPECT_NE(text.find("0.06"), std::string::npos) << text;
    EXPECT_NE(text.find("0.05"), std::string::npos) << text;
  }
  EXPECT_NE(viscous.find("0.9"), std::string::npos) << viscous;
  EXPECT_NE(soft.find("0.4"), std::string::npos) << soft;
}

TEST_F(Command, ACaseIsASourceEverywhere) {
  ASSERT_EQ(run("phantom head --spacing 2.5 -o head.mha --write-labels labels.mha").exit_code, 0);
  const Json import = json("import head.mha --labels labels.mha -o my-case");
  EXPECT_EQ(import["case"], "case") << "a folder's name may be a patient's";
  EXPECT_EQ(import["structures"], 12);
  const Json info = json("info my-case");
  EXPECT_EQ(info["format"], "case");
  EXPECT_EQ(info["structures"].size(), 12u);
  const ProcessResult again = run("import head.mha -o my-case");
  EXPECT_EQ(again.exit_code, 2);
  EXPECT_NE(again.err.find("already"), std::string::npos);

  // The user edits the plan: names, a second touchable structure with a material, a trajectory.
  std::string text = read(file("my-case/case.toml"));
  const auto replace = [&text](const std::string& from, const std::string& to) {
    const std::size_t at = text.find(from);
    ASSERT_NE(at, std::string::npos) << from;
    text.replace(at, from.size(), to);
  };
  replace("\"label-4\"\nlabel = 4\ntouchable = false",
          "\"dura\"\nlabel = 4\nforbidden = true\nstiffness = 0.2");
  text +=
      "\n[[trajectories]]\nname = \"T9 left\"\nentry = [10, -20, 30]\ntarget = [10, 20, 30]\ndiameter = "
      "5.5\n";
  write("my-case/case.toml", text);
  const Json edited = json("info my-case");
  EXPECT_EQ(edited["structures"][4]["forbidden"], true);
  EXPECT_EQ(edited["structures"][4]["touchable"], true);
  EXPECT_EQ(edited["trajectories"][0]["diameter"], 5.5);
  write("path.csv", "t,x,y,z\n0,0,-10,100\n0.5,0,-10,50\n");
  const Json touch = json("touch my-case --path path.csv -o steps.csv");
  EXPECT_GT(touch["max_force_n"], 0);
  EXPECT_EQ(touch["counters"]["shapes_with_bits"], 2);
  EXPECT_EQ(run("mesh my-case --label label-2 -o bone.stl").exit_code, 0);

  // Forbidden structures are watched: a burr that enters one fails the check, and the session gives the time.
  write("deep.csv", "t,x,y,z\n0,14,-10,110\n1,14,-10,95\n4,14,-10,58\n5,14,-10,110\n");
  write("air.csv", "t,x,y,z\n0,0,-10,110\n1,0,-10,105\n");
  const ProcessResult entered =
      run("drill my-case --kinematic --burr-diameter 6 --path deep.csv -o o.mha --record "
          "g.session --json");
  EXPECT_EQ(entered.exit_code, 1);
  const Json dura = Json::parse(entered.out)["forbidden"][0];
  EXPECT_EQ(dura["structure"], "dura");
  ASSERT_EQ(dura["visits"].size(), 1u);
  EXPECT_NEAR(dura["visits"][0]["at_seconds"].get<double>(), 3.52, 0.1);
  EXPECT_NEAR(dura["visits"][0]["position_world_mm"][2].get<double>(), 63, 2);
  EXPECT_GT(dura["visits"][0]["deepest_mm"].get<double>(), 0.3);
  EXPECT_TRUE(dura["visits"][0]["is_left"].get<bool>());
  const Json events = json("info g.session")["events"];
  ASSERT_EQ(events.size(), 3u);  // the dura was entered, torn and left
  EXPECT_EQ(events[0]["text"], "The tool reached the dura while it was running.");
  EXPECT_TRUE(json("replay g.session --scan my-case --verify")["is_same"].get<bool>());
  const ProcessResult away = run("drill my-case --burr-diameter 6 --path air.csv -o o.mha --json");
  EXPECT_EQ(away.exit_code, 0);
  EXPECT_EQ(Json::parse(away.out)["forbidden"][0]["nearest_mm"], 20);
  EXPECT_EQ(run("view my-case --screenshot v.png").exit_code, 0);

  // Errors of a case are reported by line.
  const auto expect_fault = [&](const std::string& broken, const std::string& what, const std::string& line) {
    write("my-case/case.toml", broken);
    const ProcessResult r = run("info my-case");
    EXPECT_EQ(r.exit_code, 2) << what;
    EXPECT_NE(r.err.find(what), std::string::npos) << r.err;
    if (!line.empty()) {
      EXPECT_NE(r.err.find("line " + line), std::string::npos) << r.err;
    }
  };
  expect_fault("schema = 1\nname = \"x\"\nsurprise = 2\n", "unknown key", "3");
  expect_fault("schema = 3\nname = \"x\"\n", "newer", "");
  expect_fault("schema = 1\nname = \n", "not TOML", "2");
  expect_fault("name = \"x\"\n", "schema", "");
  expect_fault("schema = 1\nname = \"x\"\n[[structures]]\nname = \"a\"\nlow = \"b\"\n", "not a number", "5");
  expect_fault("schema = 1\nname = \"x\"\n[[structures]]\nname = \"a\"\n", "neither a window nor a label",
               "3");
  expect_fault("schema = 1\nname = \"x\"\n[[structures]]\nname = \"a\"\nlow = 5\nhigh = 1\n", "lower limit",
               "3");
}

TEST_F(Command, ImportWritesAllOrNothing) {
  ASSERT_EQ(run("phantom sphere --size 24 -o s.mha").exit_code, 0);
  ASSERT_EQ(run("phantom sphere --size 16 -o small.mha").exit_code, 0);
  EXPECT_EQ(run("import s.mha --labels small.mha -o c").exit_code, 2);
  EXPECT_EQ(run("import none.mha -o c").exit_code, 2);
  EXPECT_EQ(run("import s.mha --iso 99999 -o no/such/c").exit_code, 2);
  EXPECT_EQ(leftovers({"s.mha", "small.mha"}), "");
}

TEST_F(Command, BadSessionsAreReported) {
  write("x.session", "not a session at all");
  for (const char* command : {"replay x.session", "resume x.session --path p.csv", "replay none.session"}) {
    const ProcessResult r = run(command);
    EXPECT_EQ(r.exit_code, 2) << command;
    EXPECT_TRUE(r.err.starts_with("error: ")) << r.err;
  }
  write("newer.session", std::string("TREPHSES\x7f\0\0\0\0\0\0\0", 16));
  EXPECT_NE(run("info newer.session").err.find("newer trephine"), std::string::npos);
}

TEST_F(Command, DevicesAreCheckedAndUnknownOnesAreRefused) {
  const ProcessResult r = run("doctor --devices --json");
  const Json doctor = Json::parse(r.out, nullptr, false);
  ASSERT_EQ(doctor["schema"], "trephine.doctor/1");
  std::set<std::string> names;
  for (const Json& f : doctor["checks"]) names.insert(f["name"]);
  for (const char* name : {"falcon", "spacemouse", "pedal", "devices"})
    EXPECT_TRUE(names.contains(name)) << name;
  EXPECT_FALSE(doctor.contains("timer_late_us"));
  for (const auto& [options, text] : std::initializer_list<std::pair<const char*, const char*>>{
           {"--device flacon", "spacemouse"},
           {"--device falcon:first", "index of the device is invalid"},
           {"--device falcon:", "no selector"},
           {"--device spacemouse --device-scale 0", "0.1 to 10"},
           {"--device pedal", "unknown device"},
           {"--pedal falcon", "unknown pedal"},
           {"--device-scale 2", "only hardware has a scale"},
           {"--device virtual:p.csv --device-scale 2", "only hardware has a scale"},
           {"--device playback:", "needs a path"}}) {
    const ProcessResult refused = run(std::string("view head ") + options + " --screenshot t.png");
    EXPECT_EQ(refused.exit_code, 2) << options;
    EXPECT_NE(refused.err.find(text), std::string::npos) << refused.err;
  }
  EXPECT_EQ(run("simulator --device flacon --screenshot t.png").exit_code, 2);
}

/// A simulated hand is measured like a device: rate, duration of a read, and the test of its force.
TEST_F(Command, DoctorMeasuresADevice) {
  write("hand.csv", "t,x,y,z\n0,0,0,0\n1,20,0,0\n2,0,0,0\n");
  const ProcessResult r = run("doctor --device virtual:hand.csv --seconds 0.5 --json");
  ASSERT_EQ(r.exit_code, 0) << r.out << r.err;
  const Json report = Json::parse(r.out);
  std::map<std::string, std::string> found;
  for (const Json& f : report["checks"]) found[f["name"]] = f["observation"];
  EXPECT_TRUE(found["device"].starts_with("virtual: 6 degrees of freedom, force 8.0 N")) << found["device"];
  EXPECT_NE(found["device rate"].find("a new pose every"), std::string::npos) << found["device rate"];
  EXPECT_NE(found["device read"].find("us"), std::string::npos);
  EXPECT_FALSE(found.contains("device answers"));
  write("answers.txt", "y\nn\ny\n");
  const ProcessResult pushes = run("doctor --device virtual:hand.csv --seconds 0.2 --feel",
                                   "env -u DISPLAY sh -c '\"$@\" < answers.txt' sh");
  EXPECT_NE(pushes.out.find("upward: not perceived"), std::string::npos) << pushes.out << pushes.err;
  EXPECT_NE(pushes.out.find("toward you: perceived"), std::string::npos) << pushes.out;
  EXPECT_EQ(pushes.exit_code, 3);
  write("still.csv", "t,x,y,z\n0,0,0,0\n");
  EXPECT_NE(run("doctor --device playback:still.csv --seconds 0.1").out.find("the hand did not move"),
            std::string::npos);
  for (const auto& [options, text] : std::initializer_list<std::pair<const char*, const char*>>{
           {"--feel", "no device is selected"},
           {"--device mouse", "not measured"},
           {"--device playback:hand.csv --feel --seconds 0.1", "has no force"},
           {"--device flacon", "unknown device"},
           {"--device virtual:hand.csv --devices", "by itself"}}) {
    const ProcessResult refused = run(std::string("doctor ") + options);
    EXPECT_EQ(refused.exit_code, 2) << options;
    EXPECT_NE(refused.err.find(text), std::string::npos) << refused.err;
  }
}

TEST_F(Command, DoctorReportsFaultsWithRemediesAndDrawsTheTimer) {
  const ProcessResult r = run("doctor --seconds 0.3 --json -o t.svg");
  EXPECT_EQ(r.exit_code, 3) << "there is no display here";
  const Json doctor = Json::parse(r.out, nullptr, false);
  EXPECT_EQ(doctor["schema"], "trephine.doctor/1");
  EXPECT_GE(doctor["faults"], 1);
  EXPECT_EQ(doctor["timer_late_us"]["count"], 300);
  std::set<std::string> names;
  for (const Json& f : doctor["checks"]) {
    names.insert(f["name"]);
    if (f["is_fault"]) {
      EXPECT_NE(f["remedy"], "") << f["name"];
    }
  }
  for (const char* name :
       {"display", "OpenGL", "scheduling", "locked memory", "timer", "memory", "sessions", "devices"})
    EXPECT_TRUE(names.contains(name)) << name;
  const std::string svg = read(file("t.svg"));
  EXPECT_TRUE(svg.starts_with("<svg"));
  EXPECT_NE(svg.find("99 %"), std::string::npos);
}

}  // namespace
}  // namespace trephine::command_tests
