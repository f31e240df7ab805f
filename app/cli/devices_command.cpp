#include <chrono>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <memory>
#include <optional>
#include <sstream>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>
#include <sys/mman.h>
#include <unistd.h>

#include "app/cli/commands.h"
#include "app/common/console.h"
#include "app/common/exit_codes.h"
#include "app/common/option_checks.h"
#include "app/process/program_answer.h"
#include "engine/base/text/json_text.h"

namespace tandem {
namespace {

using std::chrono::milliseconds;

constexpr milliseconds kListing{5000};  // time that a driver may take to look for its devices
constexpr double kOpeningSeconds = 30;  // time that a device may take to open before it is tried

struct DevicesArguments {
  bool json = false;
  bool all = false;
  std::string tried;
  double seconds = 5;
};

/// Runs `tandem-device` with some words. A process of its own is needed because a driver may crash
/// and its vendor's library may hang.
class DeviceAnswer : public ProgramAnswer {
 public:
  explicit DeviceAnswer(const std::vector<std::string>& words)
      : ProgramAnswer("tandem-device", words, "--to") {}
};

/// One line of the list.
struct ListedDevice {
  std::string name{};  // name for --device
  std::string kind{};
  std::string model{};
  bool present = false;
  std::string missing{};
  std::string mend{};
};

/// Returns what a driver said, a line for each device. If the driver said nothing sound, it returns
/// one line with `missing`.
std::vector<ListedDevice> Listed(const std::string& driver, std::optional<int> code,
                                 const std::string& answer) {
  const auto fault = [&driver](const std::string& what) {
    return std::vector<ListedDevice>{
        {.name = driver, .missing = what, .mend = "report this to the author of the driver"}};
  };
  if (!code) return fault("the driver did not answer within 5 s");
  if (*code != kExitOk) return fault("the driver ended with exit code " + std::to_string(*code));
  const nlohmann::json output = nlohmann::json::parse(answer, nullptr, false);
  if (!output.is_object()) return fault("the driver's list cannot be read");
  if (output.contains("error")) return fault(output.at("error").get<std::string>());
  std::vector<ListedDevice> devices;
  for (const nlohmann::json& one : output.at("devices")) {
    const std::string options = one.at("options").get<std::string>();
    devices.push_back({.name = options.empty() ? driver : driver + ":" + options,
                       .kind = output.at("kind").get<std::string>(),
                       .model = one.at("model").get<std::string>(),
                       .present = one.at("present").get<bool>(),
                       .missing = one.at("missing").get<std::string>(),
                       .mend = one.at("mend").get<std::string>()});
  }
  if (devices.empty()) devices.push_back({.name = driver, .kind = output.at("kind")});
  return devices;
}

int ListDevices(const DevicesArguments& arguments) {
  DeviceAnswer names({"--drivers"});
  if (names.Wait(kListing) != kExitOk) {
    return Fail(
        kExitDevice,
        "cannot run tandem-device, which knows the drivers: is it in the folder of this program " +
            (ProgramFolder() / "tandem").string() + "?");
  }
  // all drivers at once, because each may take seconds
  std::vector<std::pair<std::string, std::unique_ptr<DeviceAnswer>>> answers;
  std::istringstream lines(names.text());
  for (std::string name; std::getline(lines, name);) {
    if (name == "fake" && !arguments.all) continue;
    answers.emplace_back(name,
                         std::make_unique<DeviceAnswer>(std::vector<std::string>{"--list", name}));
  }
  nlohmann::ordered_json out = nlohmann::ordered_json::array();
  for (const auto& [driver, answer] : answers) {
    const std::optional<int> code = answer->Wait(kListing);
    for (const ListedDevice& one : Listed(driver, code, answer->text())) {
      out.push_back({{"name", one.name},
                     {"kind", one.kind},
                     {"model", one.model},
                     {"present", one.present},
                     {"missing", one.missing},
                     {"mend", one.mend}});
      if (arguments.json) continue;
      PrintLine("%-24s %-8s %s", one.name.c_str(), one.present ? "there" : "-", one.kind.c_str());
      if (!one.missing.empty()) PrintLine("%-24s missing: %s", "", one.missing.c_str());
      if (!one.mend.empty()) PrintLine("%-24s mend:    %s", "", one.mend.c_str());
    }
  }
  if (arguments.json) {
    PrintText(JsonText(nlohmann::ordered_json{{"devices", out}}, 2));
  } else {
    PrintText(
        "\ntandem peer --device NAME[:OPTIONS] uses one of them; docs/devices.md explains the "
        "options.");
  }
  return kExitOk;
}

int TryOne(const DevicesArguments& arguments) {
  const std::filesystem::path counter =
      ProgramFolder().parent_path() / "lib" / "tandem" / "count-allocations.so";
  if (access(counter.c_str(), R_OK) == 0) {
    setenv("LD_PRELOAD", counter.c_str(), 1);  // NOLINT(concurrency-mt-unsafe): one thread
  }
  DeviceAnswer answer({"--try", arguments.tried, "--seconds", std::to_string(arguments.seconds)});
  const auto most = milliseconds(static_cast<long>(1000 * (arguments.seconds + kOpeningSeconds)));
  const std::optional<int> code = answer.Wait(most);
  if (!code) {
    return Fail(kExitDevice, "--try " + arguments.tried + ": the device does not answer");
  }
  if (*code != kExitOk) return *code > 128 ? kExitDevice : *code;  // the process said why
  if (arguments.json) {
    PrintText(answer.text());
    return kExitOk;
  }
  const nlohmann::json seen = nlohmann::json::parse(answer.text(), nullptr, false);
  if (!seen.is_object()) return Fail(kExitDevice, "the answer of tandem-device cannot be read");
  PrintLine("%s: measures %d degrees of freedom, drives %d; peak force %g N",
            arguments.tried.c_str(), seen.at("freedoms_in").get<int>(),
            seen.at("freedoms_out").get<int>(), seen.at("peak_force_N").get<double>());
  PrintLine("  moved %.1f mm, turned %.1f degrees; buttons: clutch %s, stop %s",
            seen.at("moved_mm").get<double>(), seen.at("turned_deg").get<double>(),
            seen.at("clutch_button").get<bool>() ? "pressed" : "not pressed",
            seen.at("stop_button").get<bool>() ? "pressed" : "not pressed");
  PrintLine("  %ld ticks; reading %.1f us at p99, writing %.1f us; %ld without news, %ld failed",
            seen.at("ticks").get<long>(), seen.at("read_us").at("p99").get<double>(),
            seen.at("write_us").at("p99").get<double>(), seen.at("repeated").get<long>(),
            seen.at("failed").get<long>());
  for (const nlohmann::json& trouble : seen.at("troubles")) {
    PrintLine("  %s", trouble.get<std::string>().c_str());
  }
  return kExitOk;
}

}  // namespace

void AddDevicesCommand(CLI::App& app, int& exit_code) {
  auto arguments = std::make_shared<DevicesArguments>();
  CLI::App* command = app.add_subcommand(
      "devices",
      "List the devices of this machine, and for each absent one what is missing and the remedy");
  command->add_flag("--all", arguments->all, "list drivers for tests too");
  CLI::Option* tried = command->add_option(
      "--try", arguments->tried,
      "read the device NAME[:OPTIONS] for a while without force, and print what it does");
  command->add_option("--seconds", arguments->seconds, "duration of --try, s")
      ->check(NumberFrom(0, 3600))
      ->needs(tried)
      ->capture_default_str();
  command->add_flag("--json", arguments->json, "print one JSON object");
  command->callback([arguments, &exit_code] {
    exit_code = arguments->tried.empty() ? ListDevices(*arguments) : TryOne(*arguments);
  });
}

}  // namespace tandem
