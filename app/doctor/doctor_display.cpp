#include "app/doctor/doctor_display.h"

#include <chrono>
#include <optional>
#include <string>

#include <nlohmann/json.hpp>
#include <unistd.h>

#include "app/common/exit_codes.h"
#include "app/common/program_folders.h"
#include "app/process/program_answer.h"

namespace tandem {
namespace {

constexpr std::chrono::milliseconds kPatience{15'000};  // a display over a network may be slow
constexpr const char* kNoWindow = "no window can open";
constexpr const char* kWithoutWindow =
    "'tandem peer', 'tandem watch' and 'tandem demo --headless' need no window";

/// Returns the last line of what a program wrote, without the program's name.
std::string LastLine(std::string text) {
  while (!text.empty() && text.back() == '\n') text.pop_back();
  std::string line = text.substr(text.rfind('\n') + 1);
  constexpr std::string_view kName = "tandem-view: ";
  if (line.starts_with(kName)) line.erase(0, kName.size());
  return line;
}

/// Returns a line of the text with these words; empty: none.
std::string LineWith(const std::string& text, const std::string& words) {
  const std::size_t at = text.find(words);
  if (at == std::string::npos) return {};
  const std::size_t begin = text.rfind('\n', at) + 1;
  return text.substr(begin, text.find('\n', at) - begin);
}

}  // namespace

void CheckDisplay(Findings& findings) {
  const std::string what = "display";
  if (access((ProgramFolder() / "tandem-view").c_str(), X_OK) != 0) {
    findings.Add(Finding::kWarning, what, "the program of windows, tandem-view, is not installed",
                 std::string("install it beside this program; ") + kWithoutWindow);
    return;
  }
  ProgramAnswer look("tandem-view", {}, "--check-display");
  const std::optional<int> code = look.Wait(kPatience);
  const std::string text = look.text();
  if (!code) {
    findings.Add(Finding::kWarning, what, std::string(kNoWindow) + ": the display does not answer",
                 "see whether the display server runs");
    return;
  }
  const nlohmann::json found =
      nlohmann::json::parse(LineWith(text, "{\"platform\""), nullptr, false);
  if (!found.is_object()) {
    // Qt ends the program where a platform's plug-in is missing
    const bool plugin = text.find("platform plugin") != std::string::npos;
    const std::string why = plugin ? LineWith(text, "platform plugin") : LastLine(text);
    findings.Add(Finding::kWarning, what, std::string(kNoWindow) + ": " + why,
                 plugin
                     ? "install Qt's platform (package qt6-qpa-plugins), or unset QT_QPA_PLATFORM"
                     : kWithoutWindow);
    return;
  }
  findings.Add(Finding::kGood, what,
               "a window can open, by Qt's platform " + found.at("platform").get<std::string>());
  const std::string renderer = found.at("renderer").get<std::string>();
  if (*code != kExitOk) {
    findings.Add(Finding::kWarning, "OpenGL", found.at("fault").get<std::string>());
  } else if (found.at("software").get<bool>()) {
    findings.Add(Finding::kWarning, "OpenGL",
                 found.at("version").get<std::string>() + ", " + renderer + ": the processor draws",
                 "fine for a look; large scenes turn slowly, so install the driver of the graphics "
                 "card if there is one");
  } else {
    findings.Add(Finding::kGood, "OpenGL",
                 found.at("version").get<std::string>() + ", " + renderer);
  }
}

}  // namespace tandem
