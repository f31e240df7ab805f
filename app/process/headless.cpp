#include "app/process/headless.h"

#include <cinttypes>
#include <cstdio>
#include <thread>

#include <nlohmann/json.hpp>

#include "app/common/console.h"
#include "app/common/exit_codes.h"
#include "app/process/child_processes.h"
#include "collab/controller/controller.h"
#include "engine/base/text/json_text.h"
#include "engine/realtime/clock.h"
#include "engine/safety/safety_state.h"

namespace tandem {

namespace {

constexpr double kAttachTry = 0.3;  // s
constexpr double kAnswerSeconds = 2;
constexpr double kLeftBehindSeconds = 0.5;  // a controller that runs answers sooner
constexpr std::int64_t kControllerPatienceNs = 60'000'000'000;
constexpr std::chrono::milliseconds kEndPatience{5000};

const char* StateName(SnapshotHand::State state) {
  switch (state) {
    case SnapshotHand::State::kEmpty:
      return "empty";
    case SnapshotHand::State::kAsking:
      return "asking";
    case SnapshotHand::State::kHolding:
      return "holding";
    case SnapshotHand::State::kRetracing:
      return "retracing";
    case SnapshotHand::State::kStopped:
      return "stopped";
  }
  return "";
}

nlohmann::json AsJson(const ControllerSnapshot& now, const std::string& control) {
  nlohmann::json bodies = nlohmann::json::array();
  for (const SnapshotBody& body : now.bodies) {
    nlohmann::json holders = nlohmann::json::array();
    for (const std::uint64_t holder : body.holders) holders.push_back(Hex(holder));
    bodies.push_back({{"name", body.name},
                      {"fixed", body.fixed},
                      {"shared", body.shared},
                      {"in_hand", body.in_hand},
                      {"holders", holders},
                      {"p_W", body.X_WB.p_W},
                      {"q_W", body.X_WB.q_W}});
  }
  nlohmann::json peers = nlohmann::json::array();
  for (const SnapshotPeer& peer : now.peers) {
    peers.push_back({{"id", Hex(peer.id)},
                     {"name", peer.name},
                     {"active", peer.active},
                     {"here", peer.here},
                     {"delay_s", peer.delay_s}});
  }
  const std::int64_t held = now.hand.body;
  return {{"controller", control},
          {"session", now.session},
          {"scene", now.scene},
          {"frame", now.frame},
          {"bodies", bodies},
          {"peers", peers},
          {"hand",
           {{"input", now.hand.input == SnapshotHand::Input::kDevice ? "device" : "mouse"},
            {"state", StateName(now.hand.state)},
            {"body", held < 0 ? nlohmann::json(nullptr)
                              : nlohmann::json(now.bodies[static_cast<std::size_t>(held)].name)},
            {"force_N", now.hand.force_N}}},
          {"contact_points", now.contact_points},
          {"safety",
           {{"state", NameOf(static_cast<SafetyState>(now.safety.state))},
            {"clamped", now.safety.clamped},
            {"slewed", now.safety.slewed},
            {"zeroed", now.safety.zeroed},
            {"expired", now.safety.expired},
            {"stops", now.safety.stops}}}};
}

void PrintSnapshot(const ControllerSnapshot& now) {
  PrintLine("%s in session %s, frame %" PRIu64 "", now.scene.c_str(), now.session.c_str(),
            now.frame);
  for (const SnapshotBody& body : now.bodies) {
    const auto& p = body.X_WB.p_W;
    PrintLine("  %-20s %s  %8.4f %8.4f %8.4f m", body.name.c_str(),
              body.fixed ? "fixed " : "moving", p[0], p[1], p[2]);
  }
}

}  // namespace

int ShowHeadless(const HandRequest& request, bool json) {
  HandRequest quiet = request;
  quiet.further.emplace_back("--brief");
  std::vector<std::string> command{(ProgramFolder() / "tandem").string()};
  for (const std::string& word : ControllerCommandLine(quiet)) command.push_back(word);
  Result<ChildProcess> peer = ChildProcess::Start(command);
  if (!peer) return Fail(kExitFailed, peer.error().what);
  const std::int64_t begun_ns = MonotonicNowNs();
  Controller::Options options;
  options.host = "tandem-open";
  options.timeout_s = kAttachTry;
  std::string why;
  while (MonotonicNowNs() - begun_ns < kControllerPatienceNs) {
    // the controller's own words are on stderr already
    if (const std::optional<int> ended = peer->Poll()) return *ended;
    Result<Controller> controller = Controller::Attach(request.control, options);
    if (!controller) {
      why = controller.error().what;
      std::this_thread::sleep_for(std::chrono::milliseconds(20));
      continue;
    }
    // loading a large scene can take minutes
    while (controller->snapshot().frame == 0) {
      if (const std::optional<int> ended = peer->Poll()) return *ended;
      if (!controller->attached())
        return Fail(kExitFailed, "the controller does not answer any more");
      controller->Wait(std::chrono::milliseconds(20));
    }
    const ControllerSnapshot now = controller->snapshot();
    if (json) {
      PrintText(JsonText(AsJson(now, request.control), 1));
    } else {
      PrintSnapshot(now);
    }
    controller->Ask(QuitRequest{}, 2);
    const std::optional<int> ended = peer->Wait(kEndPatience);
    if (!ended) Say("the controller does not end by itself: this program ends it");
    return ended.value_or(kExitFailed);
  }
  return Fail(kExitFailed, "the controller did not answer within a minute: " + why);
}

bool ControllerAnswers(const HandRequest& request) {
  Controller::Options options;
  options.host = "tandem-open";
  options.timeout_s = kAnswerSeconds;
  options.secured = !request.secure.empty();
  return static_cast<bool>(Controller::Attach(request.control, options));
}

void EndControllerOf(const HandRequest& request) {
  Controller::Options options;
  options.host = "tandem-open";
  options.timeout_s = kLeftBehindSeconds;
  Result<Controller> left = Controller::Attach(request.control, options);
  if (left) left->Ask(QuitRequest{}, kAnswerSeconds);
}

}  // namespace tandem
