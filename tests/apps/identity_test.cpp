// Patient identity: names planted in tags, folders and files must not appear in any output of any command,
// including the text in pictures.
#include <algorithm>

#include "apps/bench/scenes/dicom_files.h"
#include "tests/apps/command_fixture.h"

namespace trephine::command_tests {
namespace {

const std::vector<std::string> k_planted{
    "ZIMMERMANN", "zimmermann", "KENNUNG-4711", "SPITAL-WEIT", "19560401", "WEBER",     "MUSTERMANN",
    "SCHMIDT",    "LEHMANN",    "M\xfcLLER",    "VOGEL",       "KRAUSE",   "1.2.752.24"};

class Identity : public Command {
 protected:
  Identity() {
    write_scan(scan_, 24, "1.2.752.24.7");
    write("LEHMANN.csv", "t,x,y,z\n0,0,0,60\n0.1,0,0,44\n0.3,0,0,42\n");
  }
  /// Writes a ball of bone as DICOM slices of 24 x 24 pixels. Pixels and slices are 4 mm apart. 24 slices
  /// contain the whole ball; fewer contain its lower part.
  void write_scan(const std::string& folder, int slices, const std::string& series) {
    fs::create_directories(folder_ / folder);
    for (int z = 0; z < slices; ++z) {
      scenes::SliceSpec slice;
      slice.size = {24, 24};
      slice.spacing = {4, 4};
      slice.position = {-46, -46, 4.0 * z - 46};
      slice.number = z + 1;
      slice.series = series;
      slice.description = "Head for Dr. WEBER";
      for (int y = 0; y < 24; ++y)
        for (int x = 0; x < 24; ++x) {
          const double r = std::hypot(4.0 * x - 46, 4.0 * y - 46, 4.0 * z - 46);
          slice.values.push_back(static_cast<int>(std::clamp(45 - r, -4.0, 4.0) * 300 + 300));
        }
      scenes::DicomFile file = slice_file(slice);
      file.set(0x00100010, "PN", "ZIMMERMANN^Erika").set(0x00100020, "LO", "KENNUNG-4711");
      file.set(0x00080080, "LO", "SPITAL-WEIT").set(0x00080020, "DA", "19560401");
      file.set(0x00100030, "DA", "19560401").set(0x00081030, "LO", "zimmermann study");
      file.write(file_in(folder, "SCHMIDT_" + std::to_string(z) + ".dcm"));
    }
  }
  std::string file_in(const std::string& folder, const std::string& name) const {
    return (folder_ / folder / name).string();
  }
  /// Returns the name of a file of the folder and the planted name in its contents, or "" if no file contains
  /// a planted name.
  std::string named_in(const fs::path& folder) const {
    for (const auto& entry : fs::recursive_directory_iterator(folder)) {
      if (!entry.is_regular_file()) continue;
      const std::string finding = named(read(entry.path().string()));
      if (!finding.empty()) return entry.path().filename().string() + ": " + finding;
    }
    return "";
  }
  static std::string named(const std::string& text) {
    for (const std::string& name : k_planted)
      if (text.find(name) != std::string::npos) return name;
    return "";
  }
  std::string json_output(const std::string& arguments) const { return run(arguments + " --json").out; }

