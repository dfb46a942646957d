// Options on top of CLI11. Only this file and command_line.cpp include CLI11.
#include "apps/cli/options/options.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cctype>
#include <cerrno>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>

#include "data-tools/files/atomic_file.h"
#include "data-tools/files/sensitive_names.h"
#include "haptics/force/effects.h"
#include "haptics/methods/methods.h"
#include "modules/catalogue.h"

namespace trephine::cli {

Option& Option::type(const char* name) {
  option_->type_name(name);
  return *this;
}
Option& Option::required() {
  const std::string type = option_->get_type_name();
  option_->required()
      ->check([](const std::string& value) { return value.empty() ? std::string("the value is empty") : ""; })
      ->type_name(type);
  return *this;
}
Option& Option::shows_default() {
  option_->capture_default_str();
  return *this;
}
Option& Option::one_of(std::vector<std::string> words) {
  option_->check(CLI::IsMember(std::move(words)));
  return *this;
}
Option& Option::means(const char* input) {
  *means_ = input;
  return *this;
}
Option& Option::remedy(const char* text) {
  *remedy_ = text;
  return *this;
}
Option& Option::one_at_a_time() {
  option_->allow_extra_args(false);
  return *this;
}

Option Options::keep(const char* names, CLI::Option* option,
                     std::function<std::vector<std::string>()> texts) {
  const std::string list(names);
  auto name = std::make_unique<Name>();
  name->shown = list.substr(list.rfind(',') + 1);
  name->texts = std::move(texts);
  if (const std::size_t dashes = list.find("--"); dashes != std::string::npos) {
    name->option = list.substr(dashes);
    name->means = name->option.substr(2);
    std::replace(name->means.begin(), name->means.end(), '-', ' ');
  }
  if (first_hidden_) option->group("");
  names_.push_back(std::move(name));
  return Option(option, &names_.back()->means, &names_.back()->remedy);
}

void Options::begin_reference() { first_hidden_ = names_.size(); }
void Options::end_reference(const std::string& title, const std::string& command) {
  std::string text = title + " (described by: " + "trephine " + command + " --help):\n ";
  for (std::size_t i = *first_hidden_; i < names_.size(); ++i) text += " " + names_[i]->option;
  first_hidden_.reset();
  app_->footer(text + "\n\n" + app_->get_footer());
}
void Options::add_modules() {
  add("--module", modules_, "A module to load, as a shared library; may be repeated")
      .type("PATH")
      .one_at_a_time()
      .remedy("load it with --module PATH");
}
Status Options::load_modules() const {
  for (const std::string& path : modules_)
    if (const auto loaded = modules::load_module(path); !loaded) return loaded.error();
  return std::nullopt;
}
std::string Options::command_name() const { return app_->get_name(); }

template <class T>
Option Options::add_any(const char* names, T& value, const std::string& help) {
  return keep(names, app_->add_option(names, value, help));
}
Option Options::add(const char* names, std::string& value, const std::string& help) {
  CLI::Option* option = app_->add_option(names, value, help);
  // An empty text usually comes from an unset variable of a shell.
  option->check(CLI::Validator(
      [](const std::string& text) { return text.empty() ? std::string(k_empty_value) : std::string(); }, ""));
  return keep(names, option, [&value] { return std::vector{value}; });
}
Option Options::add(const char* names, double& value, const std::string& help) {
  return add_any(names, value, help);
}
Option Options::add(const char* names, std::optional<double>& value, const std::string& help) {
  return add_any(names, value, help);
}
Option Options::add(const char* names, int& value, const std::string& help) {
  return add_any(names, value, help);
}
Option Options::add(const char* names, std::int64_t& value, const std::string& help) {
  return add_any(names, value, help);
}
Option Options::add(const char* names, std::uint64_t& value, const std::string& help) {
  CLI::Option* option = app_->add_option(names, value, help);
  const std::string type = option->get_type_name();
  const auto check_whole = [](const std::string& text) -> std::string {  // returns "" or the error
    errno = 0;
    std::strtoull(text.c_str(), nullptr, 10);
    const bool is_number = !text.empty() && text.find_first_not_of("0123456789") == std::string::npos;
    return is_number && errno != ERANGE ? "" : text + " is not a whole number from 0 to 18446744073709551615";
  };
  option->check(check_whole)->type_name(type);
  return keep(names, option);
}
Option Options::add(const char* names, std::vector<std::string>& value, const std::string& help) {
  return keep(names, app_->add_option(names, value, help), [&value] { return value; });
}
Option Options::add(const char* names, bool& value, const std::string& help) {
  return keep(names, app_->add_flag(names, value, help));
}

Option Options::add(const char* names, std::uint8_t& value, std::span<const std::string_view> words,
                    const std::string& help) {
  const std::vector<std::string> choices(words.begin(), words.end());
  const auto choose = [&value, choices](const std::string& word) {
    const auto found = std::find(choices.begin(), choices.end(), word);
    if (found == choices.end()) return false;
    value = static_cast<std::uint8_t>(found - choices.begin());
    return true;
  };
  CLI::Option* option = app_->add_option_function<std::string>(names, choose, help);
  option->check(CLI::IsMember(choices))->type_name("WORD")->default_str(choices.at(value));
  return keep(names, option);
}

Error Options::with_option_names(Error error) const {
  const Name* best = nullptr;
  for (const auto& name : names_)
    if (!name->option.empty() && (error.where == name->means || error.where.starts_with(name->means + " ")) &&
        (best == nullptr || name->means.size() > best->means.size()))
      best = name.get();
  if (best) error.where = best->option + error.where.substr(best->means.size());
  if (best && !best->remedy.empty()) error.remedy = best->remedy;
  return error;
}

namespace {

/// Replaces every `name` in the text that is not part of a longer word.
void replace_name(std::string& text, const std::string& name, const std::string& replacement) {
  const auto is_part = [&text](std::size_t i) {
    return i < text.size() && (std::isalnum(static_cast<unsigned char>(text[i])) || text[i] == '_');
  };
  for (std::size_t at = 0; (at = text.find(name, at)) != std::string::npos;) {
    if ((at > 0 && is_part(at - 1)) || is_part(at + name.size())) {
      ++at;
      continue;
    }
    text.replace(at, name.size(), replacement);
    at += replacement.size();
  }
}

}  // namespace

namespace {

/// True for options whose value always counts as the name of a file or folder. Values of other options count
/// only if they exist or contain "/" or ".".
bool is_file_option(const std::string& name) {
  for (const char* option : {"SRC", "SESSION", "SCRIPT", "--output", "--scan", "--case", "--path", "--record",
                             "--labels", "--write-labels", "--mesh", "--depth", "--screenshot", "--results",
                             "--export", "--hand", "--pictures", "--module"})
    if (name == option) return true;
  return false;
}

}  // namespace

std::vector<std::pair<std::string, std::string>> Options::names_given() const {
  namespace fs = std::filesystem;
  std::vector<std::pair<std::string, std::string>> names;
  const auto add_name = [&names](const fs::path& path, const std::string& replacement) {
    if (const std::string name = data_tools::file_name(path.string()); name != "." && name != "..")
      names.emplace_back(name, replacement);
  };
  for (const auto& option : names_) {
    if (!option->texts) continue;
    for (const std::string& text : option->texts()) {
      std::error_code failed;
      if (text.empty() || (!is_file_option(option->shown) && !fs::exists(text, failed) &&
                           text.find_first_of("/.") == std::string::npos))
        continue;
      add_name(text, option->shown);
      if (const std::size_t colon = text.find(':'); colon != std::string::npos)  // playback:FILE
        add_name(text.substr(colon + 1), option->shown);
      int count = 0;
      for (fs::recursive_directory_iterator it(text, failed), end; !failed && it != end && ++count < 100'000;
           it.increment(failed))
        add_name(it->path(), "a file of " + option->shown);
    }
  }
  for (const std::string& name : data_tools::sensitive_names()) add_name(name, "a file in the input");
  // Longest first: a name may be a part of a longer name.
  std::stable_sort(names.begin(), names.end(),
                   [](const auto& a, const auto& b) { return a.first.size() > b.first.size(); });
  return names;
}

std::string Options::without_names(std::string text) const {
  for (const auto& [name, replacement] : names_given()) replace_name(text, name, replacement);
  return text;
}

Error Options::without_names(Error error) const {
  // The name of a folder may be a short common word that also occurs in our own sentences (problem, expected
  // input, remedy). Names of fewer than 5 lower-case letters are therefore not replaced in these sentences.
  constexpr std::size_t k_own_word = 5;
  for (const auto& [name, replacement] : names_given()) {
    for (std::string* text : {&error.where, &error.found}) replace_name(*text, name, replacement);
    const bool is_plain =
        name.size() < k_own_word && name.find_first_not_of("abcdefghijklmnopqrstuvwxyz") == std::string::npos;
    for (std::string* text : {&error.what, &error.expected, &error.remedy})
      if (!is_plain) replace_name(*text, name, replacement);
  }
  return error;
}

/// Adds the options for reading a scan. The help of `info` describes them; the help of other commands refers
/// to that of `info`.
void add_reading(Options& options, workbench::SourceChoice& source) {
  const bool is_described = options.command_name() == "info";
  if (!is_described) options.begin_reference();
  options.add("--series", source.series, "Number of the series, as listed by info (default: the best CT)")
      .type("N");
  options
      .add("--volume", source.volume,
           "Number of the volume, if a series or file has several: echoes, phases, 4-D")
      .type("N");
  options.add("--resample", source.is_resampled, "Interpolate slices that are missing or uneven");
  options.add("--padding-to-air", source.maps_padding, "Replace the scanner's padding value by air (CT)");
  options.add("--hounsfield", source.is_hounsfield,
              "Read the values as Hounsfield units, if the file does not state its unit");
  options.add("--spacing", source.spacing, "Size of a voxel, mm, if the file does not state it")
      .type("X,Y,Z");
  options
      .add("--axes", source.axes,
           "Directions of x, y and z: left or right, posterior or anterior, superior or inferior "
           "(default: LPS)")
      .type("LPS");
  options.add("--raw", source.raw, "The file is numbers without a header: uint8, int16, float, ...")
      .type("X,Y,Z,TYPE[,big][,skip=N]");
  options.add("--sform", source.takes_sform, "Use the sform of a NIfTI whose sform and qform disagree");
  options.add("--qform", source.takes_qform, "Use the qform of a NIfTI whose sform and qform disagree");
  options
      .add("--scale", source.scale,
           "Step of the stored values, in the file's units, for values that need more than 16 bits")
      .type("STEP");
  if (!is_described) options.end_reference("Scan options", "info");
}

Option add_source(Options& options, workbench::SourceChoice& source) {
  const Option option = options.add("SRC", source.path,
                                    "DICOM folder or archive, case folder, .mha, .mhd, .nrrd, .nhdr, "
                                    ".nii(.gz), .hdr, .vti, .vdb, .inv3, a folder of pictures, or head or "
                                    "spine (built in; ./head is a path)");
  add_reading(options, source);
  return option;
}

void add_shape(Options& options, workbench::ShapeChoice& shape) {
  options.add("--iso", shape.iso, "Solid from this value upwards (CT: HU; default 300, spines 150; MR: none)")
      .type("V");
  options.add("--range", shape.window, "Solid between two values; either end may be empty").type("LO:HI");
  options.add("--auto", shape.is_auto, "Solid from the threshold that separates the histogram best (MR)");
  options.add("--largest", shape.is_largest, "Largest connected part only: no table, no head holder");
  options.add("--label", shape.label, "Solid where the volume has this label").type("NAME");
}

void add_effects(Options& options, std::vector<std::string>& effects) {
  options
      .add("--effect", effects,
           "A force in addition to the surface's: a name of " + haptics::effect_names() +
               " and its parameters in quotes; may be repeated")
      .type("WORDS");
}

void add_record(Options& options, workbench::RecordChoice& record) {
  record.program = program_name();
  options.add("--record", record.file, "Write the session to this new file").type("FILE");
  options.add("--embed", record.is_embedding, "Write the scan to the session as well (large)");
}

void add_session(Options& options, std::string& session, workbench::SourceChoice& case_source) {
  options.add("SESSION", session, "A recorded session").required();
  options.add("--scan", case_source.path, "Case or scan that was operated on").type("SRC");
  options.add_modules();
  add_reading(options, case_source);
}

void add_devices(Options& options, workbench::DeviceChoice& devices) {
  options
      .add(
          "--device", devices.device,
          "Source of the hand's motion: mouse, falcon, touch, omega, inverse3, spacemouse (spacemouse:1 is the "
          "second one), remote (that of trephine virtual-device), playback:PATH.csv (follows the path exactly), or virtual:PATH.csv (a simulated hand "
          "that follows the path with a spring and yields to forces); default: that of "
          "~/.config/trephine/devices.toml, else mouse")
      .type("NAME");
  options
      .add("--left", devices.left,
           "Second hand, moved by this device (not the mouse), with an instrument of its own")
      .type("NAME");
  options
      .add("--pedal", devices.pedal,
           "Foot pedal whose buttons are added: pedal, pedal:1, or pedal:/dev/input/event5")
      .type("NAME");
  options.add("--device-scale", devices.scale, "Motion of the tool per motion of the device, 0.1 to 10")
      .shows_default();
}

void add_moment(Options& options, workbench::MomentChoice& moment) {
  options.add("SRC", moment.source.path, "A scan, or a recorded session; head and spine are built in")
      .required();
  options.add("--scan", moment.case_source, "Case or scan that a session operated on").type("SRC");
  options.add("--until", moment.until, "State of the session at this time, s").type("S");
  options.add_modules();
  add_reading(options, moment.source);
}

Status check_range(double value, double low, double high, const char* option) {
  if (value >= low && value <= high) return std::nullopt;
  return Error{.what = "the value is out of range",
               .where = option,
               .found = format_text("%g", value),
               .expected = format_text("%g to %g", low, high)};
}

volume::Matter matter_of_model(std::uint8_t index) noexcept {
  constexpr volume::Matter k_matters[] = {volume::Matter::titanium, volume::Matter::steel,
                                          volume::Matter::soft_tissue, volume::Matter::bone};
  return k_matters[index % std::size(k_matters)];
}

void add_matter(Options& options, std::uint8_t& matter) {
  options.add("--mesh-matter", matter, k_model_matters, "Matter of the models, for X-rays and sections");
}

void add_objects(Options& options, ObjectArguments& objects) {
  options.add("--mesh", objects.models, "A closed model to add").type("FILE");
  options.add("--mesh-scale", objects.scale, "Scale of the models: 1000 for metres")
      .shows_default()
      .type("MM");
  options
      .add("--mesh-frame", objects.frame,
           "Directions of the models' axes (default: as the file states, else LPS)")
      .one_of({"LPS", "RAS"});
  add_matter(options, objects.matter);
  options.add("--screw", objects.screws, "A screw to add: entry, tip and diameter, mm (LPS)")
      .type("X,Y,Z:X,Y,Z:D");
}

void add_inputs(data_tools::OutputSet& outputs, const workbench::MomentChoice& moment,
                const ObjectArguments& objects) {
  for (const std::string& input : {moment.source.path, moment.case_source}) outputs.add_input(input);
  for (const std::string& model : objects.models) outputs.add_input(model);
}

Result<std::unique_ptr<workbench::Moment>> open_with(workbench::MomentChoice moment,
                                                     const ObjectArguments& objects) {
  for (const std::string& file : objects.models)
    moment.models.push_back(
        {file, objects.scale, objects.frame, glm::dvec3(0.0), matter_of_model(objects.matter)});
  for (const std::string& text : objects.screws) {
    const auto screw = data_tools::parse_screw(text);
    if (!screw) return screw.error();
    workbench::ModelChoice& model = moment.models.emplace_back();
    model.screw = screw.value();
  }
  return workbench::open_moment(moment, terminal_listener());
}

void add_side(Options& options, std::string& side) {
  options.add("--from", side, "Side of the camera")
      .one_of({"front", "back", "left", "right", "top", "bottom"});
}

char side_of(const std::string& side) {
  const std::pair<const char*, char> sides[] = {{"front", 'A'}, {"back", 'P'}, {"left", 'L'},
                                                {"right", 'R'}, {"top", 'S'},  {"bottom", 'I'}};
  for (const auto& [name, letter] : sides)
    if (side == name) return letter;
  return 0;
}

Result<glm::dvec3> parse_point(const std::string& text, const char* option) {
  glm::dvec3 at(0);
  char extra = 0;
  if (std::sscanf(text.c_str(), "%lf,%lf,%lf%c", &at.x, &at.y, &at.z, &extra) == 3 &&
      std::max({std::abs(at.x), std::abs(at.y), std::abs(at.z)}) <= 1e6)
    return at;
  return Error{.what = "the position is invalid",
               .where = option,
               .found = text,
               .expected = "X,Y,Z in mm, each at most 1e6, for example 0,-90,20"};
}

Option add_path(Options& options, std::string& path) {
  return options
      .add(
          "--path", path,
          "Motion: a recorded session, or CSV with t,x,y,z[,qx,qy,qz,qw][,button]: seconds; mm with x to the patient's left, y to the "
          "back, z up (LPS); without a button column the button is pressed throughout")
      .type("PATH.csv");
}

Option add_rate(Options& options, double& rate) {
  return options.add("--rate", rate, "Servo steps per second, 10 to 100000").shows_default().type("HZ");
}

Option add_method(Options& options, std::string& method) {
  return options
      .add("--method", method,
           "Contact method: " + haptics::user_method_names() +
               " (chain: tools of several balls, shell: whole tools); baselines: docs/accuracy.md")
      .shows_default();
}

}  // namespace trephine::cli
