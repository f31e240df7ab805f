// A program that does what no sound one does, for the tests; it has the product's message types and
// none of its checks:
//   attacker SESSION KEYS ID MODES SECONDS [MOST [INTERFACE [ACCESS-PLUGIN [DOMAIN]]]]
// KEYS is a member's folder or "-". It speaks as ID (the keys' id in a secured session), over the
// interface (else over loopback). With an access-control plug-in of its own it makes writers that
// its permissions do not name ("-": none). MODES are one or more of these, with a plus between two:
//   flood   states of one body, as fast as can be
//   keys    states of ever new bodies
//   names   presence under ever new names, as a peer and as a viewer
//   ends    ends of ever new instances, without data, on every topic
//   events  sound events of all kinds but grants, as a peer that is taken in
//   flap    comes and goes, as a peer and as a viewer
//   name    is called by bytes that are no text
//   scenes  manifests of ever new authors, some of them by writers in those authors' partitions
//   views   pictures with ever new bodies
//   lookers presence of ever new viewers
//   pieces  pieces of one sample that is said to be of a gigabyte, by a plain socket
//   packets announcements of ever new programs, by a plain socket
//   hosts   requests and goals of ever new hosts, to the controller SESSION
// It says "joined" when it can write, and is a quiet member until it gets SIGUSR1. Then it floods
// for so many seconds, or until it has sent MOST, and says "sent N". It does so for each mode; with
// a viewer's keys it is here as a viewer.
#include <algorithm>
#include <atomic>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <filesystem>
#include <functional>
#include <sstream>
#include <string>
#include <vector>

#include <dds/dds.h>
#undef restrict

#include "collab/dds/control/control_folder.h"
#include "collab/dds/control/control_packet.h"
#include "collab/dds/control/control_socket.h"
#include "collab/dds/cyclone/cyclone_log.h"
#include "collab/dds/cyclone/qos.h"
#include "collab/dds/diagnostics/attack.h"
#include "collab/dds/security/keys.h"
#include "collab/dds/security/security.h"
#include "collab/dds/transport/domain.h"
#include "collab/dds/wire/control_wire.h"
#include "tandem.h"  // idlc's
#include "tests/network/hostile/attacker_samples.h"

