#include <cctype>
#include <functional>
#include <set>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "app/bench/bench_commands.h"
#include "app/cli/commands.h"
#include "app/common/exit_codes.h"
#include "app/common/option_checks.h"
#include "tests/app/cli/program_run.h"

// Tests every option of every command with values that a person or a script may give it by mistake.

namespace tandem {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;
using testing::ProgramOutput;
using testing::RunTandem;
using ::testing::StartsWith;

/// The program's commands, which do nothing.
class Commands {
 public:
  Commands() {
    app_.name("tandem");
    app_.require_subcommand(1);
    AddCommands(app_, exit_code_);
    // `tandem bench` hands all its words to a program of its own: the options are that program's
    app_.remove_subcommand(app_.get_subcommand("bench"));
    AddBenches(*app_.add_subcommand("bench"), exit_code_);
    RefuseEmptyTexts(app_);
  }
  CLI::App& app() { return app_; }

  /// Returns the line that refuses this; empty: it is taken, so far.
  std::string Refusal(const std::vector<std::string>& words) {
    std::vector<const char*> argv{"tandem"};
    for (const std::string& word : words) argv.push_back(word.c_str());
    try {
      app_.parse(static_cast<int>(argv.size()), argv.data());
    } catch (const CLI::Success&) {
      return {};
    } catch (const CLI::ValidationError& error) {
      return Explain(app_, error);
    } catch (const CLI::RequiredError&) {
      return {};  // the parser checks values before it misses an option
    } catch (const CLI::RequiresError&) {
      return {};
    } catch (const CLI::ParseError& error) {
      return "not by a check: " + Explain(app_, error);
    }
    return {};
  }

 private:
  /// Ends when all is parsed and found good, before any command runs.
  class Parser : public CLI::App {
    void pre_callback() override { throw CLI::Success(); }
  };
  Parser app_;
  int exit_code_ = 0;
};

struct Asked {
  std::vector<std::string> command;
  std::string option;  // "--seconds", or a positional's name
  bool positional = false;
  bool number = false;
  int values = 1;
  int before = 0;  // positionals that come first

