// Options: options of one command, independent of the library that parses them.
#pragma once

#include <cstdint>
#include <functional>
#include <glm/vec3.hpp>
#include <initializer_list>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "apps/cli/report.h"
#include "apps/workbench/devices.h"
#include "apps/workbench/moment.h"

namespace CLI {
class App;
class Option;
}  // namespace CLI

namespace trephine::cli {

/// Handle to one option, to set its properties.
class Option {
 public:
  Option(CLI::Option* option, std::string* means, std::string* remedy)
      : option_(option), means_(means), remedy_(remedy) {}
  Option& type(const char* name);  ///< placeholder of the value in --help: "MM"
  Option& required();
  Option& shows_default();  ///< the initial value is shown in --help
  Option& one_of(std::vector<std::string> words);
  /// Sets the name that errors of libraries use for this value, so that the option's name can replace it. By
  /// default the option without dashes: "smallest burr" for --smallest-burr.
  Option& means(const char* input);
  /// Sets the remedy of errors that name this value, in place of that of the library.
  Option& remedy(const char* text);
  /// Lets an option with a list take only one value per occurrence on the command line.
  Option& one_at_a_time();

 private:
  CLI::Option* option_;
  std::string *means_, *remedy_;
};

/// Message of the parser about a text option without a text.
inline constexpr const char* k_empty_value = "the text is empty";

class Options {
 public:
  explicit Options(CLI::App& app) : app_(&app) {}

  /// Adds an option: "--radius", "-o,--output", or "SRC" for a positional argument. A bool becomes a flag.
  Option add(const char* names, std::string& value, const std::string& help);
  Option add(const char* names, double& value, const std::string& help);
  Option add(const char* names, std::optional<double>& value, const std::string& help);
  Option add(const char* names, int& value, const std::string& help);
  Option add(const char* names, std::int64_t& value, const std::string& help);
  Option add(const char* names, std::uint64_t& value, const std::string& help);
  Option add(const char* names, std::vector<std::string>& value, const std::string& help);
  Option add(const char* names, bool& value, const std::string& help);
  /// Adds a choice of words; `value` is the index of the word, and its initial value the default in --help.
  Option add(const char* names, std::uint8_t& value, std::span<const std::string_view> words,
             const std::string& help);

  /// Hides from --help all options that are added until end_reference(). end_reference() adds a line to
  /// --help with their names, which refers to the help of `command` for their descriptions.
  void begin_reference();
  void end_reference(const std::string& title, const std::string& command);
  /// Adds --module, for commands that use the catalogue of modules.
  void add_modules();
  /// Loads the modules of the command line. Call before the command runs.
  Status load_modules() const;
  /// Returns the name of the command.
  std::string command_name() const;

  /// If the error's location begins with a library's name for the value of an option, replaces this name by
  /// that of the option. Also sets the option's remedy, if it has one.
  Error with_option_names(Error error) const;
  /// Replaces names of files and folders in the error. A name on the command line becomes the name of its
  /// option. The name of a file in such a folder, or of another file that was read, becomes "a file of SRC"
  /// or "a file in it".
  Error without_names(Error error) const;
  std::string without_names(std::string text) const;

 private:
  /// Returns the names that without_names() replaces, longest first, each with its replacement.
  std::vector<std::pair<std::string, std::string>> names_given() const;
  template <class T>
  Option add_any(const char* names, T& value, const std::string& help);
  Option keep(const char* names, CLI::Option* option, std::function<std::vector<std::string>()> texts = {});

  CLI::App* app_;
  struct Name {
    std::string option, means, remedy;
    std::string shown;  ///< the option's last name, which replaces file names in errors
    std::function<std::vector<std::string>()> texts;  ///< values on the command line
  };
  std::vector<std::unique_ptr<Name>> names_;
  std::optional<std::size_t> first_hidden_;  ///< index in names_
  std::vector<std::string> modules_;         ///< paths
};

// Common options of several commands.
Option add_source(Options& options, workbench::SourceChoice& source);
void add_shape(Options& options, workbench::ShapeChoice& shape);
/// Adds --effect, which may be repeated.
void add_effects(Options& options, std::vector<std::string>& effects);
void add_record(Options& options, workbench::RecordChoice& record);
/// Adds a device, a pedal and the scale of the device.
void add_devices(Options& options, workbench::DeviceChoice& devices);
/// Adds a scan, or a session and a time.
void add_moment(Options& options, workbench::MomentChoice& moment);
/// Returns an error unless the option's value is from low to high.
Status check_range(double value, double low, double high, const char* option);

/// Additional models and screws, as written on the command line.
struct ObjectArguments {
  std::vector<std::string> models, screws;
  double scale = 1;         ///< mm per unit of the models
  std::string frame;        ///< "LPS" or "RAS"; empty: as the files state
  std::uint8_t matter = 0;  ///< index of k_model_matters
};
/// Matters that a model of a file may consist of.
inline constexpr std::string_view k_model_matters[] = {"titanium", "steel", "soft-tissue", "bone"};
volume::Matter matter_of_model(std::uint8_t index) noexcept;
/// Adds --mesh-matter.
void add_matter(Options& options, std::uint8_t& matter);
void add_objects(Options& options, ObjectArguments& objects);
/// Registers the files of the moment and of the models as inputs, which no output may overwrite.
void add_inputs(data_tools::OutputSet& outputs, const workbench::MomentChoice& moment,
                const ObjectArguments& objects = {});
/// Opens the moment with the models and screws in it.
Result<std::unique_ptr<workbench::Moment>> open_with(workbench::MomentChoice moment,
                                                     const ObjectArguments& objects);
/// Adds a session, and the scan that it may require.
void add_session(Options& options, std::string& session, workbench::SourceChoice& case_source);
/// Adds --from, the side of the camera.
void add_side(Options& options, std::string& side);
/// Returns the letter of a side of --from (A, P, L, R, S or I); 0 if there is no such side.
char side_of(const std::string& side);
/// Parses "X,Y,Z", in mm.
Result<glm::dvec3> parse_point(const std::string& text, const char* option);
Option add_path(Options& options, std::string& path);
Option add_rate(Options& options, double& rate);
Option add_method(Options& options, std::string& method);

}  // namespace trephine::cli
