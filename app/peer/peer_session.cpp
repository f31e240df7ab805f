#include "app/peer/peer_session.h"

#include <algorithm>
#include <cstdio>
#include <utility>
#include <vector>

#include "app/common/console.h"
#include "app/common/exit_codes.h"
#include "collab/dds/transport/packet_filter.h"
#include "engine/realtime/clock.h"

namespace tandem {

namespace {

constexpr std::int64_t kControlPeriodNs = 20'000'000;
constexpr std::int64_t kWaitingNs = 2'000'000'000;
constexpr std::int64_t kAloneNs = 5'000'000'000;
constexpr std::int64_t kNewcomerNs = 10'000'000'000;  // no peer is sent away after this
constexpr std::int64_t kLastFramesNs = 1'000'000'000;

std::string Seconds(double seconds) {
  char text[32];
  std::snprintf(text, sizeof text, "%g s", seconds);
  return text;
}

/// Returns a line for each peer here with its force terms.
std::vector<std::string> TermsOf(const PeerDirectory& directory) {
  std::vector<std::string> lines;
  for (const PeerDirectory::Entry& entry : directory.Entries()) {
    const bool counts = entry.presence == PeerDirectory::Presence::kHere &&
                        entry.info.role == Role::kActive && entry.refused.empty();
    if (!counts || entry.info.terms.law.empty()) continue;
    lines.push_back(
        entry.info.name + ": " + Describe(entry.info.terms) +
        (entry.terms_told.empty() ? "" : "; different from yours: " + entry.terms_told));
  }
  return lines;
}

std::size_t ActiveIn(const PeerDirectory& directory) {
  const std::vector<PeerDirectory::Entry> entries = directory.Entries();
  return static_cast<std::size_t>(
      std::ranges::count_if(entries, [](const PeerDirectory::Entry& entry) {
        return entry.presence == PeerDirectory::Presence::kHere &&
               entry.info.role == Role::kActive && entry.refused.empty();
      }));
}

/// Returns whether the device is in an emergency stop, by an order or by its own button.
bool StoppedAtDevice(const DeviceProcess& device) {
  const std::optional<DeviceTick> tick = device.Newest();
  return tick && static_cast<SafetyState>(tick->state) == SafetyState::kStopped;
}

std::vector<std::string> NamesOfPeers(const PeerDirectory& directory) {
  std::vector<std::string> names;
  for (const PeerDirectory::Entry& entry : directory.Entries()) {
    names.push_back(directory.NameOf(entry.info.peer));
  }
  return names;
}

/// Lets the handle go from what it leads, or takes it up again. Returns what to say of that.
std::string Clutch(const PeerArguments& arguments, bool pressed) {
  if (!arguments.space->Change({.clutch = pressed})) {
    return "clutch: this peer has no device process, and only a device in one has a clutch";
  }
  return pressed ? "the handle moves alone until 'clutch off'; your body stays"
                 : "the handle moves your body again";
}

}  // namespace

PeerSession::PeerSession(PeerArguments& arguments, SessionSetup& setup, PeerLoops& loops,
                         PeerControl* control, bool may_join_again, NetworkPlan plan)
    : arguments_(arguments),
      setup_(setup),
      node_(*setup.node),
      loops_(loops),
      control_(control),
      may_join_again_(may_join_again),
      opened_ns_(MonotonicNowNs()),
      network_(setup.waiting),
      name_([&node = *setup.node](PeerId peer) {
        return node.directory().NameOf(peer);
      }),
      on_hand_(control != nullptr ? control->on_hand() : PeerNode::OnHand()) {
  if (!arguments.network.empty()) network_.Start(std::move(plan), opened_ns_);
}

int PeerSession::RunUntil(const std::atomic<bool>& stop_asked) {
  std::int64_t next_ns = opened_ns_;
  while (!stop_asked.load()) {
    const std::int64_t now_ns = MonotonicNowNs();
    node_.ControlFrame(now_ns, *setup_.transport);
    PrintNotifications(now_ns);
    WatchDevice();
    loops_.TakePoses(poses_);
    TellEntered(now_ns);
    for (const std::string& line : network_.Apply(now_ns, node_.directory(), node_.inbox())) {
      Say(line);
    }
    if (const PeerTable& now = node_.peer().table().Read(); now.count > 0) table_ = now;
    TellRecorder();
    if (const std::optional<int> exit_code = TakeOrders(now_ns)) return *exit_code;
    if (const std::optional<int> exit_code = WhyEnd(now_ns)) return *exit_code;
    TellWaiting(now_ns);
    if (IsDone(now_ns)) break;
    next_ns += kControlPeriodNs;
    MachineClock().SleepUntil(next_ns);
  }
  return kExitOk;
}

void PeerSession::PrintNotifications(std::int64_t now_ns) {
  if (const std::vector<std::string> fresh = node_.TakeNotifications(on_hand_); !fresh.empty()) {
    const std::vector<std::string> names = NamesOfPeers(node_.directory());
    for (const std::string& line : fresh) notifications_.Add(SubjectOf(line, names), line);
  }
  for (const std::string& line : refusals_.TakeNotifications(PacketsJudged()))
    notifications_.Add("", line);
  if (setup_.files) {
    if (const std::string line = setup_.files->TakeNotifications(); !line.empty())
      notifications_.Add("", line);
  }
  for (const std::string& line : notifications_.Due(now_ns)) Say(line);
}

void PeerSession::WatchDevice() {
  DeviceProcess* device = setup_.device();
  if (device == nullptr) return;
  if (const std::string line = device->News(); !line.empty()) {
    Say(line);
    if (control_ != nullptr) control_->OnLine(line);
  }
  // a stop by the device's button stops the hand, too
  const bool stopped = StoppedAtDevice(*device);
  if (stopped && !std::exchange(stop_seen_, stopped)) Give({.kind = Command::Kind::kStop});
  stop_seen_ = stopped;
}

void PeerSession::TellEntered(std::int64_t now_ns) {
  if (loops_.begun() && !std::exchange(hand_told_, true)) network_.HandBegins(now_ns);
  if (arguments_.on_entered && hand_told_ && (arguments_.hold.empty() || loops_.holds())) {
    const auto tell = std::exchange(arguments_.on_entered, nullptr);
    tell({.peer = setup_.id, .name = arguments_.name, .holding = arguments_.hold});
  }
}

void PeerSession::TellRecorder() {
  if (!setup_.recorder) return;
  if (const std::string line = setup_.recorder->News(); !line.empty()) Say(line);
  for (const PeerDirectory::Entry& entry : node_.directory().Entries()) {
    setup_.recorder->Named(entry.info.peer, name_(entry.info.peer));
  }
}

std::optional<int> PeerSession::TakeOrders(std::int64_t now_ns) {
  for (const Result<std::string>& taken : orders_.TakeLines()) {
    if (taken) {
      ObeyLine(*taken, now_ns);
    } else {
      Say(taken.error().what);
    }
  }
  PeerControl::Wish wish = PeerControl::Wish::kGoOn;
  if (control_ != nullptr) wish = control_->Tick(table_);
  if (wish == PeerControl::Wish::kJoinAgain) return kJoinAgain;
  if (quit_ || wish == PeerControl::Wish::kQuit) return kExitOk;
  return std::nullopt;
}

void PeerSession::ObeyLine(const std::string& line, std::int64_t now_ns) {
  if (line == "quit") {
    quit_ = true;
  } else if (line == "help") {
    for (const std::string& row : HelpOnOrders()) Say(row);
  } else if (line == "peers") {
    for (const std::string& row : AsLines(node_.peer().table().Read(), name_)) Say(row);
    for (const std::string& row : TermsOf(node_.directory())) Say(row);
  } else if (line == "clutch" || line == "clutch off") {
    Say(Clutch(arguments_, line == "clutch"));
  } else if (PlannedNetwork::IsOrder(line)) {
    const std::size_t senders = ActiveIn(node_.directory());
    if (const auto wrong = network_.Obey(line, now_ns, senders)) Say(wrong->what);
  } else {
    ObeyOrder(line);
  }
}

void PeerSession::ObeyOrder(const std::string& line) {
  const Result<Command> order =
      ParseOrder(line, *setup_.model, node_.directory(), setup_.unequal.has_value());
  if (!order) {
    Say(order.error().what);
  } else if (!Give(*order)) {
    Say("too many commands at once: '" + line + "' is ignored: type it again");
  } else if (const std::string answer = AnswerTo(*order, *setup_.model); !answer.empty()) {
    Say(answer);
  }
}

bool PeerSession::Give(const Command& command) {
  return control_ != nullptr ? control_->Order(command) : node_.peer().commands().TryPush(command);
}

std::optional<int> PeerSession::WhyEnd(std::int64_t now_ns) {
  if (now_ns - opened_ns_ < kNewcomerNs && node_.IsBeyondLimit()) {
    return Fail(kExitNetwork, "session " + arguments_.session + " has " +
                                  std::to_string(kMaxPeers) +
                                  " active peers, the maximum: look on with 'tandem watch'");
  }
  if (now_ns - opened_ns_ < kNewcomerNs && node_.IsTwin()) {
    return Fail(kExitSecurity, arguments_.connection.secure +
                                   ": another program in this session already uses these keys: end "
                                   "that program, or use keys of your own");
  }
  if (node_.peer().telemetry().voxels_missing())
    return Fail(kExitFile, node_.world().MissingVoxelsReason());
  if (const std::string ended = setup_.transport->KeysEnd(); !ended.empty()) {
    return Fail(kExitSecurity, ended);
  }
  return WhyNotBegun(now_ns);
}

std::optional<int> PeerSession::WhyNotBegun(std::int64_t now_ns) {
  if (!loops_.begun() && may_join_again_ && Superseded(setup_)) {
    Say("another peer offered other force parameters at the same time: this peer joins again with "
        "those");
    return kJoinAgain;
  }
  if (!loops_.begun() && static_cast<double>(now_ns - opened_ns_) > 1e9 * arguments_.wait_seconds) {
    int exit_code =
        Fail(kExitNetwork, "too few others took a body within " + Seconds(arguments_.wait_seconds) +
                               ": --wait-for counts others that hold one");
    for (const PeerDirectory::Entry& entry : node_.directory().Entries()) {
      if (!entry.refused.empty()) exit_code = kExitIncompatiblePeer;
    }
    return exit_code;
  }
  return std::nullopt;
}

void PeerSession::TellWaiting(std::int64_t now_ns) {
  if (!arguments_.alone.empty() && now_ns - opened_ns_ > kAloneNs) {
    if (node_.directory().Entries().empty()) Say(arguments_.alone);
    arguments_.alone.clear();
  }
  if (!waiting_told_ && !loops_.begun() && arguments_.wait_for > 0 &&
      now_ns - opened_ns_ > kWaitingNs) {
    waiting_told_ = true;
    Say("your hand waits until others hold a body (of a shared body, the same one): --wait-for " +
        std::to_string(arguments_.wait_for) + ", for at most " + Seconds(arguments_.wait_seconds));
  }
}

bool PeerSession::IsDone(std::int64_t now_ns) {
  if (loops_.done() && done_ns_ == 0) done_ns_ = now_ns;
  // other peers' last frames still need ours: one more second
  return done_ns_ != 0 && now_ns - done_ns_ > kLastFramesNs;
}

void PeerSession::SayRest() {
  for (const std::string& line : notifications_.Rest()) Say(line);
}

}  // namespace tandem
