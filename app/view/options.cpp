#include "app/view/options.h"

#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <sstream>

#include <CLI/CLI.hpp>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include "app/common/console.h"
#include "app/common/exit_codes.h"
#include "app/common/option_checks.h"
#include "collab/dds/control/control_folder.h"

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
  AddSessionOption(app, options.join.session, "name of a session to join at once");
  app.add_option("--scene", options.scene,
                 "scene file; default: the session's scene, if it is on this machine");
  CLI::Option* open = app.add_option(
      "--open", options.open, "scene file to take part in: alone, or with others in --session");
  CLI::Option* part = app.add_flag("--take-part", options.take_part,
                                   "take part in --session with a hand of your own")
                          ->needs("--session");
  app.add_option("--control", options.hand.control,
                 "name of the controller that the window starts");
  app.add_flag("--attach", options.attach, "attach to the running controller --control")
      ->needs("--control")
      ->excludes(open)
      ->excludes(part);
  app.add_option("--device", options.hand.device,
                 "device that moves the hand, as for 'tandem peer --device'; default: the mouse");
  app.add_option("--peer-options", options.peer_options,
                 "further options of the controller (see tandem peer --help), in one text");
  app.add_flag("--own", options.own, "with --attach: end the controller when the window closes")
      ->needs("--attach");
  app.add_option("--name", options.join.name, "name that others see")->capture_default_str();
  AddConnectionOptions(app, options.connection);
  app.add_flag("--from-relay", options.join.from_relay,
               "connect to a relay of the session ('tandem relay')");
  app.add_flag("--proximity", options.proximity,
               "show distances from the start: colours, near voxels, least distance (key P)");
  app.add_flag("--blind", options.blind,
               "show the scene alone: no figures of delay or force, no tables, no menus");
}

/// Adds the options on pictures and reports.
void AddPictureOptions(CLI::App& app, ViewOptions& options) {
  app.add_option(
         "--screenshot", options.screenshot,
         "picture file (PNG) of the window; the program then ends, unless --seconds is given")
      ->check(FileEndingIn({".png"}));
  app.add_option("--screenshot-after", options.screenshot_after,
                 "time of the picture after scene and poses have arrived, s")
      ->check(NumberFrom(0, kLongestRun))
      ->capture_default_str();
  app.add_flag("--fit", options.fit,
               "with --screenshot: fit all bodies into the picture before it is taken");
  app.add_option("--report", options.report,
                 "report file (JSON) for what was received, written at the end");
  app.add_option(
         "--paint", options.paint,
         "open no window: paint the pictures in this file (JSON, of a report) as PNG, then end")
      ->check(CLI::ExistingFile);
  app.add_option("--into", options.paint_into, "with --paint: folder for the pictures")
      ->default_val(".");
  CLI::Option* time = app.add_option("--time-pictures", options.time_pictures,
                                     "open no window: measure how long pictures of --scene take, "
                                     "write it to this file (JSON), then end")
                          ->needs("--scene");
  // for 'tandem doctor', which has no Qt
  app.add_option("--check-display", options.check_display)
      ->group("")
      ->check(WholeNumberFrom(0, 1'000'000));
  app.add_option("--rounds", options.rounds, "with --time-pictures: number of measurements")
      ->needs(time)
      ->check(WholeNumberFrom(1, 99))
      ->capture_default_str();
}

/// Derives the requests to the hand's controller and to the session from the options.
void FillRequests(ViewOptions& options) {
  if (options.hand.control.empty()) {
    options.hand.control = UnguessableName("window-" + std::to_string(getpid()));
  }
  options.hand.scene = options.open;
  std::istringstream words(options.peer_options);
  for (std::string word; words >> word;) options.hand.further.push_back(word);
  options.hand.session = options.join.session;
  options.hand.name = options.join.name;
  options.hand.domain = options.connection.domain;
  options.hand.interface = options.connection.interface;
  options.hand.peers = options.connection.peers;
  options.hand.external_address = options.connection.external_address;
  options.hand.port = options.connection.port;
  options.hand.secure = options.connection.secure;
  options.join.domain = options.connection.domain;
  options.join.interface = options.connection.interface;
}

/// Identifies the viewer in a secured session. Returns the exit code.
int IdentifyViewer(ViewOptions& options) {
  // a controller identifies the user that takes part
  const bool looks_on = options.open.empty() && !options.take_part && !options.attach;
  if (looks_on && !options.connection.secure.empty()) {
    const Result<PeerId> id = Identify(options.connection, Role::kViewer, options.join.name);
    if (!id) {
      SayAs("tandem-view", id.error().what);
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
      "Look on at a session, or take part in it through a controller. The window itself simulates "
      "nothing."};
  app.name("tandem-view");
  app.set_version_flag("--version", TANDEM_VERSION);
  AddHandOptions(app, options);
  AddPictureOptions(app, options);
  app.add_option("--seconds", options.seconds,
                 "time until the program ends, s; 0: when the window is closed")
      ->check(NumberFrom(0, kLongestRun));
  app.footer(
      "Exit codes: 0 ok, 1 failed, 2 usage, 3 file, 4 no display or OpenGL, 5 network, 9 "
      "security.\nWithout OpenGL the window opens and says why; a picture then shows that page, "
      "and the exit code is\n4.");
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
    return "no display: no program answers at DISPLAY " + display;
  }
  return {};
}

}  // namespace tandem
