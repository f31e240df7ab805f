#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>

namespace tandem {

/// Returns how a command is called: "tandem bench frame".
std::string CalledAs(const CLI::App& command);

/// Returns the words that an option's OneOf (app/common/option_checks.h) allows. An option without
/// a OneOf has none.
std::vector<std::string> WordsToChooseFrom(CLI::Option& option);

struct ManPage {
  std::string name;  // for example "tandem-peer", in section 1
  std::string text;  // roff with the macros of man(7), in ASCII
};

/// Makes manual pages from a program's command line, with the words of its --help. The program and
/// each subcommand have a page, which also describes the subcommands below it. A subcommand that
/// hands all its words to another program has that program's page.
std::vector<ManPage> ManPages(CLI::App& app);

/// Makes a completion script for bash: subcommands, options, and the words that an option may have.
/// A subcommand that hands all its words to another program is completed by that program's script,
/// which lies in the same folder.
std::string BashCompletion(CLI::App& app);

/// Writes FOLDER/man1/NAME.1 for each page and FOLDER/completions/PROGRAM. Returns the fault;
/// empty: none. ParseOrExplain() calls it for `--write-reference FOLDER`. The build uses this
/// option; --help does not show it.
std::string WriteReference(CLI::App& app, const std::filesystem::path& folder);

/// Writes these pages, and the completion of a program, in the same way.
std::string WriteReference(std::vector<ManPage> pages, CLI::App& program,
                           const std::filesystem::path& folder);

}  // namespace tandem
