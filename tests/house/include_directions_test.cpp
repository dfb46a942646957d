// Directions of includes: every source file is checked against the tables below, which state the directions
// of docs/layout.md. Functions that would make replays depend on the machine are found as well.
#include <filesystem>
#include <fstream>
#include <gtest/gtest.h>
#include <map>
#include <regex>
#include <set>
#include <string>

namespace {

namespace fs = std::filesystem;

const std::map<std::string, std::set<std::string>> k_may_use{
    {"volume", {"volume"}},
    {"haptics", {"haptics", "volume"}},
    {"sim", {"sim", "haptics", "volume"}},
    {"modules", {"sim", "haptics", "volume"}},  // and each module its own folder
    {"data-tools", {"data-tools", "volume"}},
    {"apps", {"apps", "modules", "sim", "haptics", "data-tools", "volume"}},
    {"tests", {"tests", "apps", "modules", "sim", "haptics", "data-tools", "volume"}},
};
/// Folders of apps/. Each may use the listed folders in addition to itself.
const std::map<std::string, std::set<std::string>> k_apps_may_use{
    {"verify", {}},
    {"workbench", {}},
    {"c_api", {"api"}},
    {"python", {"api"}},
    {"imaging", {"workbench"}},
    {"api", {"imaging", "workbench"}},
    {"view", {"imaging", "workbench"}},
    {"window", {"view", "imaging", "workbench"}},
    {"bench", {"verify", "cli", "view", "imaging", "workbench"}},
    {"cli", {"verify", "bench", "view", "imaging", "workbench"}},
};
/// Beginnings of the names of third-party headers, and beginnings of the paths of all files that may include
/// these headers.
const std::map<std::string, std::vector<std::string>> k_outsiders{
    {"vtk",
     {"apps/view/", "apps/window/", "data-tools/formats/vti.cpp", "data-tools/formats/vtk_errors.h",
      "data-tools/meshes/mesh_reading.cpp", "data-tools/meshes/polygon_builder.cpp",
      "data-tools/formats/invesalius.cpp", "tests/data-tools/round_trip_test.cpp", "apps/bench/peer_",
      "tests/apps/window_", "tests/apps/picture_layout_test.cpp", "tests/apps/structures_test.cpp",
      "tests/apps/eye_display_test.cpp", "tests/apps/whole_picture_test.cpp"}},
    {"itk",
     {"data-tools/formats/image_files.cpp", "tests/data-tools/round_trip_test.cpp", "apps/bench/peer_"}},
    {"gdcm", {"data-tools/dicom/dicom_pixels.cpp", "data-tools/dicom/dicom_writer.cpp"}},
    {"teem/", {"data-tools/formats/nrrd.cpp"}},
    {"nifti", {"data-tools/formats/nifti.cpp", "tests/data-tools/"}},
    {"archive", {"data-tools/files/archive.cpp"}},
    {"pybind11/", {"apps/python/"}},
    {"CLI/", {"apps/cli/command_line.cpp", "apps/cli/options/options.cpp"}},
    {"nlohmann/",
     {"apps/cli/", "apps/bench/commands/", "haptics/hardware/inverse3_message.cpp",
      "data-tools/formats/depth_video.cpp", "data-tools/formats/picture_stack.cpp",
      "data-tools/cases/plan_file.cpp", "tests/"}},
    {"toml.hpp", {"data-tools/cases/toml_reader_impl.h"}},
    {"hdf5.h", {"data-tools/formats/hdf5_library.cpp"}},
    {"openvdb/", {"data-tools/formats/vdb_library.cpp", "apps/bench/peer_"}},
    {"OpenImageIO/", {"data-tools/formats/picture_library.cpp"}},
    {"nanovdb/", {"apps/bench/peer_"}},
    {"embree3/", {"apps/bench/peer_"}},
    {"fcl/", {"apps/bench/peer_"}},
    {"Q", {"apps/window/qt_", "tests/apps/window_"}},
    {"openxr/", {"apps/view/hmd.cpp", "tests/apps/openxr_stand_in.cpp"}},
    {"GL/", {"apps/view/hmd.cpp", "tests/apps/openxr_stand_in.cpp"}},
    {"tbb/", {}},
    {"gtest/", {"tests/"}},
};

/// Returns the fault of an `include` in `file` (relative paths); an empty text if the include is allowed.
std::string fault(const std::string& file, const std::string& include, bool is_quoted) {
  const std::string top_folder = file.substr(0, file.find('/'));
  if (is_quoted) {
    const std::string target = include.substr(0, include.find('/'));
    if (include.find('/') == std::string::npos) return "includes are written from the top: " + include;
    if (top_folder == "modules" && target == "modules") {
      const auto module = [](const std::string& path) { return path.substr(0, path.find('/', 8)); };
      const bool is_catalogue = file.starts_with("modules/catalogue.");
      return is_catalogue || module(file) == module(include) ? "" : "a module includes another module";
    }
    if (file.starts_with("apps/verify/") && target != "volume" && !include.starts_with("apps/verify/"))
      return "a judge uses more than volume";
    if (top_folder == "apps" && target == "apps") {
      const auto folder = [](const std::string& path) { return path.substr(5, path.find('/', 5) - 5); };
      const std::string from = folder(file), to = folder(include);
      if (from == "cli" && to == "bench" && !include.starts_with("apps/bench/scenes/"))
        return "apps/cli may use only the scenes of apps/bench";
      return from == to || k_apps_may_use.at(from).contains(to) ? ""
                                                                : "apps/" + from + " may not use apps/" + to;
    }
    const auto& allowed = k_may_use.at(top_folder);
    return allowed.contains(target) ? "" : top_folder + " may not use " + target;
  }
  for (const auto& [prefix, places] : k_outsiders) {
    if (!include.starts_with(prefix) ||
        (prefix == "Q" && (include.size() < 2 || !std::isupper(static_cast<unsigned char>(include[1])))))
      continue;
    for (const std::string& place : places)
      if (file.starts_with(place)) return "";
    return "<" + include + "> does not belong in " + file;
  }
  return "";
}

TEST(House, IncludesPointDownward) {
  const fs::path root = TREPHINE_SOURCE_DIR;
  const std::regex line_of(R"(^\s*#\s*include\s*([<"])([^>"]+)[>"])");
  int files = 0, includes = 0;
  for (const auto& [top_folder, unused] : k_may_use)
    for (const auto& entry : fs::recursive_directory_iterator(root / top_folder)) {
      const std::string extension = entry.path().extension();
      if (extension != ".h" && extension != ".cpp") continue;
      ++files;
      std::ifstream in(entry.path());
      std::string line;
      const std::string file = fs::relative(entry.path(), root).generic_string();
      while (std::getline(in, line)) {
        std::smatch match;
        if (!std::regex_search(line, match, line_of)) continue;
        ++includes;
        EXPECT_EQ(fault(file, match[2], match[1] == "\""), "") << file << ": " << line;
      }
    }
  EXPECT_GT(files, 40);
  EXPECT_GT(includes, 200);
}