namespace {

using namespace tandem;
using testing::Attacker;
using Clock = std::chrono::steady_clock;

constexpr double kPatienceSeconds = 120;  // longest wait for the signal to begin

std::atomic<bool> begun{false};

int Refused(const std::string& why) {
  std::printf("refused: %s\n", why.c_str());
  return 1;
}

int Sent(std::uint64_t count) {
  std::printf("sent %llu\n", static_cast<unsigned long long>(count));
  std::fflush(stdout);
  return 0;
}

/// Says "joined". From here on a signal begins a flood.
void SayJoined() {
  std::signal(SIGUSR1, [](int) {
    begun = true;
  });
  std::puts("joined");
  std::fflush(stdout);
}

/// Calls meanwhile(), ten times a second, until the signal to begin comes.
template <typename Meanwhile>
void AwaitSignal(Meanwhile meanwhile) {
  const auto until = Clock::now() + std::chrono::duration<double>(kPatienceSeconds);
  while (!begun && Clock::now() < until) {
    meanwhile();
    dds_sleepfor(DDS_MSECS(100));
  }
  begun = false;
}

/// Floods with requests and goals of ever new hosts, over one connection.
int FloodController(const std::string& name, const FloodPlan& plan) {
  const Result<std::filesystem::path> folder = ControlFolder();
  if (!folder) return Refused(folder.error().what);
  Result<ControlConnection> controller = ControlConnection::To(*folder, name);
  if (!controller) return Refused(controller.error().what);
  SayJoined();
  AwaitSignal([] {});
  const auto end = Clock::now() + std::chrono::duration<double>(plan.seconds);
  std::uint64_t sent = 0;
  std::vector<char> ignored;
  for (std::uint64_t host = 1000; Clock::now() < end && (plan.most == 0 || sent < plan.most);
       ++host) {
    tandem_control_Request request{};
    request.host = host;
    request.number = 1;
    request.version = kControlVersion;
    request.kind = tandem_control_SNAPSHOT_RATE;
    request.value = 60;
    tandem_control_Goal goal{};
    goal.host = host;
    for (const std::vector<char>& packet : {PacketOf(request), PacketOf(goal)}) {
      if (controller->Send(packet) == ControlConnection::Outcome::kDone) ++sent;
    }
    // or the controller gives up a program that reads nothing
    while (controller->Receive(ignored) == ControlConnection::Outcome::kDone) {
    }
  }
  return Sent(sent);
}

/// Floods by one mode. `be_here` says that the attacker is here. Returns how much it sent.
std::uint64_t FloodBy(const std::string& mode, const FloodPlan& plan, std::uint32_t domain,
                      Attacker& attacker, const std::function<void()>& be_here) {
  // reliable writers wait for no one here, but leave the receivers some time; a member's are slow
  // by themselves, since they encrypt what they send
  const bool is_slow =
      !attacker.IsMember() && (mode == "scenes" || mode == "ends" || mode == "views" ||
                               mode == "lookers" || mode == "pieces");
  const auto end = Clock::now() + std::chrono::duration<double>(plan.seconds);
  auto beat = Clock::now();
  std::uint64_t sent = 0;
  for (; Clock::now() < end && (plan.most == 0 || sent < plan.most); ++sent) {
    const auto number = static_cast<std::uint32_t>(sent);
    if (mode == "flap") {
      be_here();
      dds_sleepfor(DDS_USECS(200));
      attacker.Goodbye();
      dds_sleepfor(DDS_USECS(200));
      continue;
    }
    if (Clock::now() - beat > std::chrono::milliseconds(200)) {
      be_here();
      beat = Clock::now();
    }
    if (mode == "flood") attacker.State(0);
    if (mode == "keys") attacker.State(number);
    if (mode == "names") attacker.Names(number);
    if (mode == "ends") attacker.End(number);
    if (mode == "events") attacker.Event(number);
    if (mode == "scenes") attacker.Scene(1000 + number);
    if (mode == "views") attacker.View(kMaxViewBodies * number);
    if (mode == "lookers") attacker.Looker(1000 + number);
    if (mode == "pieces") attacker.Piece(number, domain);
    if (mode == "name") dds_sleepfor(DDS_MSECS(10));
    if (is_slow && plan.most == 0) dds_sleepfor(DDS_USECS(100));
  }
  return sent;
}

std::vector<std::string> ModesIn(const std::string& text) {
  std::vector<std::string> modes;
  std::istringstream stream(text);
  for (std::string mode; std::getline(stream, mode, '+');) modes.push_back(mode);
  return modes;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 6) return 2;
  const std::vector<std::string> modes = ModesIn(argv[4]);
  const auto is_asked = [&modes](const char* mode) {
    return std::ranges::find(modes, mode) != modes.end();
  };
  const FloodPlan plan{
      .seconds = std::stod(argv[5]), .most = argc > 6 ? std::stoull(argv[6]) : 0, .per_second = 0};
  RedirectCycloneLog();
  Qos participant_qos;
  PeerId id = std::stoull(argv[3]);
  std::string key_name;
  bool looks_on = false;
  if (std::string(argv[2]) != "-") {
    const Result<MemberKeys> keys = LoadMemberKeys(argv[2]);
    if (!keys) return Refused(keys.error().what);
    Result<Qos> qos = SecureParticipantQos(*keys);
    if (!qos) return Refused(qos.error().what);
    participant_qos = *std::move(qos);
    const bool has_plugin = argc > 8 && std::string(argv[8]) != "-";
    if (has_plugin) dds_qset_prop(participant_qos.get(), "dds.sec.access.library.path", argv[8]);
    id = keys->peer;
    key_name = keys->name;
    looks_on = keys->role == Role::kViewer;
  }
  if (is_asked("hosts")) return FloodController(argv[1], plan);
  DdsOptions options;
  options.session = argv[1];
  options.interface = argc > 7 ? argv[7] : "lo";
  if (argc > 9) options.domain = static_cast<std::uint32_t>(std::stoul(argv[9]));
  if (is_asked("packets")) {
    options.peer = id;
    SayJoined();
    AwaitSignal([] {});
    const Result<std::uint64_t> sent = Flood(tandem::Attack::kPackets, options, plan);
    return sent ? Sent(*sent) : Refused(sent.error().what);
  }
  const Result<Entity> domain = CreateDomain(options);
  if (!domain) return Refused(domain.error().what);
  const Entity participant(dds_create_participant(options.domain, participant_qos.get(), nullptr));
  if (participant.get() < 0) return Refused("no participant");
  Attacker attacker(participant.get(), id, key_name);
  if (!attacker.CanSpeak()) return Refused("no writer");
  if (is_asked("events")) attacker.Learn();
  const std::string own_name = is_asked("name") ? "b\xff\xc2\x9b\xe2\x80\xae"
                                                  "d"
                                                : "vic";
  const auto be_here = [&] {
    if (looks_on) attacker.LookOn(own_name);
    // an attacker that floods as a viewer is no peer
    if (!is_asked("lookers")) attacker.Presence(own_name);
  };

  SayJoined();
  for (const std::string& mode : modes) {
    // a member costs something that is just here, which is no flood's
    AwaitSignal(be_here);
    Sent(FloodBy(mode, plan, options.domain, attacker, be_here));
  }
  return 0;
}