  const std::string scan_ = "MUSTERMANN_Hans M\xfcLLER";
  const std::string quoted_ = "'" + scan_ + "'";
};

TEST_F(Identity, AppearsInNoOutput) {
  fs::create_directory(folder_ / "written");
  ASSERT_EQ(run("mesh " + quoted_ + " -o VOGEL.ply").exit_code, 0);
  ASSERT_EQ(run("info " + quoted_).exit_code, 0);
  const std::string path = " --path LEHMANN.csv ";
  const std::vector<std::string> commands{
      "info " + quoted_, "mesh " + quoted_ + " -o written/a.ply",
      "touch " + quoted_ + path + "-o written/t.csv --mesh VOGEL.ply --record written/t.session --embed",
      "drill " + quoted_ + path + "--burr-diameter 8 -o written/d.mha --record written/d.session",
      "drill " + quoted_ + path + "--burr-diameter 8 -o written/d.nii.gz",
      "drill " + quoted_ + path + "--burr-diameter 8 -o written/d.nrrd",
      "import " + quoted_ + " -o written/KRAUSE", "view " + quoted_ + " --screenshot written/v.png",
      "info written/t.session", "info written/KRAUSE",
      "replay written/t.session --verify --table written/s.csv --screenshot written/r.png -o written/r.mha",
      "replay written/d.session --scan " + quoted_ + " --until 0.2 --screenshot written/u.png",
      "resume written/d.session --scan " + quoted_ + path, "audit written/t.session",
      "bench touch " + quoted_, "bench feel " + quoted_ + " --quick --only none -o written/feel",
      // Errors contain no name either.
      "info MUSTERMANN_Hanz", "touch " + quoted_ + " --path WEBER.csv -o written/x.csv",
      "touch " + quoted_ + path + "-o " + quoted_ + "/SCHMIDT_1.dcm", "info " + quoted_ + "/SCHMIDT_1.dcm",
      "replay VOGEL.ply", "mesh VOGEL.ply -o written/y.ply",
      "drill head --path SCHMIDT.csv -o written/y.mha"};
  for (const std::string& command : commands) {
    const std::string answer = json_output(command);
    EXPECT_EQ(named(answer), "") << command << "\n" << answer;
    EXPECT_FALSE(answer.empty()) << command;
  }
  // The case's folder has the requested name; its files do not contain it.
  EXPECT_EQ(named_in(folder_ / "written"), "");
  for (const char* result : {"t.csv", "t.session", "d.mha", "KRAUSE/case.toml", "v.png", "r.png"})
    EXPECT_TRUE(fs::exists(folder_ / "written" / result)) << result;
}

/// Names of files in archives and DICOM directories, and descriptions of series, are no arguments of the
/// command, so they cannot be recognised by comparison. Notices show them on the terminal, but not in JSON.
TEST_F(Identity, AppearsInNoJsonNoticeOfDisksAndArchives) {
  write_scan("disk/WEBER_H/LEHMANN", 24, "1.2.752.24.7");
  scenes::DicomFile()
      .set(0x00080016, "UI", "1.2.840.10008.1.3.10")
      .set_items(0x00041220, {scenes::DicomFile().set(0x00041500, "CS", "WEBER_H\\VOGEL\\IM1"),
                              scenes::DicomFile().set(0x00041500, "CS", "WEBER_H\\LEHMANN\\KRAUSE")})
      .write((folder_ / "disk/DICOMDIR").string());
  write("disk/WEBER_H/LEHMANN/MUSTERMANN.txt", "hello");
  const auto shell = [&](const std::string& command) {
    return std::system(("cd '" + folder_.string() + "' && " + command).c_str()) == 0;
  };
  ASSERT_TRUE(shell(
      "tar cf whole.tar -C disk . && rm disk/WEBER_H/LEHMANN/SCHMIDT_9.dcm && tar cf gap.tar -C disk ."));
  write_scan("two/WEBER_H", 24, "1.2.752.24.7");
  write_scan("two/LEHMANN", 12, "1.2.752.24.8");
  for (const char* what :
       {"info whole.tar", "info gap.tar", "info disk", "info two", "convert whole.tar -o w.mha"}) {
    const std::string answer = json_output(what);
    EXPECT_EQ(named(answer), "") << what << "\n" << answer;
  }
  EXPECT_NE(run("info whole.tar").err.find("VOGEL"), std::string::npos) << "shown on the terminal";
  EXPECT_NE(run("info gap.tar").err.find("SCHMIDT_8"), std::string::npos) << "shown on the terminal";
}

/// Text that is drawn in a picture is also stored in the description of its PNG file, so that a search of the
/// file finds it.
TEST_F(Identity, IsSearchedWhereItCouldAppear) {
  ASSERT_EQ(run("import " + quoted_ + " --name VOGEL -o case").exit_code, 0);
  ASSERT_EQ(run("view case --screenshot v.png").exit_code, 0);
  EXPECT_EQ(named(read(file("v.png"))), "VOGEL") << "a name that was chosen is drawn, and found";
  EXPECT_EQ(named(json_output("info case")), "VOGEL");
  EXPECT_EQ(named(json_output("info " + quoted_ + " --keep-identity")), "MUSTERMANN");
  EXPECT_NE(run("info " + quoted_ + " --keep-identity").err.find("--keep-identity"), std::string::npos);
}

/// Control sequences in a name are shown, not executed.
TEST_F(Identity, NamesDoNothingToATerminal) {
  const std::string evil = "'a\x1b]0;owned\x07\x1b[2J\xc2\x9b\xe2\x80\xae.mha'";
  const ProcessResult r = run("info " + evil);
  EXPECT_EQ(r.exit_code, 2);
  for (const char c : {'\x1b', '\x07'}) EXPECT_EQ(r.err.find(c), std::string::npos) << r.err;
  EXPECT_NE(r.err.find("\\x1b]0;owned"), std::string::npos) << r.err;
  EXPECT_EQ(r.err.find("\xe2\x80\xae"), std::string::npos);
  EXPECT_NE(run("info 'x\nnote: all is well.mha'").err.find("x\\x0anote"), std::string::npos)
      << "a name cannot imitate a note of the program";
  ASSERT_EQ(run("phantom sphere --size 24 -o s.mha").exit_code, 0);
  fs::rename(folder_ / "s.mha", folder_ / "s\x1b[31m\xff\xc3\xbc.mha");
  const ProcessResult info = run("info 's\x1b[31m\xff\xc3\xbc.mha'");
  EXPECT_EQ(info.exit_code, 0);
  EXPECT_NE(info.out.find("s\\x1b[31m\\xff\xc3\xbc.mha"), std::string::npos) << info.out;
}

}  // namespace
}  // namespace trephine::command_tests