TEST(House, TheRuleFindsForbiddenDirections) {
  EXPECT_NE(fault("volume/scan/field.cpp", "haptics/force/force.h", true), "");
  EXPECT_NE(fault("haptics/force/force.cpp", "sim/tool.h", true), "");
  EXPECT_NE(fault("modules/drilling/burr.cpp", "modules/bone_flap/saw.h", true), "");
  EXPECT_NE(fault("modules/drilling/burr.cpp", "modules/catalogue.h", true), "");
  EXPECT_NE(fault("modules/drilling/burr.cpp", "data-tools/phantoms/phantoms.h", true), "");
  EXPECT_NE(fault("sim/drivers/lockstep.cpp", "vtkSmartPointer.h", false), "");
  EXPECT_NE(fault("data-tools/phantoms/phantoms.cpp", "sim/tool.h", true), "");
  EXPECT_NE(fault("apps/view/window.cpp", "apps/bench/scenes/scenes.h", true), "");
  EXPECT_NE(fault("apps/view/window.cpp", "apps/window/qt_window.h", true), "");
  EXPECT_NE(fault("apps/cli/main.cpp", "apps/bench/scorer.h", true), "");
  EXPECT_NE(fault("apps/verify/ball_judge.cpp", "haptics/force/force.h", true), "");
  EXPECT_NE(fault("volume/scan/field.cpp", "field.h", true), "");
  EXPECT_EQ(fault("modules/drilling/burr.cpp", "modules/drilling/burr.h", true), "");
  EXPECT_EQ(fault("apps/view/window.cpp", "vtkActor.h", false), "");
}

/// Returns true if the line calls a function whose last bits depend on the C library or the CPU. A replay
/// with such a function could differ on another machine.
bool is_inexact(const std::string& line) {
  static const std::regex inexact(
      R"((std::(sin|cos|tan|asin|acos|atan2?|exp2?|expm1|log(10|2|1p)?|pow|cbrt|hypot|sinh|cosh|tanh|erfc?)|glm::(slerp|angleAxis|rotate|sin|cos|tan|pow|exp|log))\()");
  return std::regex_search(line, inexact);
}

TEST(House, ReplayedCodeCallsNoInexactFunctions) {
  const fs::path root = TREPHINE_SOURCE_DIR;
  int files = 0;
  for (const char* top_folder : {"volume", "haptics", "sim", "modules"})
    for (const auto& entry : fs::recursive_directory_iterator(root / top_folder)) {
      const std::string extension = entry.path().extension();
      const std::string file = fs::relative(entry.path(), root).generic_string();
      if (extension != ".h" && extension != ".cpp") continue;
      if (file == "volume/cuts/cut_lattice.cpp") continue;  // only rounds a number in an error text
      // Sessions record the poses of a device, so that a replay does not compute them.
      if (file == "haptics/device/falcon_kinematics.cpp") continue;
      ++files;
      std::ifstream in(entry.path());
      for (std::string line; std::getline(in, line);)
        EXPECT_FALSE(is_inexact(line)) << file << ": " << line << "\nuse volume/base/deterministic_math.h";
    }
  EXPECT_GT(files, 100);
  EXPECT_TRUE(is_inexact("const double a = std::atan2(y, x);") && is_inexact("glm::slerp(a, b, t)"));
  EXPECT_FALSE(is_inexact("std::sqrt(x) + deterministic_sin(x)"));
}

}  // namespace
