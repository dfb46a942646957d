// The command line: what people type, turned into the arguments of commands.h. The only file that knows
// CLI11.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <functional>

#include "apps/trephine/build_info.h"
#include "apps/trephine/commands.h"
#include "haptics/force/effects.h"

namespace {

using namespace trephine;
using app::Outcome;
using volume::Error;
using volume::Result;

void add_shape_options(CLI::App* command, app::ShapeChoice& shape) {
  command->add_option("--iso", shape.iso, "Solid from this value up (CT: HU; default 300)")->type_name("V");
  command->add_option("--window", shape.window, "Solid between two values; either end may be empty")
      ->type_name("LO:HI");
  command->add_option("--label", shape.label, "Solid where the volume has this label")->type_name("NAME");
}

CLI::Option* add_source(CLI::App* command, std::string& source) {
  const char* help =
      "DICOM folder, case folder, .mha, .mhd, .nrrd, .nii(.gz), or head (built in; ./head is a path)";
  return command->add_option("SRC", source, help)->required();
}

constexpr const char* k_round_help =
    "The bone is touched with the burr's ball, whose middle the hand holds, instead of its lowest point; a "
    "voxel or a twelfth smaller than it cuts, so that it has room in its own hole; to 12 mm";

void add_record(CLI::App* command, app::RecordChoice& record) {
  command->add_option("--record", record.file, "Write the session to this new file")->type_name("FILE");
  command->add_flag("--embed", record.is_embedding, "Keep the scan in the session too (large)");
}

void add_case(CLI::App* command, std::string& session, std::string& source) {
  command->add_option("SESSION", session, "A recorded session")->required();
  command->add_option("--case", source, "The case or scan that was operated on")->type_name("SRC");
}

/// Says the outcome or the error in the form that was asked for, and gives the exit code.
int finish(const std::string& name, bool wants_json, Result<Outcome> result) {
  if (!result) {
    if (wants_json)
      std::printf("%s\n", app::text_of_json(app::error_report(name, result.error())).c_str());
    else
      std::fprintf(stderr, "error: %s\n", result.error().message().c_str());
    return app::exit_code_of(result.error());
  }
  const Outcome& outcome = result.value();
  std::fputs(wants_json ? (app::text_of_json(outcome.json) + "\n").c_str() : outcome.text.c_str(), stdout);
  if (std::fflush(stdout) != 0) return app::exit_missing_here;
  return outcome.exit_code;
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App cli{"trephine: surgery on real CT and MRI volumes that you can feel"};
  cli.set_version_flag("--version", std::string("trephine ") + TREPHINE_VERSION + " (" + TREPHINE_COMMIT +
                                        ", " + TREPHINE_COMPILER + ")");
  cli.name("trephine");
  cli.require_subcommand(1);
  cli.footer(
      "Examples:\n  trephine demo\n  trephine info SCANS/HEAD\n  trephine view SCANS/HEAD\n  trephine "
      "COMMAND --help");
  bool wants_json = false;
  std::string chosen;
  std::function<Result<Outcome>()> run;
  const auto add = [&](const char* name, const char* help, const char* examples, auto& arguments,
                       auto action) {
    CLI::App* command = cli.add_subcommand(name, help);
    command->add_flag("--json", wants_json, "One JSON object on stdout, errors too");
    command->footer(std::string("Examples:\n") + examples);
    command->callback([&, name, action] {
      chosen = name;
      run = [&arguments, action] { return action(arguments); };
    });
    return command;
  };

  app::PhantomArguments phantom;
  CLI::App* c = add("phantom", "Make a volume whose shape is known exactly",
                    "  trephine phantom sphere --size 256 --psf 1.5 -o sphere.mha\n"
                    "  trephine phantom plate --set thickness=2 --set angle=30 -o plate.nrrd\n"
                    "  trephine phantom head --spacing 0.6 -o head.nii.gz --labels head-labels.nii.gz",
                    phantom, app::run_phantom);
  c->add_option("NAME", phantom.name,
                "sphere, plane, plate, torus, gyroid, shell, groove, corner, slot, cone, steps or head")
      ->required();
  c->add_option("--size", phantom.size, "Voxels along each axis")->type_name("N|X,Y,Z");
  c->add_option("--spacing", phantom.spacing, "Voxel size, mm")->type_name("S|X,Y,Z");
  c->add_option("--psf", phantom.psf, "Scanner blur: sigma in voxels, 0 to 2")->type_name("SIGMA");
  c->add_option("--shear", phantom.shear, "Gantry tilt, degrees")->type_name("D");
  c->add_option("--seed", phantom.seed, "Of the noise")->type_name("K");
  c->add_option("--set", phantom.settings, "A parameter of the shape, such as radius=40")
      ->type_name("KEY=VALUE");
  c->add_option("-o,--output", phantom.output, ".mha, .nrrd, .nii or .nii.gz")->required();
  c->add_option("--labels", phantom.labels_output, "Also write the labels to this file (head)")
      ->type_name("FILE");

  app::InfoArguments info;
  c = add("info", "Say what a scan, a case or a session holds",
          "  trephine info SCANS/HEAD\n  trephine info head --json", info, app::run_info);
  add_source(c, info.source);

  app::ImportArguments import;
  c = add(
      "import", "Make a case of a scan: volumes in open formats and a plan to edit",
      "  trephine import SCANS/HEAD -o head-case\n  trephine import head --name training -o training-case",
      import, app::run_import);
  add_source(c, import.source);
  add_shape_options(c, import.shape);
  c->add_option("--labels", import.labels, "Labels on the grid of the scan")->type_name("FILE");
  c->add_option("--name", import.name, "Of the case, never a patient's (default: the folder's)")
      ->type_name("NAME");
  c->add_option("-o,--output", import.output, "A new folder")->required()->type_name("CASE");

  app::MeshArguments mesh;
  c = add("mesh", "Write the surface of a shape as a mesh",
          "  trephine mesh SCANS/HEAD -o skull.stl\n  trephine mesh head --label dura -o dura.ply", mesh,
          app::run_mesh);
  add_source(c, mesh.source);
  add_shape_options(c, mesh.shape);
  c->add_option("-o,--output", mesh.output, ".stl, .ply, .obj or .vtp")->required();
  c->add_flag("--open", mesh.is_open, "Leave holes where the shape reaches the border of the scan");

  app::TouchArguments touch;
  c = add("touch", "Play a path of the stylus over a shape: where it is held, and the force",
          "  trephine touch head --path docs/examples/path.csv -o steps.csv\n"
          "  trephine touch head --label dura --path path.csv -o steps.csv --rate 4000 --json\n"
          "  trephine touch head --path path.csv -o steps.csv --effect \"viscous damping=0.004\" --passive\n"
          "  trephine touch head --mesh retractor.ply --mesh-at 0,-90,20 --path path.csv -o steps.csv",
          touch, app::run_touch);
  add_source(c, touch.source);
  add_shape_options(c, touch.shape);
  c->add_option("--path", touch.path,
                "CSV with t,x,y,z[,qx,qy,qz,qw][,button]: seconds; mm with x to the patient's left, y to the "
                "back, z up (LPS); pressed throughout without a button")
      ->required()
      ->type_name("PATH.csv");
  c->add_option("-o,--output", touch.output, "A row for every step")->required()->type_name("STEPS.csv");
  c->add_option("--method", touch.method, "How the proxy is kept on the surface: " + haptics::method_names())
      ->capture_default_str();
  c->add_option("--radius", touch.radius, "Of the tool's tip, 0 (a point) to 6 mm")
      ->capture_default_str()
      ->type_name("MM");
  c->add_option(
       "--mesh", touch.meshes,
       "A polygonal model to touch too (.ply, .ply.gz, .obj, .stl, .vtk, .vtp); may come again; with "
       "--method scene unless another is named")
      ->type_name("FILE");
  c->add_option("--mesh-scale", touch.mesh_scale, "Of the models: 1000 for metres")
      ->capture_default_str()
      ->type_name("MM");
  c->add_option("--mesh-at", touch.mesh_at, "Where the models' origin lies, mm (LPS); 0,0,0 unless given")
      ->type_name("X,Y,Z");
  c->add_option("--blur", touch.blur,
                "Gaussian over the scan before it is touched: sigma in voxels, 1.4 for the seven taps of the "
                "ray-step method's source")
      ->capture_default_str()
      ->type_name("VOXELS");
  c->add_option("--stiffness", touch.stiffness, "Of the surface, N/mm")
      ->capture_default_str()
      ->type_name("N/MM");
  c->add_option("--stiffness-ramp", touch.stiffness_ramp,
                "Harder where the scan is denser: from --stiffness at intensity A to K (N/mm) at B and above")
      ->type_name("A,B,K");
  c->add_option("--viscosity", touch.viscosity, "Along the surface, 0 to 0.05 N s/mm")
      ->capture_default_str()
      ->type_name("N.S/MM");
  c->add_option("--pop-through", touch.pop_force, "Pressed harder than this the surface gives way; 0: never")
      ->capture_default_str()
      ->type_name("N");
  c->add_option("--effect", touch.effects,
                "A force beside the surface's: a name of " + haptics::effect_names() +
                    " and its parameters in quotes; may come again")
      ->type_name("WORDS");
  c->add_flag("--passive", touch.is_passive, "Surfaces give the hand no more energy than they took");
  c->add_option("--friction", touch.friction, "Static and dynamic coefficient (default 0.2,0.15)")
      ->type_name("S,D");
  c->add_option("--alpha", touch.alpha,
                "Smoothing of the force: weight of the newest value at 1 kHz; 1 = none")
      ->capture_default_str()
      ->type_name("A");
  c->add_option("--rate", touch.rate, "Servo steps a second")->capture_default_str()->type_name("HZ");
  add_record(c, touch.record);

  app::DrillArguments drill;
  c = add("drill", "Play a path of a burr and write what is left",
          "  trephine drill SCANS/HEAD --burr-diameter 4 --path path.csv -o drilled.mha\n"
          "  trephine drill head --burr-diameter 6 --kinematic --path path.csv -o drilled.nii.gz --json",
          drill, app::run_drill);
  add_source(c, drill.source);
  add_shape_options(c, drill.shape);
  c->add_option("--burr-diameter", drill.burr_diameter, "mm")->required()->type_name("MM");
  c->add_option(
       "--smallest-burr", drill.smallest_burr,
       "The smallest burr that will cut in this session, mm: the finer it is the finer cuts are sampled "
       "(default: the burr)")
      ->type_name("MM");
  c->add_option("--path", drill.path,
                "CSV with t,x,y,z[,qx,qy,qz,qw][,button]: seconds; mm with x to the patient's left, y to the "
                "back, z up (LPS); pressed throughout without a button")
      ->required()
      ->type_name("PATH.csv");
  c->add_option("--rate", drill.rate, "Servo steps a second")->capture_default_str()->type_name("HZ");
  c->add_option("--removal-rate", drill.removal_rate,
                "mm3/s that the burr can take away; pushed no faster than that it meets no force")
      ->capture_default_str();
  c->add_flag("--kinematic", drill.is_kinematic,
              "The path is the burr's centre and everything it sweeps goes; without this it is the burr's "
              "lowest point, and bone is removed where it presses");
  c->add_option("-o,--output", drill.output, ".mha, .nrrd, .nii or .nii.gz")->required();
  c->add_flag("--round", drill.is_round, k_round_help);
  c->add_option("--method", drill.method, "How the proxy is kept on the surface: " + haptics::method_names())
      ->capture_default_str();
  add_record(c, drill.record);

  app::ViewArguments view;
  c = add("view", "Open a window to touch and drill with the mouse",
          "  trephine view SCANS/HEAD\n  trephine view head --screenshot head.png", view, app::run_view);
  add_source(c, view.source)->required(false);
  add_shape_options(c, view.shape);
  c->add_option("--burr-diameter", view.burr_diameter, "mm")->capture_default_str()->type_name("MM");
  c->add_option(
       "--smallest-burr", view.smallest_burr,
       "The smallest burr that can be chosen in the window, mm: the finer it is the finer cuts are sampled "
       "(default: 2, or the burr if that is smaller)")
      ->type_name("MM");
  c->add_option("--screenshot", view.screenshot, "Write a picture; without --seconds no window is opened")
      ->type_name("OUT.png");
  c->add_option("--seconds", view.seconds, "Close the window by itself after so long")->type_name("S");
  c->add_flag("--round", view.is_round, k_round_help);
  add_record(c, view.record);
  c->add_flag("--no-autosave", view.has_no_autosave, "Do not keep the session in ~/.local/state/trephine");

  app::DemoArguments demo;
  c = add("demo", "Touch, slide and drill a burr hole by itself; pictures and a report",
          "  trephine demo\n  trephine demo SCANS/HEAD -o out-head --no-window", demo, app::run_demo);
  c->add_option("SRC", demo.source, "As everywhere; head when left out")->capture_default_str();
  add_shape_options(c, demo.shape);
  c->add_option("-o,--output", demo.output, "Folder for pictures and report.json")->capture_default_str();
  c->add_flag("--no-window", demo.has_no_window, "Do not open a window at the end");
  add_record(c, demo.record);

  app::ReplayArguments replay;
  c = add("replay", "Run a recorded session again",
          "  trephine replay drill.session --verify\n"
          "  trephine replay drill.session --case head-case --until 12.5 -o then.mha --screenshot then.png",
          replay, app::run_replay);
  add_case(c, replay.session, replay.case_source);
  c->add_flag("--window", replay.wants_window, "Play it in the window: pause, seek, speed, forces");
  c->add_flag("--verify", replay.is_verifying, "Compare every force, volume and voxel with the recording");
  c->add_option("--until", replay.until, "Stop at this time, s")->type_name("S");
  c->add_option("-o,--output", replay.output, "Write what is left then: .mha, .nrrd, .nii or .nii.gz");
  c->add_option("--steps", replay.steps, "Write a row for every tick")->type_name("STEPS.csv");
  c->add_option("--screenshot", replay.screenshot, "Write a picture of what is left then")
      ->type_name("OUT.png");

  app::ResumeArguments resume;
  c = add("resume", "Go on with a session where it stopped",
          "  trephine resume drill.session\n  trephine resume drill.session --path path.csv", resume,
          app::run_resume);
  add_case(c, resume.session, resume.case_source);
  c->add_option("--path", resume.path, "Go on with a path instead of a window")->type_name("PATH.csv");

  app::DoctorArguments doctor;
  c = add("doctor", "Look at this machine: what is missing, and what mends it",
          "  trephine doctor\n  trephine doctor --json", doctor, app::run_doctor);
  c->add_option("-o,--output", doctor.output, "Picture of the timer's lateness (default: doctor-timer.svg)")
      ->type_name("OUT.svg");
  c->add_option("--seconds", doctor.seconds, "How long the timer is watched")->capture_default_str();

  app::SoakArguments soak;
  c = add("soak", "Drill, undo and redo live for a long time, and check memory and bits",
          "  trephine soak --seconds 60\n  trephine soak SCANS/HEAD --seconds 3600 --json", soak,
          app::run_soak);
  add_source(c, soak.source)->required(false);
  add_shape_options(c, soak.shape);
  c->add_option("--seconds", soak.seconds, "How long")->capture_default_str();
  c->add_option("--rate", soak.rate, "Servo steps a second")->capture_default_str()->type_name("HZ");
  c->add_option("--seed", soak.seed, "Of the hand's ways")->capture_default_str();
  c->add_option("--record", soak.session, "Keep the session (it is replayed and removed otherwise)")
      ->type_name("FILE");

  app::BenchArguments bench;
  c = add("bench", "Measure, beside peers in the same run",
          "  trephine bench surface\n  trephine bench step --json\n  trephine bench load SCANS/HEAD\n"
          "  trephine bench open\n  trephine bench open drill.session\n"
          "  trephine bench feel -o out/ --quick\n"
          "  trephine bench stability SCANS/HEAD --steps 100000000 -o out/",
          bench, app::run_bench);
  c->add_option("WHAT", bench.what, "surface, step, rays, load, open, feel or stability")->required();
  c->add_option(
      "SRC", bench.source,
      "A scan: for load; one more scene for feel and stability. A session: for open (none: ten minutes of "
      "drilling, recorded first)");
  c->add_option("--case", bench.case_source, "The scan of that session, where the session needs it");
  c->add_option("--size", bench.size, "Voxels along each axis (surface, step and rays)")
      ->capture_default_str();
  c->add_option("-o,--output", bench.output, "Folder for the tables and charts of feel and stability")
      ->type_name("DIR");
  c->add_option("--steps", bench.steps, "Random steps of stability, in all")->capture_default_str();
  c->add_flag("--quick", bench.is_quick,
              "Feel with smaller and fewer scenes: a minute, or two with every peer");
  c->add_option(
       "--only", bench.only,
       "Built-in scenes of feel whose name holds this, for example sphere; methods of stability likewise")
      ->type_name("TEXT");
  c->add_option("--hand", bench.hand,
                "A recorded hand for one more scene of feel: a session, or a path over SRC")
      ->type_name("FILE");
  c->add_option("--export", bench.export_folder,
                "Write each scene of feel for other programs: volume, hand, answer")
      ->type_name("DIR");
  c->add_option("--score", bench.score, "Put another program's answers to them on the chart")
      ->type_name("STEPS.csv");

  app::AuditArguments audit;
  c = add("audit", "Judge every tick of a session, or voxel traversal, by code that shares nothing with them",
          "  trephine audit drill.session --case head-case\n  trephine audit --rays 100000000", audit,
          app::run_audit);
  c->add_option("SESSION", audit.session,
                "What touch, drill or view recorded, of a method on voxels or the smooth solid; without it, "
                "traversal is judged");
  c->add_option("--case", audit.case_source,
                "The scan that was operated on, when the session does not hold it")
      ->type_name("SRC");
  c->add_option("--rays", audit.rays, "How many rays")->capture_default_str();
  c->add_option("--seed", audit.seed, "Which rays: another number, others")->capture_default_str();
  c->add_option(
       "--plant", audit.plant,
       "Show that the audit sees: one tick of the session falls through, has a force that is 0.01 N off or "
       "an energy that is, or a round tip in matter, before it is judged: fall, force, torque, energy or "
       "ball")
      ->type_name("FAULT")
      ->check(CLI::IsMember({"fall", "force", "torque", "energy", "ball"}));

  for (int i = 1; i < argc; ++i) wants_json = wants_json || std::string_view(argv[i]) == "--json";
  try {
    cli.parse(argc, argv);
  } catch (const CLI::Success& e) {
    return cli.exit(e);
  } catch (const CLI::ParseError& e) {
    const std::string name = argc > 1 ? argv[1] : "";
    const auto is_known = [&cli](const std::string& n) {
      const auto all = cli.get_subcommands([](CLI::App*) { return true; });
      return std::any_of(all.begin(), all.end(), [&n](const CLI::App* a) { return a->get_name() == n; });
    };
    if (!name.empty() && !name.starts_with("-") && !is_known(name))
      return finish(name, wants_json,
                    Error{"there is no such command", "", name, "one that trephine --help lists",
                          "check the spelling"});
    return finish(
        name.starts_with("-") ? "" : name, wants_json,
        Error{e.what(), name.starts_with("-") ? "" : name, "", "",
              "see: trephine " + (name.empty() || name.starts_with("-") ? "" : name + " ") + "--help"});
  }
  app::listen_for_interrupt();
  try {
    return finish(chosen, wants_json, run());
  } catch (const std::bad_alloc&) {
    return finish(chosen, wants_json,
                  Error{"the memory ran out", "", "", "", "close other programs, or crop the volume",
                        volume::ErrorKind::missing_here});
  }
}