  std::string name() const {
    std::string all;
    for (const std::string& word : command) all += word + " ";
    return all + option;
  }
  std::vector<std::string> With(const std::string& value) const {
    std::vector<std::string> words = command;
    for (int i = 0; positional && i < before; ++i) words.emplace_back("x");
    // "--option=" is an option without a value
    const bool in_one = !positional && values == 1 && !value.empty();
    if (!positional) words.push_back(in_one ? option + "=" + value : option);
    for (int i = in_one ? 1 : 0; i < values; ++i) words.push_back(value);
    return words;
  }
};

void Collect(CLI::App& app, const std::vector<std::string>& command, std::vector<Asked>& all) {
  int positionals = 0;
  for (const CLI::Option* option : app.get_options()) {
    if (option->get_items_expected_max() == 0) continue;  // a flag
    if (option->get_group().empty()) continue;            // for our own programs alone
    const std::string type = option->get_type_name();
    const auto is = [&type](const char* kind) {
      return type.rfind(kind, 0) == 0;
    };
    all.push_back({.command = command,
                   .option = option->get_name(),
                   .positional = option->get_positional(),
                   .number = is("FLOAT") || is("INT") || is("UINT"),
                   .values = option->get_items_expected_min(),
                   .before = positionals});
    positionals += option->get_positional() ? 1 : 0;
  }
  for (CLI::App* sub : app.get_subcommands({})) {
    std::vector<std::string> path = command;
    path.push_back(sub->get_name());
    if (!sub->get_prefix_command()) Collect(*sub, path, all);
  }
}

std::vector<Asked> AllOptions() {
  Commands commands;
  std::vector<Asked> all;
  Collect(commands.app(), {}, all);
  return all;
}

/// Expects one line that names the option and can be acted on.
void ExpectGoodRefusal(const Asked& requested, const std::string& value) {
  Commands commands;
  const std::string line = commands.Refusal(requested.With(value));
  ASSERT_NE(line, "") << requested.name() << " takes '" << value << "'";
  if (requested.values == 1) {
    EXPECT_THAT(line, StartsWith(requested.option + ": "))
        << requested.name() << " '" << value << "'";
  }
  EXPECT_THAT(line, Not(HasSubstr("\n")));
  EXPECT_THAT(line, HasSubstr(" --help)"));
  EXPECT_LT(line.size(), 200U) << line;
  EXPECT_THAT(line, HasSubstr(value.empty() ? "" : "got '" + value + "'"));
}

TEST(Options, NumbersRejectInvalidAndExtremeValues) {
  std::size_t numbers = 0;
  for (const Asked& requested : AllOptions()) {
    if (!requested.number) continue;
    ++numbers;
    for (const char* value : {"", "-1", "nan", "-nan", "inf", "1e300", "1e-300x", "many", " 1",
                              "99999999999999999999"}) {
      ExpectGoodRefusal(requested, value);
    }
  }
  EXPECT_GT(numbers, 60U);
}

// 0 is no number of anything here but means: for ever, all, none, the first
TEST(Options, ZeroIsAcceptedWhereMeaningful) {
  const std::set<std::string> means{"--control-domain",
                                    "--core",
                                    "--device-core",
                                    "--recentre",
                                    "bench device --busy",
                                    "bench fidelity --contacts",
                                    "--delay-ms",
                                    "--delays-ms",
                                    "--domain",
                                    "--force-layer",
                                    "--jitter-ms",
                                    "--loss",
                                    "--print",
                                    "--seconds",
                                    "--seed",
                                    "--relative-damping",
                                    "--speed",
                                    "--threads",
                                    "--wait-for",
                                    "--wait-seconds",
                                    "stability boundary --jobs",
                                    "stability random --first",
                                    "stability report --series"};
  const std::set<std::string> not_here{
      "sessions --seconds",      "demo --seconds",           "bench network --seconds",
      "bench session --seconds", "bench window --seconds",   "bench hostile --seconds",
      "simulate --seconds",      "simulate --seed",          "peer --threads",
      "replay --threads",        "bench frame --threads",    "bench voxelize --threads",
      "bench table1 --threads",  "bench figure10 --threads", "simulate --threads",
      "doctor --seconds",        "stability trace --seconds"};
  for (const Asked& requested : AllOptions()) {
    if (!requested.number) continue;
    const bool named = means.count(requested.option) + means.count(requested.name()) != 0;
    const bool taken = named && not_here.count(requested.name()) == 0;
    if (taken) {
      EXPECT_EQ(Commands().Refusal(requested.With("0")), "") << requested.name();
    } else {
      ExpectGoodRefusal(requested, "0");
    }
  }
}

TEST(Options, TextsRejectEmptyValues) {
  std::size_t texts = 0;
  for (const Asked& requested : AllOptions()) {
    if (requested.number) continue;
    ++texts;
    ExpectGoodRefusal(requested, "");
  }
  EXPECT_GT(texts, 40U);
}

TEST(Options, EchoedInputIsCleanedAndShortened) {
  Commands commands;
  const std::string line =
      commands.Refusal({"peer", "--seconds=\x1b[2J\n" + std::string(100'000, 'x')});
  EXPECT_THAT(line, StartsWith("--seconds: expected a number from 0 to 604800, got '?[2J?xxx"));
  EXPECT_THAT(line, HasSubstr("(tandem peer --help)"));
  EXPECT_LT(line.size(), 200U);
}

TEST(Options, SizesHaveUnits) {
  const CLI::Validator check = SizeInBytes();
  for (const auto& [text, bytes] : std::vector<std::pair<std::string, std::string>>{
           {"1", "1"}, {"7B", "7"}, {"1k", "1024"}, {"8GiB", "8589934592"}, {"0.5mb", "524288"}}) {
    std::string given = text;
    EXPECT_EQ(check(given), "");
    EXPECT_EQ(given, bytes);
  }
  for (const char* text : {"0", "-1", "nan", "1e300", "8 GiB", "8GiBs", "GiB", "2000TiB", "8X"}) {
    std::string given = text;
    EXPECT_THAT(check(given), HasSubstr("500MB or 8GiB, got '" + std::string(text)));
  }
}

// The name tells the unit, and so must the help. Each unit's own rule: metres per second end in
// -m-s.
TEST(Options, HelpNamesTheUnitThatTheNameHas) {
  Commands commands;
  std::size_t units = 0;
  const std::function<void(CLI::App&)> look = [&](CLI::App& app) {
    for (const CLI::Option* option : app.get_options()) {
      if (option->get_items_expected_max() == 0 || option->get_group().empty()) continue;
      const std::string name = option->get_name();
      const std::string help = option->get_description();
      if (name.ends_with("-per-s")) continue;
      for (const auto& [ending, unit] :
           std::vector<std::pair<std::string, std::string>>{{"-ms", " ms"},
                                                            {"-hz", "Hz"},
                                                            {"-mm", " mm"},
                                                            {"-N", " N"},
                                                            {"seconds", " s"},
                                                            {"minutes", "minutes"},
                                                            {"days", "days"},
                                                            {"-m", " m"},
                                                            {"-s", " s"}}) {
        if (!name.ends_with(ending)) continue;
        ++units;
        // the unit as a word: "ms" is not in "messages", nor " s" in " start"
        bool is_word = false;
        for (std::size_t at = help.find(unit); at != std::string::npos && !is_word;
             at = help.find(unit, at + 1)) {
          const std::size_t end = at + unit.size();
          is_word = end == help.size() || std::isalnum(static_cast<unsigned char>(help[end])) == 0;
        }
        EXPECT_TRUE(is_word) << app.get_name() << " " << name << ": " << help;
        break;
      }
    }
    for (CLI::App* sub : app.get_subcommands({})) look(*sub);
  };
  look(commands.app());
  EXPECT_GE(units, 15U);
}

/// The program itself answers with a line of its own and exit code 2.
TEST(Options, ProgramsReportErrorsInOneLine) {
  for (const auto& [words, line] : std::vector<std::pair<std::string, std::string>>{
           {"peer --seconds nan", "tandem: --seconds: expected a number from 0 to 604800"},
           {"simulate --threads 100000 --seeds 2",
            "tandem: --threads: expected a whole number from 1 to"},
           {"simulate --seed 1 --seeds 3", "tandem: --seed excludes --seeds"},
           {"simulate --seconds 3", "tandem: --seconds is for --scene or --hands"},
           {"peer --seconds", "tandem: --seconds: a value is missing (tandem peer --help)"},
           {"peer --seconds=", "tandem: --seconds: a value is missing (tandem peer --help)"},
           {"peer --session ''", "tandem: --session: the value is empty"},
           {"watch --session s --peers 'a b'", "tandem: --peers: 'a b' is not HOST or HOST:PORT"},
           {"keys viewer . ../eve", "tandem: NAME: '../eve' is not a member's name"},
           {"nonsense", "tandem: unknown command 'nonsense', expected one of: demo, open, "},
           {"bench nonsense",
            "tandem: unknown command 'nonsense', expected one of: memory, device, "},
           {"demo --sconds 3",
            "tandem: unknown option '--sconds' of 'tandem demo'; did you mean '--seconds'? "
            "(tandem "},
           {"opne gear", "tandem: unknown command 'opne'; did you mean 'open'? (tandem --help)"},
           {"stability swep", "tandem: unknown command 'swep'; did you mean 'sweep'? (tandem st"},
           {"peer --sesion=s",
            "tandem: unknown option '--sesion=s' of 'tandem peer'; did you mean '--session'?"},
           {"stability boundary --delay-s 1",
            "tandem: unknown option '--delay-s' of 'tandem stability boundary'; did you mean "
            "'--delays'?"},
           {"peer --\u00e9\u00e9\u00e9\u00e9\u00e9\u00e9",
            "tandem: unknown option '--\u00e9\u00e9\u00e9\u00e9\u00e9\u00e9' of 'tandem peer' "
            "(tandem "},
           {"demo more", "tandem: unexpected word 'more' (tandem demo --help)"},
           {"", "tandem: A subcommand is required"},
           {"view --seconds nan", "tandem-view: --seconds: expected a number from 0 to 604800"},
           {"view --report ''", "tandem-view: --report: the value is empty"}}) {
    const ProgramOutput output = RunTandem(words);
    EXPECT_EQ(output.exit_code, kExitUsage) << words;
    EXPECT_THAT(output.err, StartsWith(line)) << words;
    EXPECT_EQ(std::count(output.err.begin(), output.err.end(), '\n'), 1) << output.err;
  }
}

}  // namespace
}  // namespace tandem
