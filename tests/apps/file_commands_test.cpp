// import, convert, phantom and info on files: changes are reported, and implausible input is refused.
#include <sys/stat.h>

#include "tests/apps/command_fixture.h"

namespace trephine::command_tests {
namespace {

/// Returns the intensity at a voxel of a scan of two cubes of bone in air, 6 and 3 voxels wide.
int two_cubes(int x, int y, int z) {
  const auto is_in_cube = [&](int low, int high) {
    return std::min({x, y, z}) >= low && std::max({x, y, z}) < high;
  };
  return is_in_cube(4, 10) || is_in_cube(12, 15) ? 800 : -1000;
}

TEST_F(Command, ImportMakesACaseOfARawScanByAPreset) {
  ASSERT_EQ(run("phantom head --spacing 2 -o raw.nii.gz --write-labels raw.seg.nrrd").exit_code, 0);
  write("screws.mrk.json",
        R"({"markups": [{"type": "Line", "coordinateSystem": "RAS", "controlPoints": [
            {"label": "burr-1", "position": [20, 30, 70]}, {"label": "burr-2", "position": [18, 27, 60]}]}]})");
  const Json result = json(
      "import raw.nii.gz --preset skull --labels raw.seg.nrrd --plan screws.mrk.json -o made "
      "--screenshot made.png");
  EXPECT_EQ(result["trajectories"], 1);
  EXPECT_EQ(result["labels"][2], "cortical_bone");
  EXPECT_EQ(result["written"], Json::array({"output", "screenshot"}));
  const std::string plan = read(file("made/case.toml"));
  EXPECT_NE(plan.find("entry = [-20, -30, 70]"), std::string::npos) << plan;
  EXPECT_NE(plan.find("low = 300"), std::string::npos);
  EXPECT_GT(fs::file_size(file("made.png")), 20'000U);
  // Thin walls are closed in the shape, not in the scan. This is reported, and can be switched off.
  const ProcessResult output = run("import raw.nii.gz --preset spine -o spine");
  EXPECT_EQ(output.exit_code, 0);
  for (const char* word :
       {"thin walls were closed in the shape (--fill-thin 4)", "150 HU and above", "the scan is unchanged"})
    EXPECT_NE(output.err.find(word), std::string::npos) << output.err;
  const ProcessResult plain = run("import raw.nii.gz --preset skull --fill-thin 0 -o plain");
  EXPECT_EQ(plain.err.find("thin walls"), std::string::npos) << plain.err;
  const Json quality = json("info raw.nii.gz --chart edges.png")["quality"];
  EXPECT_EQ(result["quality"], quality)
      << "the quality is that of the scan and does not depend on the preset";
  EXPECT_GT(quality["noise"].get<double>(), 5);
  EXPECT_GT(fs::file_size(file("edges.png")), 3000U);
  EXPECT_FALSE(json("info raw.nii.gz").contains("quality")) << "without a chart";
  EXPECT_EQ(run("info raw.nii.gz --list --chart no.png").exit_code, 2);
  EXPECT_FALSE(fs::exists(file("no.png")));
  EXPECT_EQ(run("import raw.nii.gz --preset knee -o k").exit_code, 2);
  EXPECT_EQ(run("import raw.nii.gz --preset skull --range 1:2 -o k").exit_code, 2);
  EXPECT_EQ(run("import raw.nii.gz --fill-thin 11 -o k").exit_code, 2);
  EXPECT_EQ(run("import raw.nii.gz --plan none.csv -o k").exit_code, 2);
  EXPECT_FALSE(fs::exists(file("k")));
}

TEST_F(Command, ConvertReportsResamplingAndReplacesNothing) {
  ASSERT_EQ(run("phantom sphere --size 24 --shear 10 -o s.vdb").exit_code, 0);
  const ProcessResult straight = run("convert s.vdb -o s.nrrd");
  EXPECT_EQ(straight.exit_code, 0);
  EXPECT_NE(straight.err.find("resampled to right angles (cubic"), std::string::npos) << straight.err;
  for (const char* as : {"dicom", "png"}) {
    const std::string words = std::string("convert s.vdb -o ") + as + " --as " + as;
    const ProcessResult result = run(words);
    EXPECT_EQ(result.exit_code, 0) << result.err;
    EXPECT_EQ(result.err.find("resampled"), std::string::npos) << "sheared stacks are kept";
    EXPECT_EQ(run(words).exit_code, 2) << "existing output is kept";
  }
  EXPECT_EQ(json("info dicom")["size"], json("info s.vdb")["size"]);
  EXPECT_EQ(run("convert s.nrrd -o s.nrrd").exit_code, 2);
  EXPECT_EQ(run("convert s.nrrd -o s.seg.nrrd").exit_code, 2);
  EXPECT_EQ(run("convert s.nrrd -o t.nrrd --write-labels l.nrrd").exit_code, 2);
  EXPECT_FALSE(fs::exists(file("t.nrrd")));
}

