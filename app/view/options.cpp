#include "app/view/options.h"

#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <sstream>

#include <CLI/CLI.hpp>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include "app/common/exit_codes.h"
#include "app/common/option_checks.h"

namespace tandem {

namespace {

std::string Environment(const char* name) {
  const char* value = std::getenv(name);
  return value != nullptr ? value : "";
}

/// Returns whether a server listens at the socket of local X display `number`.
bool LocalDisplayAnswers(const std::string& number) {
  const std::string path = "/tmp/.X11-unix/X" + number;
  for (const bool abstract : {true, false}) {
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    const std::size_t offset = abstract ? 1 : 0;
    if (path.size() + offset >= sizeof address.sun_path) return false;
    std::memcpy(address.sun_path + offset, path.data(), path.size());
    const int descriptor = socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0);
    if (descriptor < 0) return false;
    const auto length =
        static_cast<socklen_t>(offsetof(sockaddr_un, sun_path) + offset + path.size());
    const bool answers =
        connect(descriptor, reinterpret_cast<const sockaddr*>(&address), length) == 0;
    close(descriptor);
    if (answers) return true;
  }
  return false;
}

/// Adds the options on the session, the scene and the hand.
void AddHandOptions(CLI::App& app, ViewOptions& options) {
  AddSessionOption(app, options.join.session, "join this session at once");
  app.add_option("--scene", options.scene, "scene file; otherwise the session's, if it is here");
  CLI::Option* open = app.add_option(
      "--open", options.open, "take part in this scene (file): alone, or with others in --session");
  CLI::Option* part =
      app.add_flag("--take-part", options.take_part, "in --session, with a hand of your own")
          ->needs("--session");
  app.add_option("--control", options.hand.control, "name of the controller that is started");
  app.add_flag("--attach", options.attach, "take up the controller --control, which runs already")
      ->needs("--control")
      ->excludes(open)
      ->excludes(part);
  app.add_option("--device", options.hand.device,
                 "device that moves the hand, given as for 'tandem peer --device'; default: the mouse");
  app.add_option("--peer-options", options.peer_options,
                 "further options of the controller (tandem peer --help), in one text");
  app.add_flag("--own", options.own, "with --attach: the controller ends with the window")
      ->needs("--attach");
  app.add_option("--name", options.join.name, "how others see you")->capture_default_str();
  AddReachOptions(app, options.reach);
  app.add_flag("--from-relay", options.join.from_relay, "look through a relay (tandem relay)");
  app.add_flag("--proximity", options.proximity,
               "show distances from the start: colours, near voxels, the least distance (key P)");
  app.add_flag("--blind", options.blind,
               "show the scene alone: no figures of delay or force, no tables, no menus");
}

/// Adds the options on pictures and reports.
void AddPictureOptions(CLI::App& app, ViewOptions& options) {
  app.add_option("--screenshot", options.screenshot,
                 "write the window as a picture (PNG), then end unless --seconds is given");
  app.add_option("--screenshot-after", options.screenshot_after,
                 "seconds from when scene and poses are there")
      ->check(NumberFrom(0, kLongestRun))
      ->capture_default_str();
  app.add_flag("--fit", options.fit,
               "with --screenshot: fit all bodies into the picture where they are then");
  app.add_option("--report", options.report, "write what was received (JSON) there at the end");
  app.add_option("--paint", options.paint,
                 "no window: paint the pictures of this file (JSON, of a report) as PNG, then end")
      ->check(CLI::ExistingFile);
  app.add_option("--into", options.paint_into, "with --paint: the folder for them")
      ->default_val(".");
  CLI::Option* time =
      app.add_option("--time-pictures", options.time_pictures,
                     "no window: write how long pictures of --scene take (JSON) there, then end")
          ->needs("--scene");
  app.add_option("--rounds", options.rounds, "with --time-pictures: times that all is measured")
      ->needs(time)
      ->check(WholeNumberFrom(1, 99))
      ->capture_default_str();
}

/// Derives the requests to the hand's controller and to the session from the options.
void FillRequests(ViewOptions& options) {
  if (options.hand.control.empty()) options.hand.control = "window-" + std::to_string(getpid());
  options.hand.scene = options.open;
  std::istringstream words(options.peer_options);
  for (std::string word; words >> word;) options.hand.further.push_back(word);
  options.hand.session = options.join.session;
  options.hand.name = options.join.name;
  options.hand.domain = options.reach.domain;
  options.hand.interface = options.reach.interface;
  options.hand.peers = options.reach.peers;
  options.hand.external_address = options.reach.external_address;
  options.hand.port = options.reach.port;
  options.hand.secure = options.reach.secure;
  options.join.domain = options.reach.domain;
  options.join.interface = options.reach.interface;
}

/// Identifies the viewer in a secured session. Returns the exit code.
int IdentifyViewer(ViewOptions& options) {
  // a controller identifies the user that takes part
  const bool looks_on = options.open.empty() && !options.take_part && !options.attach;
  if (looks_on && !options.reach.secure.empty()) {
    const Result<PeerId> id = Identify(options.reach, Role::kViewer, options.join.name);
    if (!id) {
      std::fprintf(stderr, "tandem-view: %s\n", id.error().what.c_str());
      return kExitSecurity;
    }
    options.join.peer = *id;
    options.join.secured = true;
  }
  return kExitOk;
}

}  // namespace

std::optional<ViewOptions> ReadOptions(int argc, char** argv, int& exit_code) {
  ViewOptions options;
  options.join.name = Environment("USER").empty() ? "viewer" : Environment("USER");
  CLI::App app{
      "Look on at a session, or take part in one through a controller. Never simulates itself."};
  app.name("tandem-view");
  app.set_version_flag("--version", TANDEM_VERSION);
  AddHandOptions(app, options);
  AddPictureOptions(app, options);
  app.add_option("--seconds", options.seconds, "end after this; 0: when the window is closed")
      ->check(NumberFrom(0, kLongestRun));
  app.footer(
      "Exit codes: 0 ok, 1 failed, 2 usage, 3 file, 4 no display or OpenGL, 5 network, 9 "
      "security.\n"
      "Without OpenGL the window opens all the same and says why; a picture then shows that page, "
      "and the\n"
      "exit code is 4.");
  if (const std::optional<int> ended = ParseOrExplain(app, argc, argv)) {
    exit_code = *ended;
    return std::nullopt;
  }
  FillRequests(options);
  if (const int failed = IdentifyViewer(options); failed != kExitOk) {
    exit_code = failed;
    return std::nullopt;
  }
  return options;
}

std::string DisplayTrouble() {
  const std::string platform = Environment("QT_QPA_PLATFORM");
  const std::string display = Environment("DISPLAY");
  const bool wayland = !Environment("WAYLAND_DISPLAY").empty();
  if (!platform.empty() && platform.rfind("xcb", 0) != 0) return {};
  if (platform.empty() && wayland) return {};
  if (display.empty()) {
    return "no display: neither DISPLAY nor WAYLAND_DISPLAY is set (xvfb-run gives one without a "
           "screen, "
           "`tandem watch` needs none)";
  }
  if (display[0] == ':' && !LocalDisplayAnswers(display.substr(1, display.find('.') - 1))) {
    return "no display: nobody answers at DISPLAY " + display;
  }
  return {};
}

}  // namespace tandem
