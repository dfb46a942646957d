// The command line: finds the command, has it run, and says what came of it.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <csignal>
#include <cstdio>
#include <numeric>
#include <optional>
#include <sstream>

#include "apps/trephine/build_info.h"
#include "apps/trephine/commands.h"

namespace {

using namespace trephine::app;
using trephine::volume::Error;
using trephine::volume::Result;

/// As --help lists them.
const Command* const k_commands[] = {
    &k_phantom, &k_info,        &k_import, &k_convert, &k_mesh,   &k_touch,   &k_drill,
    &k_flap,    &k_laminectomy, &k_fluoro, &k_section, &k_slice,  &k_measure, &k_depth_record,
    &k_render,  &k_view,        &k_demo,   &k_run,     &k_replay, &k_resume,  &k_timeline,
    &k_compare, &k_modules,     &k_doctor, &k_soak,    &k_bench,  &k_audit};

/// Says the outcome or the error in the form that was asked for; its exit code.
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
  return std::fflush(stdout) == 0 ? outcome.exit_code : int{exit_missing_here};
}

/// Unexpected words: an unknown option makes what follows it one too many, and is what is
/// wrong.
std::string options_first(const std::string& words) {
  std::istringstream list(words);
  std::string options, others;
  for (std::string word; list >> word;) {
    std::string& to = word.starts_with("-") ? options : others;
    to += (to.empty() ? "" : " ") + word;
  }
  return options.empty() ? others : options;
}

/// Error of the command line, in our words.
Error unreadable(const CLI::ParseError& error, const std::string& name) {
  const std::string why = error.what(), rest = why.substr(std::min(why.size(), why.find(": ") + 2));
  const std::string help = "see: trephine " + name + " --help";
  if (dynamic_cast<const CLI::ConversionError*>(&error))
    return {"the value of an option cannot be read", name, rest,
            "a value as its help says: numbers without a unit", help};
  if (const std::size_t at = rest.find(" not in {"); at != std::string::npos && rest.ends_with("}")) {
    std::string words = rest.substr(at + 9, rest.size() - at - 10);
    for (std::size_t i = 0; (i = words.find(',', i)) != std::string::npos; i += 2) words.insert(i + 1, " ");
    return {"the option does not take this value", why.substr(0, why.find(": ")), rest.substr(0, at),
            "one of " + words, help};
  }
  if (dynamic_cast<const CLI::ExtrasError*>(&error) && !name.empty() && !name.starts_with("-"))
    return {"there is no such option, or nothing more is expected", name, options_first(rest), "", help};
  if (name.empty() || name.starts_with("-")) return {why, "", "", "", "see: trephine --help"};
  return {why, name, "", "", "see: trephine " + name + " --help"};
}

/// Letters that have to be changed, added or left out to make one word of the other (Levenshtein 1966).
std::size_t edit_distance(std::string_view a, std::string_view b) {
  std::vector<std::size_t> row(b.size() + 1);
  std::iota(row.begin(), row.end(), std::size_t{0});
  for (const char letter : a) {
    std::size_t diagonal = row[0]++;
    for (std::size_t j = 0; j < b.size(); ++j) {
      const std::size_t changed = diagonal + (letter != b[j]);
      diagonal = row[j + 1];
      row[j + 1] = std::min({changed, row[j] + 1, row[j + 1] + 1});
    }
  }
  return row.back();
}

/// Error for a word that is not a command, with the command whose name is nearest; nothing for commands.
std::optional<Error> unknown_command(const std::string& name) {
  if (name.empty() || name.starts_with("-")) return std::nullopt;
  const Command* nearest = nullptr;
  std::size_t least = 3;  // letters
  for (const Command* known : k_commands) {
    const std::string_view other = known->name;
    if (other == name) return std::nullopt;
    const bool is_beginning = other.starts_with(name) || name.starts_with(other);
    const std::size_t distance = is_beginning ? 1 : edit_distance(other, name);
    if (distance < least) nearest = known, least = distance;
  }
  return Error{"there is no such command", "", name, "one that trephine --help lists",
               nearest ? "did you mean " + std::string(nearest->name) + "?" : "see: trephine --help"};
}

}  // namespace

int main(int argc, char** argv) {
  std::signal(SIGXFSZ, SIG_IGN);  // a file that may not grow is an error like others
  CLI::App cli{"trephine: surgery on real CT and MRI volumes that you can feel"};
  cli.set_version_flag("--version", program_name());
  cli.name("trephine");
  cli.require_subcommand(1);
  cli.footer(
      "Examples:\n  trephine demo\n  trephine info SCANS/HEAD\n  trephine view SCANS/HEAD\n  trephine "
      "COMMAND --help");
  bool wants_json = false, wants_identity = false;
  struct Built {
    const Command* command;
    CLI::App* app;
    std::unique_ptr<Options> options;
    Run run;
  };
  std::vector<Built> all;
  for (const Command* command : k_commands) {
    CLI::App* app = cli.add_subcommand(command->name, command->help);
    app->add_flag("--json", wants_json, "One JSON object on stdout, errors too");
    app->add_flag("--keep-identity", wants_identity,
                  "Names of folders and files may stand in what is written; without it they do not");
    app->footer(std::string("Examples:\n") + command->examples);
    auto options = std::make_unique<Options>(*app);
    Run run = command->build(*options);
    all.push_back({command, app, std::move(options), std::move(run)});
  }

  for (int i = 1; i < argc; ++i) wants_json = wants_json || std::string_view(argv[i]) == "--json";
  const std::string name = argc > 1 ? argv[1] : "";
  if (const auto unknown = unknown_command(name)) return finish(name, wants_json, *unknown);
  try {
    cli.parse(argc, argv);
  } catch (const CLI::Success& e) {
    return cli.exit(e);
  } catch (const CLI::ParseError& e) {
    return finish(name.starts_with("-") ? "" : name, wants_json, unreadable(e, name));
  }
  const auto chosen =
      std::find_if(all.begin(), all.end(), [](const Built& one) { return one.app->parsed(); });
  listen_for_interrupt();
  if (wants_identity) {
    keep_identity();
    notice("note: names of folders and files may stand in what is written (--keep-identity)");
  }
  try {
    Result<Outcome> result = chosen->run();
    if (!result) result = chosen->options->in_words_of_options(result.error());
    if (wants_json && !wants_identity) {
      if (!result)
        result = chosen->options->without_names(result.error());
      else if (result.value().json.contains("notices"))
        for (Json& text : result.value().json["notices"])
          text = chosen->options->without_names(text.get<std::string>());
    }
    // The output is whole; the program was asked to stop all the same.
    if (result && is_interrupted() && result.value().exit_code == exit_done)
      result.value().exit_code = exit_interrupted;
    return finish(chosen->command->name, wants_json, result);
  } catch (const std::bad_alloc&) {
    return finish(chosen->command->name, wants_json,
                  Error{"the memory ran out", "", "", "", "close other programs, or crop the volume",
                        trephine::volume::ErrorKind::missing_here});
  }
}
