// Command: runs the trephine command as users do, in its own scratch folder.
#pragma once

#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <set>
#include <sstream>
#include <string>
#include <sys/wait.h>

#include "apps/bench/scenes/scratch.h"

namespace trephine::command_tests {

namespace fs = std::filesystem;
using Json = nlohmann::json;

struct ProcessResult {
  int exit_code;
  std::string out, err;
};

class Command : public ::testing::Test {
 protected:
  std::string file(const std::string& name) const { return (folder_ / name).string(); }
  static std::string read(const std::string& path) {
    std::ifstream in(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
  }
  void write(const std::string& name, const std::string& text) const {
    std::ofstream(folder_ / name, std::ios::binary) << text;
  }

  /// Runs trephine, or trephine-bench if the arguments begin with "bench", in the scratch folder, without a
  /// display unless `prefix` provides one.
  ProcessResult run(const std::string& arguments, const std::string& prefix = "env -u DISPLAY") const {
    const bool is_bench = arguments.starts_with("bench ");
    const std::string command =
        "cd '" + folder_.string() +
        "' && export XDG_STATE_HOME=\"$PWD/.state\" XDG_CONFIG_HOME=\"$PWD/.config\" && " + prefix +
        (is_bench ? " '" TREPHINE_BENCH "' " : " '" TREPHINE_COMMAND "' ") +
        arguments.substr(is_bench ? 6 : 0) + " >.out 2>.err </dev/null";
    const int status = std::system(command.c_str());
    return {WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status), read(file(".out")),
            read(file(".err"))};
  }
  Json json(const std::string& arguments) const {
    const ProcessResult r = run(arguments + " --json");
    EXPECT_EQ(r.exit_code, 0) << arguments << "\n" << r.out << r.err;
    return Json::parse(r.out, nullptr, false);
  }
  /// Planned screw in the left pedicle of L4 of the case `real`, for its case.toml.
  static constexpr const char* k_real_pedicle =
      "\n[[trajectories]]\nname = \"L4 left pedicle\"\nentry = [25.0, -113.0, 285.0]\n"
      "target = [6.0, -146.0, 285.0]\ndiameter = 6.0\nside = \"left\"\nvertebra = \"vertebrae_L4\"\n";
  /// Makes the case `real` from the lumbar CT and its labels in `data`, the folder of real data.
  void import_real_spine(const std::string& data) const {
    EXPECT_EQ(run("import " + data + "/spine_lumbar/example_ct.nii.gz --labels " + data +
                  "/spine_lumbar/spine_report/totalseg.nii.gz --preset spine -o real")
                  .exit_code,
              0);
  }
  /// Returns the name of a file in the scratch folder that is not in `expected`, or "".
  std::string leftovers(const std::set<std::string>& expected) const {
    for (const auto& entry : fs::directory_iterator(folder_)) {
      const std::string name = entry.path().filename().string();
      if (name != ".out" && name != ".err" && name != ".state" && !expected.contains(name)) return name;
    }
    return "";
  }
  /// Writes a path that presses `depth` mm into a sphere of radius 45 mm from above, then moves to the side.
  void write_press(const char* name, double depth) const {
    std::ostringstream path;
    path << "t,x,y,z\n0,0.3,0.2,60\n0.2,0.3,0.2,46\n0.6,0.3,0.2," << 45 - depth << "\n1,0.3,0.2,"
         << 45 - depth << "\n1.2,8.3,0.2," << 45 - depth << "\n";
    write(name, path.str());
  }
  scenes::Scratch scratch_;
  const fs::path& folder_ = scratch_.path;
};

/// Returns an NRRD file as text: `size` voxels of 1 mm along each axis, with the values value(x, y, z).
template <class Value>
std::string nrrd(int size, const Value& value, const std::string& keys = "") {
  const std::string n = std::to_string(size);
  std::string text =
      "NRRD0004\ntype: short\ndimension: 3\nspace: left-posterior-superior\nsizes: " + n + " " + n + " " + n +
      "\nspace directions: (1,0,0) (0,1,0) (0,0,1)\nspace origin: (0,0,0)\nencoding: ascii\n" + keys + "\n";
  for (int z = 0; z < size; ++z)
    for (int y = 0; y < size; ++y)
      for (int x = 0; x < size; ++x) text.append(std::to_string(value(x, y, z))).append(" ");
  return text;
}

}  // namespace trephine::command_tests
