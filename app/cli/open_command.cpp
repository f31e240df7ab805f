#include <atomic>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <memory>
#include <sstream>
#include <thread>

#include <sys/wait.h>
#include <unistd.h>

#include "app/cli/commands.h"
#include "app/common/console.h"
#include "app/common/describe_signal.h"
#include "app/common/exit_codes.h"
#include "app/common/option_checks.h"
#include "app/common/program_folders.h"
#include "app/common/scene_files.h"
#include "app/common/stop_signal.h"
#include "app/connection/connection_options.h"
#include "app/connection/hand_request.h"
#include "app/invite/given_line.h"
#include "app/invite/invitation.h"
#include "app/join/join_line.h"
#include "app/process/headless.h"
#include "collab/dds/control/control_folder.h"
#include "collab/dds/transport/domain.h"
#include "engine/realtime/private_process.h"

namespace tandem {

namespace {

constexpr std::chrono::milliseconds kWatchPeriod{20};
constexpr int kMostNewWindows = 3;

/// The options of `tandem open` and `tandem join`.
struct TakePartArguments {
  HandRequest hand;
  ConnectionOptions connection;
  std::string role = "active";
  std::string peer_options;
  bool headless = false;
  bool json = false;
  JoinLineArguments line;  // options for an invitation
};

void FillReach(TakePartArguments& arguments) {
  HandRequest& hand = arguments.hand;
  hand.domain = arguments.connection.domain;
  hand.interface = arguments.connection.interface;
  hand.peers = arguments.connection.peers;
  hand.external_address = arguments.connection.external_address;
  hand.port = arguments.connection.port;
  hand.secure = arguments.connection.secure;
  std::istringstream words(arguments.peer_options);
  for (std::string word; words >> word;) hand.further.push_back(word);
  hand.control = UnguessableName("window-" + std::to_string(getpid()));
}

std::vector<std::string> ReachWords(const HandRequest& hand) {
  std::vector<std::string> words{"--name", hand.name, "--domain", std::to_string(hand.domain)};
  const auto add = [&words](const char* option, const std::string& value) {
    if (value.empty()) return;
    words.emplace_back(option);
    words.push_back(value);
  };
  std::string peers;
  for (const std::string& peer : hand.peers) peers += (peers.empty() ? "" : ",") + peer;
  add("--session", hand.session);
  add("--interface", hand.interface);
  add("--peers", peers);
  add("--external-address", hand.external_address);
  add("--port", hand.port == 0 ? "" : std::to_string(hand.port));
  add("--secure", hand.secure);
  add("--device", hand.device);
  std::string further;
  for (const std::string& word : hand.further) further += (further.empty() ? "" : " ") + word;
  add("--peer-options", further);
  return words;
}

/// Starts the window's program, which does not end with this one. Returns its process; a negative
/// number: it cannot be started.
pid_t StartWindow(const std::vector<std::string>& words) {
  std::vector<std::string> command{(ProgramFolder() / "tandem-view").string()};
  command.insert(command.end(), words.begin(), words.end());
  std::vector<char*> argv;
  for (std::string& word : command) argv.push_back(word.data());
  argv.push_back(nullptr);
  const pid_t pid = fork();
  if (pid != 0) return pid;
  CloseOthersOnExec();
  execv(argv[0], argv.data());
  _exit(127);
}

/// Waits for a window, and passes a request to end on to it. Returns its status.
int WatchWindow(pid_t window) {
  const std::atomic<bool>& stop = StopOnSignals();
  bool reported = false;
  int status = 0;
  while (waitpid(window, &status, WNOHANG) == 0) {
    if (stop.load() && !reported) {
      kill(window, SIGTERM);
      reported = true;
    }
    if (reported) SayStillEnding();
    std::this_thread::sleep_for(kWatchPeriod);
  }
  return status;
}

/// Returns the words, each with a space before it.
std::string Joined(const std::vector<std::string>& words) {
  std::string joined;
  for (const std::string& word : words) joined += " " + word;
  return joined;
}

/// Shows the window. If it crashes, the controller goes on and a new window takes it up. Returns
/// the exit code.
int RunWindow(const std::vector<std::string>& words, const HandRequest& hand, bool has_controller) {
  std::vector<std::string> now = words;
  std::vector<std::string> take_up{"--attach", "--own", "--control", hand.control};
  if (!hand.secure.empty()) take_up.insert(take_up.end(), {"--secure", hand.secure});
  for (int windows = 1;; ++windows) {
    const pid_t window = StartWindow(now);
    if (window < 0) return Fail(kExitFailed, std::string("tandem-view: ") + std::strerror(errno));
    const int status = WatchWindow(window);
    const bool was_asked = StopOnSignals().load();
    if (WIFEXITED(status) || was_asked) {
      // one that loses its display ends by itself, and leaves its controller
      const int code = WIFEXITED(status) ? WEXITSTATUS(status) : kExitOk;
      if (has_controller && (code != kExitOk || was_asked)) EndControllerOf(hand);
      return code;
    }
    const std::string end = "the window " + DescribeSignal(WTERMSIG(status));
    const bool goes_on = has_controller && ControllerAnswers(hand);
    if (!goes_on) return Fail(kExitFailed, end);
    if (windows > kMostNewWindows) {
      return Fail(kExitFailed, end + "; its controller " + hand.control + " goes on: tandem-view" +
                                   Joined(take_up));
    }
    Say(end + "; its controller goes on, and a new window attaches to it");
    now = take_up;
    now.insert(now.end(), {"--name", hand.name});
  }
}

int RunOpen(TakePartArguments& arguments) {
  FillReach(arguments);
  const Result<Scene> scene = LoadNamedScene(arguments.hand.scene);
  if (!scene) return Fail(kExitFile, scene.error().what);
  std::error_code unknown;
  arguments.hand.scene = std::filesystem::absolute(scene->file, unknown).string();
  if (arguments.headless) return ShowHeadless(arguments.hand, arguments.json);
  std::vector<std::string> words = ReachWords(arguments.hand);
  words.insert(words.end(), {"--open", arguments.hand.scene, "--control", arguments.hand.control});
  return RunWindow(words, arguments.hand, true);
}

int RunJoin(TakePartArguments& arguments) {
  FillReach(arguments);
  std::string& scene = arguments.hand.scene;
  if (!scene.empty()) {
    const Result<Scene> loaded = LoadNamedScene(scene);
    if (!loaded) return Fail(kExitFile, loaded.error().what);
    scene = loaded->file.string();
  }
  std::vector<std::string> words = ReachWords(arguments.hand);
  if (arguments.role == "viewer") {
    if (!scene.empty()) words.insert(words.end(), {"--scene", scene});
    return RunWindow(words, arguments.hand, false);
  }
  words.insert(words.end(), {"--take-part", "--control", arguments.hand.control});
  if (!scene.empty()) words.insert(words.end(), {"--open", scene});
  return RunWindow(words, arguments.hand, true);
}

/// Joins a session by its name or by an invitation. `given`: tells which options stand in the
/// command line.
int JoinWhat(TakePartArguments& arguments, const CLI::App& given) {
  JoinLineArguments& line = arguments.line;
  std::string& named = arguments.hand.session;
  if (named == "-" || named.starts_with('@')) {
    Result<std::string> read = GivenLine(named);
    if (!read) return Fail(kExitUsage, read.error().what);
    named = *std::move(read);
    if (!IsInvitationLine(named)) return Fail(kExitUsage, ReadInvitation(named).error().what);
  }
  if (!IsInvitationLine(arguments.hand.session)) {
    for (const char* option : {"--hold", "--keys-to", "--only-keys", "--accept-scene", "--json"}) {
      if (given.count(option) == 0) continue;
      return Fail(
          kExitUsage,
          std::string(option) +
              ": applies to an invitation, which begins with tandem:// (tandem join --help)");
    }
    if (const std::string fault = WhyNoSessionName(arguments.hand.session); !fault.empty()) {
      return Fail(kExitUsage, "session: " + fault + " (tandem join --help)");
    }
    arguments.hand.further.insert(arguments.hand.further.end(), line.further.begin(),
                                  line.further.end());
    return RunJoin(arguments);
  }
  for (const char* option : {"--domain", "--peer-options"}) {
    if (given.count(option) == 0) continue;
    return Fail(kExitUsage, std::string(option) +
                                ": the invitation gives the domain; put options of tandem peer "
                                "after -- (tandem join --help)");
  }
  line.line = arguments.hand.session;
  line.name = arguments.hand.name;
  if (given.count("--role") > 0) line.role = arguments.role;
  line.scene = arguments.hand.scene;
  line.device = arguments.hand.device;
  line.connection = arguments.connection;
  return JoinByLine(line);
}

void AddCommon(CLI::App& command, TakePartArguments& arguments) {
  const char* user = std::getenv("USER");  // NOLINT(concurrency-mt-unsafe)
  arguments.hand.name = user != nullptr && *user != '\0' ? user : "user";
  command.add_option("--name", arguments.hand.name, "name that others see")->capture_default_str();
  command.add_option("--device", arguments.hand.device,
                     "device that moves the hand, as for tandem peer; default: the mouse");
  command.add_option("--peer-options", arguments.peer_options,
                     "further options of the controller (see tandem peer --help), in one text");
  AddConnectionOptions(command, arguments.connection);
}

}  // namespace

void AddOpenCommands(CLI::App& app, int& exit_code) {
  auto open = std::make_shared<TakePartArguments>();
  CLI::App* command = app.add_subcommand(
      "open", "Open a scene in a window and move its parts with the mouse, alone or with others");
  command->add_option("scene", open->hand.scene, "name of a scene, or a scene file")->required();
  AddSessionOption(
      *command, open->hand.session,
      "name of a session that others can join; default: a session on this machine alone");
  AddCommon(*command, *open);
  CLI::Option* headless = command->add_flag(
      "--headless", open->headless, "open no window: print the first picture as text, then end");
  command->add_flag("--json", open->json, "with --headless: print one JSON document")
      ->needs(headless);
  command->callback([open, &exit_code] {
    exit_code = RunOpen(*open);
  });

  auto join = std::make_shared<TakePartArguments>();
  JoinLineArguments& line = join->line;
  CLI::App* other = app.add_subcommand(
      "join", "Join a session: in a window by its name, or here by an invitation");
  other
      ->add_option("session", join->hand.session,
                   "name of a session, or the line that 'tandem invite' printed; -: read the line "
                   "from stdin, or ask for it; @FILE: read it from a file. A line of a secured "
                   "session is a secret: other users of this machine can read a command line")
      ->required();
  other->add_option("options", line.further, "after --: further options of tandem peer");
  other->add_option(
      "--scene", join->hand.scene,
      "name of a scene, or a scene file; default: the session's scene, found on this machine");
  other->add_option("--role", join->role, "active: take parts in hand; viewer: look on")
      ->check(OneOf({"active", "viewer"}))
      ->capture_default_str();
  AddCommon(*other, *join);
  other->add_option("--hold", line.hold, "with an invitation: body to take in hand");
  other->add_flag("--accept-scene", line.accept_scene,
                  "with an invitation: fetch the session's scene from a peer without asking");
  other->add_option(
      "--keys-to", line.keys_to,
      "with an invitation: new folder for your keys; default: in ~/.local/share/tandem");
  other->add_flag("--only-keys", line.only_keys, "with an invitation: get the keys, then end");
  other->add_flag(
      "--json", line.json,
      "with an invitation: print one JSON object once you are in the session or have keys");
  other->callback([join, other, &exit_code] {
    exit_code = JoinWhat(*join, *other);
  });
}

}  // namespace tandem