TEST_F(Command, ImportRefusesScansWithoutATouchableShape) {
  write("scan.nrrd", nrrd(16, two_cubes));
  write("even.nrrd", nrrd(8, [](int, int, int) { return 7; }));
  write("mr.nrrd", nrrd(8, [](int x, int, int) { return 100 * x; }));
  const auto refusal = [&](const std::string& arguments) {
    const ProcessResult r = run("import " + arguments + " -o case");
    EXPECT_EQ(r.exit_code, 2) << arguments;
    EXPECT_FALSE(fs::exists(file("case"))) << arguments;
    return r.err;
  };
  EXPECT_NE(refusal("scan.nrrd --iso 30000").find("the scan has -1000 to 800"), std::string::npos);
  EXPECT_NE(refusal("even.nrrd --auto").find("every voxel is 7"), std::string::npos);
  EXPECT_NE(refusal("mr.nrrd --preset skull").find("--hounsfield"), std::string::npos);
  EXPECT_NE(refusal("scan.nrrd --name \"$(printf 'M\\374ller')\"").find("--name"), std::string::npos);
  // No command waits for a pipe.
  ASSERT_EQ(::mkfifo(file("pipe").c_str(), 0600), 0);
  EXPECT_EQ(run("info pipe").exit_code, 2);
  EXPECT_NE(refusal("scan.nrrd --plan pipe").find("plan cannot be read"), std::string::npos);
}

TEST_F(Command, HounsfieldOptionDeclaresAMissingUnit) {
  write("mr.nrrd", nrrd(8, [](int x, int, int) { return 100 * x; }));
  const ProcessResult as_mr = run("convert mr.nrrd -o as-mr --as dicom");
  EXPECT_NE(as_mr.err.find("written as MR"), std::string::npos) << as_mr.err;
  EXPECT_EQ(json("info as-mr")["modality"], "MR");
  const ProcessResult as_ct = run("convert mr.nrrd --hounsfield -o as-ct --as dicom");
  EXPECT_EQ(as_ct.err.find("written as MR"), std::string::npos) << as_ct.err;
  const Json ct = json("info as-ct");
  EXPECT_EQ(ct["modality"], "CT");
  EXPECT_EQ(ct["is_hounsfield"], true);
  EXPECT_EQ(run("import mr.nrrd --hounsfield -o case").exit_code, 0);
  EXPECT_NE(read(file("case/case.toml")).find("hounsfield = true"), std::string::npos);
}

/// Implausible plans are reported, such as plans in centimetres, in another frame or of another patient. A
/// plausible plan is not reported.
TEST_F(Command, ImportWarnsOfImplausiblePlans) {
  write("scan.nrrd", nrrd(40, [](int x, int y, int z) {
          return std::min({x, y, z}) >= 10 && std::max({x, y, z}) < 30 ? 800 : -1000;
        }));
  const auto output = [&](const std::string& line) {
    write("plan.csv",
          "# CoordinateSystem = LPS\nname,entry_x,entry_y,entry_z,target_x,target_y,target_z,diameter\n" +
              line);
    fs::remove_all(file("case"));
    const ProcessResult r = run("import scan.nrrd --plan plan.csv -o case");
    EXPECT_EQ(r.exit_code, 0) << r.err;
    return r.err;
  };
  EXPECT_EQ(output("good,20,20,35,20,20,15,4\n").find("warning"), std::string::npos);
  EXPECT_NE(output("short,2,2,3.5,2,2,3,4\n").find("short is 0.5 mm long"), std::string::npos);
  EXPECT_NE(output("thick,20,20,35,20,20,15,40\n").find("thick is 40 mm thick"), std::string::npos);
  EXPECT_NE(output("aside,5,5,35,5,5,15,4\n").find("aside meets no bone"), std::string::npos);
  EXPECT_NE(output("far,20,20,135,20,20,15,4\n").find("outside the scan: far (entry)"), std::string::npos);
}

