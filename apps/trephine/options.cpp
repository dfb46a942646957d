// Beside main.cpp the only file that knows CLI11.
#include "apps/trephine/options.h"

#include <CLI/CLI.hpp>
#include <algorithm>

#include "haptics/proxy/methods.h"

namespace trephine::app {

Option& Option::type(const char* name) {
  option_->type_name(name);
  return *this;
}
Option& Option::required() {
  option_->required();
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

Option Options::keep(const char* names, CLI::Option* option) {
  const std::string all(names);
  auto name = std::make_unique<Name>();
  if (const std::size_t dashes = all.find("--"); dashes != std::string::npos) {
    name->option = all.substr(dashes);
    name->means = name->option.substr(2);
    std::replace(name->means.begin(), name->means.end(), '-', ' ');
  }
  names_.push_back(std::move(name));
  return Option(option, &names_.back()->means);
}

template <class T>
Option Options::add_any(const char* names, T& value, const std::string& help) {
  return keep(names, app_->add_option(names, value, help));
}
Option Options::add(const char* names, std::string& value, const std::string& help) {
  return add_any(names, value, help);
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
  option->check(CLI::NonNegativeNumber)->type_name(type);
  return keep(names, option);
}
Option Options::add(const char* names, std::vector<std::string>& value, const std::string& help) {
  return add_any(names, value, help);
}
Option Options::add(const char* names, bool& value, const std::string& help) {
  return keep(names, app_->add_flag(names, value, help));
}

volume::Error Options::in_words_of_options(volume::Error error) const {
  const Name* best = nullptr;
  for (const auto& name : names_)
    if (!name->option.empty() && (error.where == name->means || error.where.starts_with(name->means + " ")) &&
        (best == nullptr || name->means.size() > best->means.size()))
      best = name.get();
  if (best) error.where = best->option + error.where.substr(best->means.size());
  return error;
}

Option add_source(Options& options, std::string& source) {
  return options.add(
      "SRC", source,
      "DICOM folder, case folder, .mha, .mhd, .nrrd, .nii(.gz), or head (built in; ./head is a path)");
}

void add_shape(Options& options, workbench::ShapeChoice& shape) {
  options.add("--iso", shape.iso, "Solid from this value up (CT: HU; default 300)").type("V");
  options.add("--window", shape.window, "Solid between two values; either end may be empty").type("LO:HI");
  options.add("--label", shape.label, "Solid where the volume has this label").type("NAME");
}

void add_record(Options& options, workbench::RecordChoice& record) {
  record.program = program_name();
  options.add("--record", record.file, "Write the session to this new file").type("FILE");
  options.add("--embed", record.is_embedding, "Keep the scan in the session too (large)");
}

void add_session(Options& options, std::string& session, std::string& case_source) {
  options.add("SESSION", session, "A recorded session").required();
  options.add("--case", case_source, "The case or scan that was operated on").type("SRC");
}

Option add_path(Options& options, std::string& path) {
  return options
      .add("--path", path,
           "CSV with t,x,y,z[,qx,qy,qz,qw][,button]: seconds; mm with x to the patient's left, y to the "
           "back, z up (LPS); pressed throughout without a button")
      .type("PATH.csv");
}

Option add_rate(Options& options, double& rate) {
  return options.add("--rate", rate, "Servo steps a second, 10 to 100000").shows_default().type("HZ");
}

Option add_method(Options& options, std::string& method) {
  return options.add("--method", method, "How the proxy is kept on the surface: " + haptics::method_names())
      .shows_default();
}

void add_round(Options& options, bool& is_round) {
  options
      .add("--round", is_round,
           "The bone is touched with the burr's ball, whose middle the hand holds, instead of its lowest "
           "point; a voxel or a twelfth smaller than it cuts, so that it has room in its own hole; to 12 mm")
      .means("tool radius");
}

}  // namespace trephine::app
