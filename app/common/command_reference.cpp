#include "app/common/command_reference.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <cstdint>
#include <cstdio>
#include <fstream>
#include <functional>
#include <string_view>
#include <utility>

#include "app/common/exit_codes.h"
#include "app/common/option_checks.h"

namespace tandem {

namespace {

constexpr std::array<std::pair<ExitCode, const char*>, 10> kExitMeanings{{
    {kExitOk, "ok"},
    {kExitFailed, "failed"},
    {kExitUsage, "usage: the command line is invalid"},
    {kExitFile, "file: a file cannot be read or written, or its content is invalid"},
    {kExitDisplay, "no display or no OpenGL"},
    {kExitNetwork, "network"},
    {kExitDevice, "device"},
    {kExitNotRealTime, "not real-time (only with --require-rt)"},
    {kExitIncompatiblePeer, "incompatible peer"},
    {kExitSecurity, "refused by security"},
}};

std::vector<CLI::App*> SubcommandsOf(CLI::App& app) {
  return app.get_subcommands([](const CLI::App* command) {
    return !command->get_name().empty() && !command->get_group().empty();
  });
}

/// Returns the options that --help shows.
std::vector<CLI::Option*> OptionsOf(CLI::App& app, bool positional) {
  return app.get_options([positional](const CLI::Option* option) {
    return !option->get_group().empty() && option->get_positional() == positional;
  });
}

/// Calls `visit` for a command and all commands below it, except those of other programs.
void Walk(CLI::App& app, const std::function<void(CLI::App&)>& visit) {
  visit(app);
  for (CLI::App* command : SubcommandsOf(app)) Walk(*command, visit);
}

// --- manual pages
// ---------------------------------------------------------------------------------

/// Returns the code point that begins at `at`, and moves `at` behind it.
std::uint32_t NextCodePoint(std::string_view text, std::size_t& at) {
  const auto first = static_cast<unsigned char>(text[at++]);
  if (first < 0xC0U) return first;
  const int more = first >= 0xF0U ? 3 : first >= 0xE0U ? 2 : 1;
  std::uint32_t code = first & (0x3FU >> more);
  for (int i = 0; i < more && at < text.size(); ++i) {
    code = code << 6U | (static_cast<unsigned char>(text[at++]) & 0x3FU);
  }
  return code;
}

/// Returns a text as roff that prints it unchanged. A "-" can be copied into a shell.
std::string Roff(std::string_view text) {
  std::string roff;
  bool line_begins = true;
  for (std::size_t at = 0; at < text.size();) {
    const std::uint32_t code = NextCodePoint(text, at);
    switch (code) {
      case '\\':
        roff += "\\e";
        break;
      case '-':
        roff += "\\-";
        break;
      case '\'':
        roff += "\\(aq";
        break;
      case '`':
        roff += "\\(ga";
        break;
      case '^':
        roff += "\\(ha";
        break;
      case '~':
        roff += "\\(ti";
        break;
      case '.':
        roff += line_begins ? "\\&." : ".";
        break;
      case 0x2026:
        roff += "...";
        break;  // an ellipsis, which some terminals lack
      default:
        if (code < 0x80U) {
          roff += static_cast<char>(code);
        } else {
          char escape[16];
          std::snprintf(escape, sizeof escape, "\\[u%04X]", static_cast<unsigned>(code));
          roff += escape;
        }
    }
    line_begins = code == '\n';
  }
  return roff;
}

std::string Upper(std::string text) {
  std::ranges::transform(text, text.begin(), [](unsigned char c) {
    return static_cast<char>(std::toupper(c));
  });
  return text;
}

std::string Entry(const std::string& bold, const std::string& italic, const std::string& what) {
  return ".TP\n\\fB" + Roff(bold) + "\\fR" +
         (italic.empty() ? "" : "\\fI" + Roff(italic) + "\\fR") + "\n" +
         (what.empty() ? "\\&" : Roff(what)) + "\n";
}

std::string OptionEntries(CLI::App& command) {
  const CLI::Formatter words;
  std::string text;
  for (const bool positional : {true, false}) {
    for (const CLI::Option* option : OptionsOf(command, positional)) {
      text += Entry(words.make_option_name(option, positional), words.make_option_opts(option),
                    words.make_option_desc(option));
    }
  }
  return text;
}

std::string Usage(const CLI::App& command) {
  constexpr std::string_view kLabel = "Usage: ";
  std::string usage = CLI::Formatter().make_usage(&command, CalledAs(command));
  usage.erase(0, kLabel.size());
  usage.erase(usage.find_last_not_of('\n') + 1);
  return usage;
}

std::string PageName(const CLI::App& command) {
  std::string name = CalledAs(command);
  std::ranges::replace(name, ' ', '-');
  return name;
}

std::string SubcommandEntries(CLI::App& app) {
  std::string text;
  for (CLI::App* command : SubcommandsOf(app)) {
    text += Entry(command->get_name(), "", command->get_description());
  }
  return text;
}

/// Returns sections for all commands below a program's subcommand, each with its options.
std::string SubcommandSections(CLI::App& app) {
  std::string text;
  for (CLI::App* command : SubcommandsOf(app)) {
    text += ".SS \"" + Roff(Usage(*command)) + "\"\n" + Roff(command->get_description()) + "\n" +
            OptionEntries(*command);
    if (!command->get_footer().empty()) text += ".PP\n" + Roff(command->get_footer()) + "\n";
    text += SubcommandSections(*command);
  }
  return text;
}

ManPage MakePage(CLI::App& command, CLI::App& program) {
  const bool whole = &command == &program;
  ManPage page{PageName(command), ""};
  page.text = ".TH " + Roff(Upper(page.name)) + " 1 \"\" \"" + Roff(program.get_name()) + " " +
              Roff(program.version()) + "\" \"User Commands\"\n" + ".SH NAME\n" + Roff(page.name) +
              " \\- " + Roff(command.get_description()) + "\n.SH SYNOPSIS\n\\fB" +
              Roff(Usage(command)) + "\\fR\n";
  if (!command.get_footer().empty()) {
    page.text += ".SH DESCRIPTION\n" + Roff(command.get_footer()) + "\n";
  }
  if (!SubcommandsOf(command).empty()) {
    page.text +=
        ".SH COMMANDS\n" + (whole ? SubcommandEntries(command) : SubcommandSections(command));
  }
  page.text += ".SH OPTIONS\n" + OptionEntries(command);
  page.text += ".SH EXIT STATUS\n";
  for (const auto& [code, meaning] : kExitMeanings) {
    page.text += Entry(std::to_string(static_cast<int>(code)), "", meaning);
  }
  std::string others;
  const auto see = [&others](const std::string& name) {
    others += (others.empty() ? "" : ",\n") + ("\\fB" + Roff(name) + "\\fR(1)");
  };
  if (whole) {
    for (const CLI::App* sub : SubcommandsOf(command)) see(PageName(*sub));
  } else {
    see(program.get_name());
  }
  if (!others.empty()) page.text += ".SH SEE ALSO\n" + others + "\n";
  return page;
}

// --- completion
// -----------------------------------------------------------------------------------

std::string FunctionName(const CLI::App& app) {
  std::string name = "_" + app.get_name();
  std::ranges::replace(name, '-', '_');
  return name;
}

std::vector<std::string> NamesOf(const CLI::Option& option) {
  std::vector<std::string> names;
  for (const std::string& name : option.get_snames()) names.push_back("-" + name);
  for (const std::string& name : option.get_lnames()) names.push_back("--" + name);
  return names;
}

std::string Joined(const std::vector<std::string>& words, const std::string& between) {
  return CLI::detail::join(words, between);
}

/// Returns a branch of a shell's case: any of `patterns` does `action`.
std::string Arm(const std::vector<std::string>& patterns, const std::string& action) {
  if (patterns.empty()) return "";
  return "    '" + Joined(patterns, "' | '") + "') " + action + " ;;\n";
}

}  // namespace

std::vector<ManPage> ManPages(CLI::App& app) {
  std::vector<ManPage> pages{MakePage(app, app)};
  for (CLI::App* command : SubcommandsOf(app)) {
    if (!command->get_prefix_command()) pages.push_back(MakePage(*command, app));
  }
  return pages;
}

std::string BashCompletion(CLI::App& app) {
  std::vector<std::string> commands;   // below the program
  std::vector<std::string> handed_on;  // handed on to other programs
  std::string words_of_options;
  std::string words_of_commands;
  Walk(app, [&](CLI::App& command) {
    const std::string name = CalledAs(command);
    if (&command != &app) commands.push_back(name);
    if (command.get_prefix_command()) {
      handed_on.push_back(name);
      return;
    }
    std::vector<std::string> words;
    std::vector<std::string> with_files;  // options with a value that no list of words bounds
    for (const CLI::App* sub : SubcommandsOf(command)) words.push_back(sub->get_name());
    for (CLI::Option* option : OptionsOf(command, false)) {
      std::vector<std::string> called;
      for (const std::string& spelling : NamesOf(*option)) {
        words.push_back(spelling);
        called.push_back(name + " " + spelling);
      }
      if (option->get_items_expected_max() == 0) continue;  // a flag
      const std::vector<std::string> choice = WordsToChooseFrom(*option);
      if (choice.empty()) {
        with_files.insert(with_files.end(), called.begin(), called.end());
      } else {
        words_of_options += Arm(called, "words='" + Joined(choice, " ") + "'");
      }
    }
    words_of_options += Arm(with_files, "return");
    words_of_commands += Arm({name}, "words='" + Joined(words, " ") + "'");
  });

  const std::string function = FunctionName(app);
  std::string script = "# Completion of " + app.get_name() +
                       " in bash, made from its command line.\n\n" + function + "() {\n" +
                       "  local word=${COMP_WORDS[COMP_CWORD]} before=${COMP_WORDS[COMP_CWORD-1]}\n"
                       "  local command=" +
                       app.get_name() +
                       " words='' i\n"
                       "  COMPREPLY=()\n"
                       "  # --option=value is three words here\n"
                       "  if [[ $word == = ]]; then word=''\n"
                       "  elif [[ $before == = ]]; then before=${COMP_WORDS[COMP_CWORD-2]}; fi\n";
  if (!commands.empty()) {
    script +=
        "  for ((i = 1; i < COMP_CWORD; ++i)); do\n"
        "    case \"$command ${COMP_WORDS[i]}\" in\n" +
        Arm(commands, "command+=\" ${COMP_WORDS[i]}\"") + "    esac\n  done\n";
  }
  if (!handed_on.empty()) {
    script += "  case $command in\n" +
              Arm(handed_on,
                  "local program=${command// /-} depth=()\n"
                  "      read -ra depth <<<\"$command\"\n"
                  "      declare -F \"_${program//-/_}\" >/dev/null ||\n"
                  "        source \"${BASH_SOURCE[0]%/*}/$program\" 2>/dev/null || return 0\n"
                  "      COMP_WORDS=(\"$program\" \"${COMP_WORDS[@]:${#depth[@]}}\")\n"
                  "      ((COMP_CWORD -= ${#depth[@]} - 1))\n"
                  "      \"_${program//-/_}\"\n"
                  "      return") +
              "  esac\n";
  }
  script += "  case \"$command $before\" in\n" + words_of_options + "    *) case $command in\n" +
            words_of_commands + "    esac ;;\n  esac\n" +
            "  COMPREPLY=($(compgen -W \"$words\" -- \"$word\"))\n}\n\n" +
            "complete -o default -F " + function + " " + app.get_name() + "\n";
  return script;
}

std::string WriteReference(std::vector<ManPage> pages, CLI::App& program,
                           const std::filesystem::path& folder) {
  std::vector<std::pair<std::filesystem::path, std::string>> files;
  for (ManPage& page : pages) {
    files.emplace_back(folder / "man1" / (page.name + ".1"), std::move(page.text));
  }
  files.emplace_back(folder / "completions" / program.get_name(), BashCompletion(program));
  for (const auto& [path, text] : files) {
    std::error_code failed;  // the stream reports the fault
    std::filesystem::create_directories(path.parent_path(), failed);
    std::ofstream file(path);
    file << text;
    file.close();
    if (!file) return path.string() + ": cannot be written";
  }
  return {};
}

std::string WriteReference(CLI::App& app, const std::filesystem::path& folder) {
  return WriteReference(ManPages(app), app, folder);
}

}  // namespace tandem