TEST_F(Command, LabelsKeepTheirNamesNumbersAndColours) {
  write("scan.nrrd", nrrd(16, two_cubes));
  // The label map has gaps in its numbers, a name in Latin-1, and a segment without voxels.
  write("parts.seg.nrrd",
        nrrd(
            16, [](int x, int y, int z) { return two_cubes(x, y, z) < 0 ? 0
                                                 : x < 10               ? 5
                                                                        : 2; },
            "Segment0_Name:=small\nSegment0_LabelValue:=2\nSegment0_Color:=0 0.5 1\n"
            "Segment3_Name:=Sch\xe4"
            "del\nSegment3_LabelValue:=5\nSegment3_Color:=1 0 0\n"
            "Segment4_Name:=nothing\nSegment4_LabelValue:=7\nSegment4_Color:=0 1 0\n"));
  const ProcessResult segments = run("info parts.seg.nrrd");
  EXPECT_NE(segments.out.find("segment Sch\xc3\xa4"
                              "del: value 5"),
            std::string::npos)
      << segments.out;
  write("places.csv", "# CoordinateSystem = LPS\nname,x,y,z\nvertex,7,7,9\n");
  const Json result = json("import scan.nrrd --labels parts.seg.nrrd --plan places.csv -o case");
  EXPECT_EQ(result["structures"], 3) << "bone, and the labels that occur";
  EXPECT_EQ(result["labels"], Json::array({"background", "label-1", "small", "label-3", "label-4",
                                           "Sch\xc3\xa4"
                                           "del"}));
  const std::string plan = read(file("case/case.toml"));
  EXPECT_NE(plan.find("\"#0080ff\""), std::string::npos) << plan;
  EXPECT_NE(plan.find("\"#ff0000\""), std::string::npos) << plan;
  EXPECT_EQ(json("info case")["landmarks"][0]["name"], "vertex");
  EXPECT_NE(run("info case").out.find("landmark vertex: (7.0, 7.0, 9.0)"), std::string::npos);
  // The labels are written to another file with their colours.
  ASSERT_EQ(run("convert case -o again.nrrd --write-labels again.seg.nrrd").exit_code, 0);
  EXPECT_NE(read(file("again.seg.nrrd")).find("_Color:=1 0 0"), std::string::npos);
  // --largest keeps the largest part of a case and needs no other option for the shape.
  const ProcessResult largest = run("import case --largest -o largest");
  EXPECT_NE(largest.err.find("the largest part was kept"), std::string::npos) << largest.err;
  EXPECT_NE(read(file("largest/case.toml")).find("vertex"), std::string::npos) << "its plan is kept";
  // A missing file is named.
  fs::remove(file("case/labels.mha"));
  const ProcessResult gone = run("info case");
  EXPECT_EQ(gone.exit_code, 2);
  EXPECT_NE(gone.err.find("case/labels.mha"), std::string::npos) << gone.err;
  EXPECT_NE(run("import scan.nrrd --labels none.nrrd -o c").err.find("label map"), std::string::npos);
  EXPECT_NE(run("info largest --list").err.find("a case contains one scan"), std::string::npos);
}

/// A model next to a scan does not count as a scan.
TEST_F(Command, AFolderWithAScanAndAModelOpensItsScan) {
  fs::create_directory(file("both"));
  write("both/scan.nrrd", nrrd(16, two_cubes));
  write("both/skull.stl", "solid a\nendsolid a\n");
  const ProcessResult opened = run("info both");
  EXPECT_EQ(opened.exit_code, 0) << opened.err;
  EXPECT_NE(opened.err.find("one scan, of format NRRD"), std::string::npos) << opened.err;
}

TEST_F(Command, TypingErrorsAreReportedWithTheirRemedy) {
  write("scan.nrrd", nrrd(16, two_cubes));
  write("one.png", "no matter");
  const struct {
    const char *command, *words;
  } cases[] = {{"convert scan.nrrd -o x.dcm", "--as dicom"},
               {"convert scan.nrrd -o x.png", "--as png"},
               {"convert scan.nrrd -o x.nrrd --as png", "the folder of slices has the extension of a file"},
               {"convert scan.nrrd -o x --as jpeg", "one of dicom, png, tiff"},
               {"info one.png", "a single picture is not a scan"},
               {"import scan.nrrd --presett skull -o x", "found:    --presett"},
               {"import scan.nrrd --iso 300mm -o x", "without a unit"},
               {"import scan.nrrd --labels scan.nrrd -o x", "is a label map"},
               {"phantom spine --seed -3 -o x.mha", "not a whole number from 0"},
               {"phantom spine --seed 99999999999999999999 -o x.mha", "not a whole number from 0"}};
  for (const auto& [command, words] : cases) {
    const ProcessResult r = run(command);
    EXPECT_EQ(r.exit_code, 2) << command;
    EXPECT_NE(r.err.find(words), std::string::npos) << command << "\n" << r.err;
  }
  EXPECT_EQ(leftovers({"scan.nrrd", "one.png"}), "");
  // A name of 254 bytes is accepted; Linux allows 255.
  const std::string longest = std::string(250, 'n') + ".mha";
  EXPECT_EQ(run("convert scan.nrrd -o " + longest).exit_code, 0);
  EXPECT_TRUE(fs::exists(file(longest)));
}

}  // namespace
}  // namespace trephine::command_tests
