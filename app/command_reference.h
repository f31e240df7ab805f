#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>

namespace tandem {

/// Returns how a command is called: "tandem bench frame".
std::string CalledAs(const CLI::App& command);

/// Returns the words that an option's OneOf (app/option_checks.h) allows; none for an option
/// without one.
std::vector<std::string> WordsToChooseFrom(CLI::Option& option);

struct ManPage {
  std::string name;  // "tandem-peer", of section 1
  std::string text;  // roff with the macros of man(7), in ASCII
};

/// Makes manual pages from a program's command line, with the words of its --help: one page for the
/// program and one for each subcommand, which holds that subcommand's own subcommands too. A
/// subcommand that hands all its words to another program has that program's page.
std::vector<ManPage> ManPages(CLI::App& app);

/// Makes a completion script for bash: subcommands, options, and the words that an option may have.
/// A subcommand that hands all its words to another program is completed by that program's script,
/// which lies in the same folder.
std::string BashCompletion(CLI::App& app);

/// Writes FOLDER/man1/NAME.1 for each page and FOLDER/completions/PROGRAM. Returns why that cannot
/// be, or nothing. ParseOrExplain() calls it for `--write-reference FOLDER`, which the build asks
/// for and no help names.
std::string WriteReference(CLI::App& app, const std::filesystem::path& folder);

}  // namespace tandem
