#include "apps/cli/command_line.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <csignal>
#include <cstdio>
#include <optional>
#include <sstream>

#include "apps/cli/commands.h"
#include "volume/base/edit_distance.h"

namespace trephine::cli {
namespace {

/// Prints the outcome or the error as text or JSON, and returns the exit code.
int finish(const std::string& name, bool wants_json, const Result<Outcome>& result) {
  if (!result) {
    if (wants_json)
      std::printf("%s\n", text_of_json(error_report(name, result.error())).c_str());
    else {
      Error error = result.error();
      for (std::string* text : {&error.where, &error.found}) *text = for_terminal(*text, true);
      std::fprintf(stderr, "error: %s\n", for_terminal(error.message()).c_str());
    }
    return exit_code_of(result.error());
  }
  const Outcome& outcome = result.value();
  std::fputs(wants_json ? (text_of_json(outcome.json) + "\n").c_str() : for_terminal(outcome.text).c_str(),
             stdout);
  // Text that is longer than the buffer is written before fflush(); ferror() reports its errors.
  const bool is_written = std::fflush(stdout) == 0 && std::ferror(stdout) == 0;
  if (is_written) return outcome.exit_code;
  std::fputs("error: the output cannot be written\n", stderr);
  return exit_missing_here;
}

/// Returns the options in a list of unexpected words, or all words if the list has no options. The value of
/// an unknown option is an unexpected word as well.
std::string unknown_options(const std::string& words) {
  std::istringstream list(words);
  std::string options, others;
  for (std::string word; list >> word;) {
    std::string& to = word.starts_with("-") ? options : others;
    to += (to.empty() ? "" : " ") + word;
  }
  return options.empty() ? others : options;
}

/// Converts an error of the command line parser to an Error.
Error to_error(const CLI::ParseError& error, const std::string& program, const std::string& name) {
  const std::string message = error.what(),
                    rest = message.substr(std::min(message.size(), message.find(": ") + 2));
  const std::string help = "see: " + program + " " + name + " --help";
  if (dynamic_cast<const CLI::ConversionError*>(&error))
    return Error{.what = "invalid value of an option",
                 .where = name,
                 .found = rest,
                 .expected = "a value as described in the help; numbers without a unit",
                 .remedy = help};
  if (rest == k_empty_value)
    return Error{.what = "the value of an option is empty",
                 .where = message.substr(0, message.find(": ")),
                 .expected = "a text",
                 .remedy = "omit the option, or give it a value"};
  if (const std::size_t at = rest.find(" not in {"); at != std::string::npos && rest.ends_with("}")) {
    std::string words = rest.substr(at + 9, rest.size() - at - 10);
    for (std::size_t i = 0; (i = words.find(',', i)) != std::string::npos; i += 2) words.insert(i + 1, " ");
    return Error{.what = "invalid value of an option",
                 .where = message.substr(0, message.find(": ")),
                 .found = rest.substr(0, at),
                 .expected = "one of " + words,
                 .remedy = help};
  }
  if (dynamic_cast<const CLI::ExtrasError*>(&error) && !name.empty() && !name.starts_with("-"))
    return Error{.what = "unknown option or unexpected argument",
                 .where = name,
                 .found = unknown_options(rest),
                 .remedy = help};
  if (name.empty() || name.starts_with("-")) return {message, "", "", "", "see: " + program + " --help"};
  return {message, name, "", "", "see: " + program + " " + name + " --help"};
}

/// Returns the error for a word that is not a command; it suggests the command with the most similar name.
/// Returns nullopt for a command, an option or an empty word.
std::optional<Error> unknown_command(const Program& program, const std::string& name) {
  if (name.empty() || name.starts_with("-")) return std::nullopt;
  const Command* nearest = nullptr;
  std::size_t least = 3;  // edits; less similar names are not suggested
  for (const Command* known : program.commands) {
    const std::string_view other = known->name;
    if (other == name) return std::nullopt;
    const bool is_beginning = other.starts_with(name) || name.starts_with(other);
    const std::size_t distance = is_beginning ? 1 : edit_distance(other, name);
    if (distance < least) nearest = known, least = distance;
  }
  return Error{.what = "unknown command",
               .found = name,
               .expected = "a command that " + std::string(program.name) + " --help lists",
               .remedy = nearest ? "did you mean " + std::string(nearest->name) + "?"
                                 : "see: " + std::string(program.name) + " --help"};
}

}  // namespace

int run_program(const Program& program, int argc, char** argv) {
  std::signal(SIGXFSZ, SIG_IGN);  // a file over the size limit is reported as a write error
  CLI::App app_line{program.description};
  app_line.set_version_flag("--version", program_name());
  app_line.name(program.name);
  app_line.require_subcommand(1);
  app_line.footer(program.footer);
  bool wants_json = false, wants_identity = false;
  struct Built {
    const Command* command;
    CLI::App* app;
    std::unique_ptr<Options> options;
    Run run;
  };
  std::vector<Built> commands;
  for (const Command* command : program.commands) {
    CLI::App* app = app_line.add_subcommand(command->name, command->help);
    app->add_flag("--json", wants_json, "One JSON object on stdout, errors too");
    app->add_flag("--keep-identity", wants_identity,
                  "Write the names of folders and files to reports and files (default: omitted)");
    app->footer(std::string("Examples:\n") + command->examples);
    auto options = std::make_unique<Options>(*app);
    Run run = command->build(*options);
    commands.push_back({command, app, std::move(options), std::move(run)});
  }

  for (int i = 1; i < argc; ++i) wants_json = wants_json || std::string_view(argv[i]) == "--json";
  const std::string name = argc > 1 ? argv[1] : "";
  if (const auto unknown = unknown_command(program, name)) return finish(name, wants_json, *unknown);
  try {
    app_line.parse(argc, argv);
  } catch (const CLI::Success& e) {
    return app_line.exit(e);
  } catch (const CLI::ParseError& e) {
    return finish(name.starts_with("-") ? "" : name, wants_json, to_error(e, program.name, name));
  }
  const auto chosen =
      std::find_if(commands.begin(), commands.end(), [](const Built& built) { return built.app->parsed(); });
  listen_for_interrupt();
  if (wants_identity) {
    keep_identity();
    notice("note: reports and files may contain the names of folders and files (--keep-identity)");
  }
  try {
    const Status not_loaded = chosen->options->load_modules();
    Result<Outcome> result = not_loaded ? Result<Outcome>(*not_loaded) : chosen->run();
    if (!result) {
      Error error = chosen->options->with_option_names(result.error());
      for (std::string* text : {&error.what, &error.found, &error.expected, &error.remedy})
        *text = with_dashes(*text);
      result = std::move(error);
    } else if (result.value().json.contains("notices")) {
      for (Json& text : result.value().json["notices"]) text = with_dashes(text.get<std::string>());
    }
    if (wants_json && !wants_identity) {
      if (!result)
        result = chosen->options->without_names(result.error());
      else if (result.value().json.contains("notices"))
        for (Json& text : result.value().json["notices"])
          text = chosen->options->without_names(text.get<std::string>());
    }
    // The output is complete, but the program was interrupted.
    if (result && is_interrupted() && result.value().exit_code == exit_done)
      result.value().exit_code = exit_interrupted;
    return finish(chosen->command->name, wants_json, result);
  } catch (const std::bad_alloc&) {
    return finish(chosen->command->name, wants_json,
                  Error{.what = "out of memory",
                        .remedy = "close other programs, or crop the volume",
                        .kind = ErrorKind::missing_here});
  }
}

}  // namespace trephine::cli
