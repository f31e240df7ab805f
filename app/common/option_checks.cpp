#include "app/common/option_checks.h"

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <string_view>
#include <utility>

#include "app/common/command_reference.h"
#include "app/common/console.h"
#include "app/common/exit_codes.h"
#include "engine/base/text/clean_text.h"
#include "engine/base/text/nearest_word.h"

namespace tandem {

namespace {

constexpr std::size_t kLongestValue = 60;  // characters of a value that are shown
constexpr std::size_t kLongestLine = 300;
constexpr std::size_t kLongestTypo = 40;  // characters; what is longer is no typing error
constexpr const char* kOneOf = "one of";  // name of OneOf's checks, by which WordsToChooseFrom()
                                          // finds them

std::string Shown(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.10g", value);
  return text;
}

std::string Cut(std::string text, std::size_t longest) {
  if (text.size() <= longest) return text;
  while (longest > 0 && (static_cast<unsigned char>(text[longest]) & 0xC0U) == 0x80U) --longest;
  return text.substr(0, longest) + "...";
}

std::string ExpectedText(const std::string& what, const std::string& got) {
  return "expected " + what + ", got '" + Cut(got, kLongestValue) + "'";
}

template <typename T>
bool Parse(const std::string& text, T& value) {
  const char* end = text.data() + text.size();
  const auto [stop, error] = std::from_chars(text.data(), end, value);
  return error == std::errc() && stop == end;
}

CLI::Validator NumberCheck(const std::string& words, double least, double most, bool open) {
  const auto check = [=](std::string& text) -> std::string {
    double value = 0;
    const bool sound = Parse(text, value) && (open ? value > least : value >= least);
    return sound && value <= most ? "" : ExpectedText("a number " + words, text);
  };
  return {check, words};
}

/// Returns the innermost subcommand that the command line names.
const CLI::App& Meant(const CLI::App& app) {
  const CLI::App* at = &app;
  while (!at->get_subcommands().empty()) at = at->get_subcommands().front();
  return *at;
}

/// Returns "; did you mean 'X'?" for a word that is nearly one of `known`; else empty.
std::string DidYouMean(const std::string& word, const std::vector<std::string>& known) {
  if (word.size() > kLongestTypo) return {};
  const std::string_view nearest =
      NearestWord(word, std::vector<std::string_view>(known.begin(), known.end()));
  return nearest.empty() ? "" : "; did you mean '" + std::string(nearest) + "'?";
}

/// Returns "; did you mean '--X'?" for an option that is nearly one of the command's.
std::string DidYouMeanOption(const CLI::App& command, const std::string& typed) {
  std::vector<std::string> known;
  for (const CLI::Option* option : command.get_options()) {
    for (const std::string& name : option->get_lnames()) known.push_back(name);
  }
  // the dashes are in every option, and a value may stand behind a '='
  std::string word = typed.substr(std::min(typed.find_first_not_of('-'), typed.size()));
  word = word.substr(0, word.find('='));
  std::string hint = DidYouMean(word, known);
  if (const std::size_t quote = hint.find('\''); quote != std::string::npos) {
    hint.insert(quote + 1, "--");
  }
  return hint;
}

/// Explains words that the command does not know.
std::string ExplainUnknown(const CLI::App& command, const std::vector<std::string>& words) {
  const auto option = std::ranges::find_if(words, [](const std::string& word) {
    return word.size() > 1 && word[0] == '-';
  });
  const std::string name = CalledAs(command);
  if (option != words.end()) {
    return "unknown option '" + Cut(*option, kLongestValue) + "' of '" + name + "'" +
           DidYouMeanOption(command, *option);
  }
  std::string known;
  std::vector<std::string> names;
  for (const CLI::App* sub : command.get_subcommands([](const CLI::App*) {
         return true;
       })) {
    known += (known.empty() ? "" : ", ") + sub->get_name();
    names.push_back(sub->get_name());
  }
  const std::string word = "'" + Cut(words.front(), kLongestValue) + "'";
  if (known.empty()) return "unexpected word " + word;
  if (const std::string hint = DidYouMean(words.front(), names); !hint.empty()) {
    return "unknown command " + word + hint;
  }
  return "unknown command " + word + ", expected one of: " + known;
}

}  // namespace

std::string CalledAs(const CLI::App& command) {
  const CLI::App* parent = command.get_parent();
  return (parent == nullptr ? "" : CalledAs(*parent) + " ") + command.get_name();
}

CLI::Validator NumberFrom(double least, double most) {
  return NumberCheck("from " + Shown(least) + " to " + Shown(most), least, most, false);
}

CLI::Validator NumberAbove(double least, double most) {
  return NumberCheck("above " + Shown(least) + ", at most " + Shown(most), least, most, true);
}

CLI::Validator WholeNumberFrom(std::int64_t least, std::int64_t most) {
  const std::string words = "from " + std::to_string(least) + " to " + std::to_string(most);
  const auto check = [=](std::string& text) -> std::string {
    std::int64_t value = 0;
    if (!Parse(text, value) || value < least || value > most) {
      return ExpectedText("a whole number " + words, text);
    }
    text = std::to_string(value);  // without leading zeros: CLI11 would read 010 as octal
    return "";
  };
  return {check, words};
}

CLI::Validator SizeInBytes() {
  const auto check = [](std::string& text) -> std::string {
    const std::size_t digits = text.find_first_not_of("0123456789.");
    double size = 0;
    bool sound = Parse(text.substr(0, digits), size);
    if (sound && digits != std::string::npos) {
      constexpr std::string_view kUnits = "KMGT";
      std::string unit = text.substr(digits);
      std::transform(unit.begin(), unit.end(), unit.begin(), [](unsigned char c) {
        return static_cast<char>(std::toupper(c));
      });
      const std::size_t power = kUnits.find(unit[0]);
      sound =
          unit == "B" || (power != std::string_view::npos &&
                          (unit.size() == 1 || unit.substr(1) == "B" || unit.substr(1) == "IB"));
      if (sound && unit != "B") size = std::ldexp(size, 10 * (static_cast<int>(power) + 1));
    }
    if (!sound || !(size >= 1) || !(size <= std::ldexp(1.0, 50))) {
      return ExpectedText("a size up to 1024TiB, such as 500MB or 8GiB", text);
    }
    text = std::to_string(static_cast<std::uint64_t>(size));
    return "";
  };
  return {check, "bytes"};
}

CLI::Validator OneOf(std::vector<std::string> words) {
  std::string all;
  for (const std::string& word : words) all += (all.empty() ? "" : ", ") + word;
  const auto check = [all, words = std::move(words)](std::string& text) -> std::string {
    const bool known = std::find(words.begin(), words.end(), text) != words.end();
    return known ? "" : ExpectedText("one of " + all, text);
  };
  return {check, all, kOneOf};
}

std::string EndingOf(const std::string& file) {
  std::string ending = std::filesystem::path(file).extension().string();
  std::ranges::transform(ending, ending.begin(), [](unsigned char c) {
    return static_cast<char>(std::tolower(c));
  });
  return ending;
}

CLI::Validator FileEndingIn(std::vector<std::string> endings) {
  std::string all;
  for (const std::string& ending : endings) all += (all.empty() ? "" : " or ") + ending;
  const auto check = [all, endings = std::move(endings)](std::string& file) -> std::string {
    const std::string ending = EndingOf(file);
    const bool known = std::ranges::find(endings, ending) != endings.end();
    return ending.empty() || known ? ""
                                   : ExpectedText("the name of a file that ends in " + all, file);
  };
  return {check, all};
}

std::vector<std::string> WordsToChooseFrom(CLI::Option& option) {
  std::string all;
  try {
    all = option.get_validator(kOneOf)->get_description();
  } catch (const CLI::OptionNotFound&) {
    return {};
  }
  std::vector<std::string> words;
  for (std::size_t at = 0; at < all.size();) {
    const std::size_t end = std::min(all.find(", ", at), all.size());
    words.push_back(all.substr(at, end - at));
    at = end + 2;
  }
  return words;
}

void RefuseEmptyTexts(CLI::App& app) {
  for (CLI::Option* option : app.get_options()) {
    if (option->get_items_expected_max() == 0) continue;  // a flag
    option->check(CLI::Validator(
        [](std::string& text) -> std::string {
          return text.empty() ? "the value is empty" : "";
        },
        ""));
  }
  for (CLI::App* command : app.get_subcommands({})) RefuseEmptyTexts(*command);
}

std::string Explain(const CLI::App& app, const CLI::ParseError& error) {
  const CLI::App& command = Meant(app);
  const std::vector<std::string> unknown = app.remaining(true);
  // CLI11 stores the name of this command in the error's name
  const auto code = static_cast<CLI::ExitCodes>(error.get_exit_code());
  const bool extra = code == CLI::ExitCodes::ExtrasError ||
                     (code == CLI::ExitCodes::RequiredError && !unknown.empty());
  std::string line = error.what();
  if (extra && !unknown.empty()) line = ExplainUnknown(command, unknown);
  if (error.get_name() == "ArgumentMismatch" && line.size() > 8 &&
      line.compare(line.size() - 8, 8, " missing") == 0) {
    line = line.substr(0, line.find(':')) + ": a value is missing";
  }
  return CleanText(Cut(std::move(line), kLongestLine)) + " (" + CalledAs(command) + " --help)";
}

std::optional<int> ParseOrExplain(CLI::App& app, int argc, const char* const* argv) {
  if (argc == 3 && std::string_view(argv[1]) == "--write-reference") {
    const std::string fault = WriteReference(app, argv[2]);
    if (fault.empty()) return kExitOk;
    SayAs(app.get_name().c_str(), fault);
    return kExitFile;
  }
  RefuseEmptyTexts(app);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() == 0) {
      app.exit(error);  // help, version
      return kExitOk;
    }
    SayAs(app.get_name().c_str(), Explain(app, error));
    return kExitUsage;
  } catch (const std::exception& error) {
    SayAs(app.get_name().c_str(), error.what());
    return kExitFailed;
  }
  return std::nullopt;
}

}  // namespace tandem
