// The commands of trephine, without their command line: options in, an Outcome or an Error out.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "apps/trephine/recording.h"
#include "apps/trephine/report.h"
#include "apps/trephine/source.h"

namespace trephine::app {

struct PhantomArguments {
  std::string name, size, spacing, output, labels_output;
  std::optional<double> psf;
  double shear = 0;
  std::uint64_t seed = 1;
  std::vector<std::string> settings;  ///< key=value
};
volume::Result<Outcome> run_phantom(const PhantomArguments& arguments);

struct InfoArguments {
  std::string source;
};
volume::Result<Outcome> run_info(const InfoArguments& arguments);

struct MeshArguments {
  std::string source, output;
  ShapeChoice shape;
  bool is_open = false;
};
volume::Result<Outcome> run_mesh(const MeshArguments& arguments);

struct TouchArguments {
  std::string source, path, output, method = haptics::k_default_method, friction;
  ShapeChoice shape;
  double stiffness = 0.5, alpha = 0.3, rate = 1000, radius = 0, blur = 0;
  std::vector<std::string> meshes;   ///< files of polygonal models
  double mesh_scale = 1;             ///< mm per unit of theirs
  std::string mesh_at;               ///< x,y,z: where their origin lies; empty: 0,0,0
  std::vector<std::string> effects;  ///< in words (haptics/force/effects.h)
  std::string stiffness_ramp;        ///< HU0,HU1,K1
  double viscosity = 0, pop_force = 0;
  bool is_passive = false;
  RecordChoice record;
};
volume::Result<Outcome> run_touch(const TouchArguments& arguments);

struct DrillArguments {
  std::string source, path, output;
  ShapeChoice shape;
  double burr_diameter = 4, rate = 1000, removal_rate = 30;
  std::optional<double> smallest_burr;  ///< mm
  bool is_kinematic = false, is_round = false;
  std::string method = haptics::k_default_method;
  RecordChoice record;
};
volume::Result<Outcome> run_drill(const DrillArguments& arguments);

struct ViewArguments {
  std::string source = "head", screenshot;
  ShapeChoice shape;
  double burr_diameter = 4;
  std::optional<double> smallest_burr;  ///< mm
  bool is_round = false;
  std::optional<double> seconds;
  RecordChoice record;
  bool has_no_autosave = false;
};
volume::Result<Outcome> run_view(const ViewArguments& arguments);

struct DemoArguments {
  std::string source = "head", output = "out";
  ShapeChoice shape;
  bool has_no_window = false;
  RecordChoice record;
};
volume::Result<Outcome> run_demo(const DemoArguments& arguments);

struct ReplayArguments {
  std::string session, case_source, output, steps, screenshot;
  std::optional<double> until;
  bool is_verifying = false, wants_window = false;
};
volume::Result<Outcome> run_replay(const ReplayArguments& arguments);

struct ResumeArguments {
  std::string session, case_source, path;
};
volume::Result<Outcome> run_resume(const ResumeArguments& arguments);

struct ImportArguments {
  std::string source, output, name, labels;
  ShapeChoice shape;
};
volume::Result<Outcome> run_import(const ImportArguments& arguments);

struct DoctorArguments {
  std::string output;
  double seconds = 3;
};
volume::Result<Outcome> run_doctor(const DoctorArguments& arguments);

struct SoakArguments {
  std::string source = "head", session;
  ShapeChoice shape;
  double seconds = 3600, rate = 1000;
  std::uint64_t seed = 1;
};
volume::Result<Outcome> run_soak(const SoakArguments& arguments);

struct BenchArguments {
  std::string what, source, case_source, output, only, export_folder, score, hand;
  int size = 512;
  std::int64_t steps = 1'000'000;
  bool is_quick = false;
};
volume::Result<Outcome> run_bench(const BenchArguments& arguments);

struct AuditArguments {
  std::string session, case_source;  ///< a session to certify; empty: rays
  std::uint64_t rays = 1'000'000, seed = 7;
  std::string plant;  ///< "fall", "force", "torque", "energy" or "ball": what one tick gets wrong before it is judged
};
volume::Result<Outcome> run_audit(const AuditArguments& arguments);

}  // namespace trephine::app
