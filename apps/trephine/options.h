// The options of one command, without the library that parses them.
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

#include "apps/trephine/report.h"
#include "apps/workbench/moment.h"

namespace CLI {
class App;
class Option;
}  // namespace CLI

namespace trephine::app {

/// One option, to say more about it.
class Option {
 public:
  explicit Option(CLI::Option* option, std::string* means) : option_(option), means_(means) {}
  Option& type(const char* name);  ///< as --help shows its value: "MM"
  Option& required();
  Option& shows_default();
  Option& one_of(std::vector<std::string> words);
  /// Name in errors of libraries; else the option's own name without dashes: "smallest burr" for
  /// --smallest-burr.
  Option& means(const char* input);

 private:
  CLI::Option* option_;
  std::string* means_;
};

class Options {
 public:
  explicit Options(CLI::App& app) : app_(&app) {}

  /// "--radius", "-o,--output", or "SRC" for what stands without a name. Of bool: a flag.
  Option add(const char* names, std::string& value, const std::string& help);
  Option add(const char* names, double& value, const std::string& help);
  Option add(const char* names, std::optional<double>& value, const std::string& help);
  Option add(const char* names, int& value, const std::string& help);
  Option add(const char* names, std::int64_t& value, const std::string& help);
  Option add(const char* names, std::uint64_t& value, const std::string& help);
  Option add(const char* names, std::vector<std::string>& value, const std::string& help);
  Option add(const char* names, bool& value, const std::string& help);
  /// One of those words, by its number; that which `value` is shows as the default.
  Option add(const char* names, std::uint8_t& value, std::span<const std::string_view> words,
             const std::string& help);

  /// The error as a person at the command line knows it: by options.
  volume::Error in_words_of_options(volume::Error error) const;
  /// The error without the names of files and folders that were given, or of files in those folders: the
  /// option stands for them.
  volume::Error without_names(volume::Error error) const;
  std::string without_names(std::string text) const;

 private:
  /// Such names, the longest first, and what stands for each.
  std::vector<std::pair<std::string, std::string>> names_given() const;
  template <class T>
  Option add_any(const char* names, T& value, const std::string& help);
  Option keep(const char* names, CLI::Option* option, std::function<std::vector<std::string>()> texts = {});

  CLI::App* app_;
  struct Name {
    std::string option, means, shown;
    std::function<std::vector<std::string>()> texts;  ///< that were given to it
  };
  std::vector<std::unique_ptr<Name>> names_;
};

// Common options of several commands.
Option add_source(Options& options, workbench::SourceChoice& source);
void add_shape(Options& options, workbench::ShapeChoice& shape);
void add_record(Options& options, workbench::RecordChoice& record);
/// A scan, or a session and when.
void add_moment(Options& options, workbench::MomentChoice& moment);
/// Error: the option's value is no number from low to high.
volume::Status check_range(double value, double low, double high, const char* option);

/// Models and screws in addition, as they were written.
struct ThingArguments {
  std::vector<std::string> models, screws;
  double scale = 1;   ///< mm a unit of the models
  std::string frame;  ///< "LPS" or "RAS"; empty: as the files say
};
void add_things(Options& options, ThingArguments& things);
/// Sources of both.
void reads(data_tools::OutputSet& outputs, const workbench::MomentChoice& moment,
           const ThingArguments& things = {});
/// The moment with the things in it.
volume::Result<std::unique_ptr<workbench::Moment>> open_with(workbench::MomentChoice moment,
                                                             const ThingArguments& things);
void add_session(Options& options, std::string& session, workbench::SourceChoice& case_source);
/// A side to look from; side_of() is what a view calls it.
void add_side(Options& options, std::string& side);
char side_of(const std::string& side);
/// "X,Y,Z", mm.
volume::Result<glm::dvec3> parse_place(const std::string& text, const char* option);
Option add_path(Options& options, std::string& path);
Option add_rate(Options& options, double& rate);
Option add_method(Options& options, std::string& method);

}  // namespace trephine::app
