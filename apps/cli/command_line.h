// Program: command line of a program; finds the command, runs it, and prints its result or its error.
#pragma once

#include <span>

#include "apps/cli/commands.h"

namespace trephine::cli {

struct Program {
  const char *name, *description, *footer;
  std::span<const Command* const> commands;  ///< in the order of --help
};

/// Runs the command that the arguments name. Returns the exit code.
int run_program(const Program& program, int argc, char** argv);

}  // namespace trephine::cli
