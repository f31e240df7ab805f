#include <algorithm>
#include <array>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <memory>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include <arpa/inet.h>
#include <fcntl.h>
#include <gtest/gtest.h>
#include <net/if.h>
#include <netinet/in.h>
#include <nlohmann/json.hpp>
#include <sys/mman.h>
#include <sys/socket.h>
#include <unistd.h>

#include "collab/dds/security/keys.h"
#include "collab/dds/transport/announcements.h"
#include "engine/realtime/clock.h"
#include "tests/network/networks/machines.h"
#include "tests/network/networks/meeting_status.h"
#include "tests/network/networks/two_machines.h"
#include "tests/network/running_program.h"
#include "tests/support/scratch_folder.h"

// Two machines with one path between them, and networks beside it that lead nowhere: peers meet,
// and meet again when the path changes.

namespace tandem {
namespace {

using std::chrono::milliseconds;
using testing::AllArrangements;
using testing::Arrangement;
using testing::Machine;
using testing::MeetingStatus;
using testing::TwoMachines;

constexpr double kMeetWithin_s = 5;
constexpr double kAgainWithin_s = 10;
constexpr double kSteady_s = 1;  // both are heard for so long
constexpr std::int64_t kFreshNs = 400'000'000;

/// Keys of a session of two and of one who asks `tandem doctor`, made once.
class Keys {
 public:
  Keys() {
    const std::filesystem::path session = folder_.path() / "s";
    EXPECT_TRUE(MakeSessionKeys(session).has_value());
    for (std::size_t i = 0; i < folders_.size(); ++i) {
      const std::filesystem::path member = session / ("m" + std::to_string(i));
      const Result<PeerId> made = MakeMemberKeys(session, "m" + std::to_string(i),
                                                 i < 2 ? Role::kActive : Role::kViewer, member, 30);
      EXPECT_TRUE(made.has_value());
      peers_[i] = made ? *made : 0;
      folders_[i] = member.string();
    }
  }
  PeerId peer(std::size_t i) const { return peers_[i]; }
  const std::string& folder(std::size_t i) const { return folders_[i]; }
  const std::string& doctors_folder() const { return folders_[2]; }

 private:
  ScratchFolder folder_;
  std::array<PeerId, 3> peers_{};
  std::array<std::string, 3> folders_;
};

/// A meeting_peer on a machine.
class Peer {
 public:
  Peer(const Machine& machine, const std::string& session, PeerId id, const std::string& keys,
       const std::string& peers, const std::vector<std::string>& before = {}) {
    file_ = (folder_.path() / "status").string();
    std::ofstream(file_) << std::string(sizeof(MeetingStatus), '\0');
    const int file = open(file_.c_str(), O_RDWR | O_CLOEXEC);
    status_ = static_cast<MeetingStatus*>(
        mmap(nullptr, sizeof(MeetingStatus), PROT_READ | PROT_WRITE, MAP_SHARED, file, 0));
    close(file);
    const auto given = [](const std::string& text) {
      return text.empty() ? std::string("-") : text;
    };
    std::vector<std::string> command = before;
    for (const std::string& word : {std::string(TANDEM_MEETING_PEER), session, std::to_string(id),
                                    given(keys), std::string("-"), given(peers), file_}) {
      command.push_back(word);
    }
    // an input that stays open
    input_ = (folder_.path() / "input").string();
    EXPECT_EQ(mkfifo(input_.c_str(), 0600), 0);
    hold_ = open(input_.c_str(), O_RDWR | O_CLOEXEC);
    program_ =
        std::make_unique<testing::Program>(machine.At(command), folder_.path() / "output", input_);
  }
  ~Peer() {
    program_->process().Signal(SIGKILL);
    munmap(status_, sizeof(MeetingStatus));
    close(hold_);
  }
  Peer(const Peer&) = delete;
  Peer& operator=(const Peer&) = delete;

  std::int64_t began_ns() const { return status_->began_ns; }
  bool Hears() const {
    return status_->here == 1 && MonotonicNowNs() - status_->arrived_ns < kFreshNs;
  }
  std::string output() const { return program_->output(); }
  void Signal(int signal) { program_->process().Signal(signal); }

 private:
  ScratchFolder folder_;
  std::string file_;
  std::string input_;
  int hold_ = -1;
  MeetingStatus* status_ = nullptr;
  std::unique_ptr<testing::Program> program_;
};

constexpr std::uint16_t kDiscoveryPort = 7400 + 250 * 42;  // the port of domain 42

sockaddr_in DiscoveryGroup() {
  sockaddr_in group{};
  group.sin_family = AF_INET;
  group.sin_port = htons(kDiscoveryPort);
  inet_pton(AF_INET, "239.255.0.1", &group.sin_addr);
  return group;
}

/// Returns a socket of a machine, which may receive what is sent to the group of discovery.
int SocketOn(const Machine& machine, bool receives) {
  int made = -1;
  machine.Within([&] {
    made = socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
    ASSERT_GE(made, 0);
    sockaddr_in group = DiscoveryGroup();
    ip_mreqn network{};
    network.imr_multiaddr = group.sin_addr;
    network.imr_ifindex = static_cast<int>(if_nametoindex(receives ? "lan" : "door"));
    ASSERT_NE(network.imr_ifindex, 0);
    if (!receives) {
      ASSERT_EQ(setsockopt(made, IPPROTO_IP, IP_MULTICAST_IF, &network, sizeof network), 0);
      return;
    }
    const int yes = 1;
    const timeval limit{.tv_sec = 5, .tv_usec = 0};
    ASSERT_EQ(setsockopt(made, SOL_SOCKET, SO_REUSEADDR, &yes, sizeof yes), 0);
    ASSERT_EQ(setsockopt(made, SOL_SOCKET, SO_RCVTIMEO, &limit, sizeof limit), 0);
    group.sin_addr.s_addr = htonl(INADDR_ANY);
    ASSERT_EQ(bind(made, reinterpret_cast<const sockaddr*>(&group), sizeof group), 0);
    ASSERT_EQ(setsockopt(made, IPPROTO_IP, IP_ADD_MEMBERSHIP, &network, sizeof network), 0);
  });
  return made;
}

/// Returns an announcement of the one program on a machine, as others hear it; empty: none came.
std::vector<std::uint8_t> AnnouncementOn(const Machine& machine) {
  const int receiver = SocketOn(machine, true);
  std::vector<std::uint8_t> packet;
  do {
    packet.resize(65536);
    const ssize_t size = recv(receiver, packet.data(), packet.size(), 0);
    packet.resize(size > 0 ? static_cast<std::size_t>(size) : 0);
  } while (!packet.empty() && !ReadAnnouncement(packet));
  close(receiver);
  return packet;
}

class Networks : public ::testing::Test {
 protected:
  void SetUp() override {
    if (!nowhere_.why_not().empty()) GTEST_SKIP() << nowhere_.why_not();
  }
  /// Waits until each hears the other for a while. Returns how long after `since_ns` that began; no
  /// value: it did not within that time.
  static std::optional<double> Together(const Peer& a, const Peer& b, std::int64_t since_ns,
                                        double within_s) {
    const auto seconds_since = [](std::int64_t ns) {
      return 1e-9 * static_cast<double>(MonotonicNowNs() - ns);
    };
    std::int64_t from_ns = 0;  // 0: not both are heard
    while (seconds_since(since_ns) < within_s + kSteady_s) {
      if (!a.Hears() || !b.Hears()) {
        from_ns = 0;
      } else if (from_ns == 0) {
        from_ns = MonotonicNowNs();
      } else if (seconds_since(from_ns) > kSteady_s) {
        return 1e-9 * static_cast<double>(from_ns - since_ns);
      }
      std::this_thread::sleep_for(milliseconds(10));
    }
    return std::nullopt;
  }
  struct Meeting {
    std::string session;
    std::unique_ptr<ScratchFolder> folder = std::make_unique<ScratchFolder>();
    std::unique_ptr<TwoMachines> machines;
    std::unique_ptr<Peer> a;
    std::unique_ptr<Peer> b;
  };
  Meeting Begin(const Arrangement& arrangement, const std::vector<std::string>& before_b = {}) {
    Meeting meeting;
    meeting.machines = std::make_unique<TwoMachines>(arrangement, nowhere_);
    EXPECT_TRUE(meeting.machines->good()) << arrangement.Text();
    meeting.session = "networks-" + std::to_string(++sessions_);
    const auto peer = [&](std::size_t i, const std::vector<std::string>& before) {
      const Machine& machine = i == 0 ? meeting.machines->a() : meeting.machines->b();
      return std::make_unique<Peer>(
          machine, meeting.session, arrangement.secured ? keys_.peer(i) : 11 + i,
          arrangement.secured ? keys_.folder(i) : std::string(),
          arrangement.named ? meeting.machines->AddressOf(i == 0 ? 1 : 0) : std::string(), before);
    };
    meeting.a = peer(0, {});
    meeting.b = peer(1, before_b);
    return meeting;
  }
  static std::int64_t BeganNs(const Meeting& meeting) {
    for (int i = 0; i < 1000 && (meeting.a->began_ns() == 0 || meeting.b->began_ns() == 0); ++i) {
      std::this_thread::sleep_for(milliseconds(10));
    }
    return std::max(meeting.a->began_ns(), meeting.b->began_ns());
  }
  static void ExpectQuiet(const Meeting& meeting, const std::string& what) {
    for (const Peer* peer : {meeting.a.get(), meeting.b.get()}) {
      EXPECT_EQ(peer->output().find("retcode"), std::string::npos) << what << peer->output();
      const std::string output = peer->output();
      EXPECT_LE(std::ranges::count(output, '\n'), 4) << what << output;
    }
  }
  /// Runs `tandem doctor` on the first machine of a meeting. It is to find both peers, and where
  /// the other's address is given, by which interface that is.
  void ExpectDoctorFindsTheOther(const Meeting& meeting, const Arrangement& arrangement) {
    std::vector<std::string> words{TANDEM_PROGRAM, "doctor", "--session", meeting.session,
                                   "--json"};
    const std::string other = meeting.machines->AddressOf(1);
    if (arrangement.named) words.insert(words.end(), {"--peers", other});
    if (arrangement.secured) words.insert(words.end(), {"--secure", keys_.doctors_folder()});
    testing::Program doctor(meeting.machines->a().At(words), meeting.folder->path() / "output");
    EXPECT_EQ(doctor.Wait(), 0) << arrangement.Text() << doctor.output();
    const auto findings = nlohmann::json::parse(doctor.output(), nullptr, false);
    ASSERT_TRUE(findings.is_array()) << arrangement.Text() << doctor.output();
    const auto found = [&findings](const std::string& check) {
      for (const nlohmann::json& one : findings) {
        if (one.at("check") == check) return one.at("found").get<std::string>();
      }
      return std::string();
    };
    const std::string session = found("session " + meeting.session);
    const std::string name = arrangement.secured ? "m1" : "peer 12";
    EXPECT_NE(session.find(name), std::string::npos) << arrangement.Text() << doctor.output();
    if (!arrangement.named) return;
    EXPECT_NE(found("path to " + other).find("by interface " + arrangement.path), std::string::npos)
        << arrangement.Text() << doctor.output();
  }
  /// Begins several meetings and expects each to come about in time.
  void ExpectAllMeet(const std::vector<Arrangement>& all, std::size_t at_once) {
    double best_s = 1e9;
    double worst_s = 0;
    for (std::size_t first = 0; first < all.size(); first += at_once) {
      const std::size_t end = std::min(all.size(), first + at_once);
      std::vector<Meeting> meetings(end - first);
      std::vector<std::optional<double>> met(meetings.size());
      std::vector<std::jthread> waits;
      for (std::size_t i = 0; i < meetings.size(); ++i) {
        meetings[i] = Begin(all[first + i]);
        // watched from now on, while the next ones begin
        waits.emplace_back([&, i] {
          met[i] = Together(*meetings[i].a, *meetings[i].b, BeganNs(meetings[i]), kMeetWithin_s);
        });
      }
      waits.clear();
      for (std::size_t i = 0; i < meetings.size(); ++i) {
        EXPECT_TRUE(met[i]) << all[first + i].Text() << "\n"
                            << meetings[i].a->output() << meetings[i].b->output();
        ExpectQuiet(meetings[i], all[first + i].Text());
        waits.emplace_back([&, i] {
          ExpectDoctorFindsTheOther(meetings[i], all[first + i]);
        });
        best_s = std::min(best_s, met[i].value_or(1e9));
        worst_s = std::max(worst_s, met[i].value_or(1e9));
        if (std::getenv("TANDEM_ALL_NETWORKS") != nullptr) {
          std::printf("%s: %.2f s\n", all[first + i].Text().c_str(), met[i].value_or(-1));
        }
      }
      waits.clear();
    }
    RecordProperty("best_s", std::to_string(best_s));
    RecordProperty("worst_s", std::to_string(worst_s));
  }
  /// Changes something in a session, and expects both together again in time.
  void ExpectTogetherAfter(Arrangement arrangement, const std::string& what,
                           const std::function<bool(const Meeting&)>& change) {
    for (const bool secured : {false, true}) {
      arrangement.secured = secured;
      const Meeting meeting = Begin(arrangement);
      ASSERT_TRUE(Together(*meeting.a, *meeting.b, BeganNs(meeting), kMeetWithin_s))
          << what << meeting.a->output() << meeting.b->output();
      ASSERT_TRUE(change(meeting)) << what;
      const auto again = Together(*meeting.a, *meeting.b, MonotonicNowNs(), kAgainWithin_s);
      EXPECT_TRUE(again) << what << (secured ? ", secured" : "") << "\n"
                         << meeting.a->output() << meeting.b->output();
      ExpectQuiet(meeting, what);
      RecordProperty(secured ? "secured_s" : "plain_s", std::to_string(again.value_or(-1)));
    }
  }

  Machine nowhere_;
  Keys keys_;
  int sessions_ = 0;
};

TEST_F(Networks, PeersMeetInEveryArrangement) {
  std::vector<Arrangement> all = AllArrangements();
  if (std::getenv("TANDEM_ALL_NETWORKS") == nullptr) {
    // one of seven, in which each choice is met: seven and the other numbers have no divisor
    std::vector<Arrangement> some;
    for (std::size_t i = 0; i < all.size(); i += 7) some.push_back(all[i]);
    all = some;
  }
  ExpectAllMeet(all, 7);
}

TEST_F(Networks, PeersMeetAgainAtAnotherAddress) {
  ExpectTogetherAfter({.order = {"docker0", "vpn", "lan"}}, "address changed",
                      [](const Meeting& meeting) {
                        return meeting.machines->Move();
                      });
}

TEST_F(Networks, NamedPeersMeetAgainAtAnotherAddress) {
  ExpectTogetherAfter({.order = {"docker0", "lan", "vpn"}, .path = "vpn", .named = true},
                      "address changed", [](const Meeting& meeting) {
                        return meeting.machines->Move();
                      });
}

TEST_F(Networks, PeersMeetByAnInterfaceInThePlaceOfAnother) {
  ExpectTogetherAfter(
      {.order = {"docker0", "lan", "vpn"}}, "another interface", [](const Meeting& meeting) {
        return meeting.machines->Remove("lan") && meeting.machines->Add("wifi", "192.168.7");
      });
}

TEST_F(Networks, InterfaceThatAppearsLaterIsUsed) {
  const Arrangement arrangement{.order = {"docker0", "lan", "vpn"}};
  const Meeting meeting = Begin(arrangement);
  ASSERT_TRUE(meeting.machines->Remove("lan"));
  BeganNs(meeting);
  std::this_thread::sleep_for(milliseconds(300));
  ASSERT_TRUE(meeting.machines->Add("wifi", "192.168.7"));
  EXPECT_TRUE(Together(*meeting.a, *meeting.b, MonotonicNowNs(), kAgainWithin_s));
}

TEST_F(Networks, InterfaceThatIsNotUsedComesAndGoesUnnoticed) {
  const Meeting meeting = Begin({.order = {"docker0", "lan", "vpn"}});
  ASSERT_TRUE(Together(*meeting.a, *meeting.b, BeganNs(meeting), kMeetWithin_s));
  const std::string made =
      "ip link add idle type veth peer name idle2; ip addr add 192.168.9.1/24 dev idle; ip link "
      "set idle up; ip link set idle2 up";
  ASSERT_TRUE(meeting.machines->b().Run(made));
  const std::int64_t until_ns = MonotonicNowNs() + 3'000'000'000;
  bool removed = false;
  while (MonotonicNowNs() < until_ns) {
    ASSERT_TRUE(meeting.a->Hears() && meeting.b->Hears());
    if (!removed && MonotonicNowNs() > until_ns - 1'500'000'000) {
      ASSERT_TRUE(meeting.machines->b().Run("ip link del idle"));
      removed = true;
    }
    std::this_thread::sleep_for(milliseconds(10));
  }
}

// A stranger next door hears a member's announcements, and sends them again from its own address.
// The newcomer is on both networks, and hears the stranger first.
TEST_F(Networks, MembersMeetThoughAStrangerAnnouncesOneOfThemFirst) {
  const Arrangement arrangement{.order = {"docker0", "lan", "vpn"}, .secured = true};
  Meeting meeting = Begin(arrangement);
  const Machine stranger;
  ASSERT_TRUE(Link(meeting.machines->b(), "door", stranger, "door"));
  ASSERT_TRUE(
      meeting.machines->b().Run("ip addr add 192.168.7.2/24 dev door; ip link set door up"));
  ASSERT_TRUE(stranger.Run("ip addr add 192.168.7.66/24 dev door; ip link set door up"));
  const auto ends = [&meeting] {
    meeting.b.reset();
    std::this_thread::sleep_for(milliseconds(3000));  // until the member has forgotten it
  };
  ASSERT_TRUE(Together(*meeting.a, *meeting.b, BeganNs(meeting), kMeetWithin_s));
  ends();

  const std::vector<std::uint8_t> announcement = AnnouncementOn(meeting.machines->a());
  ASSERT_FALSE(announcement.empty());
  const int sender = SocketOn(stranger, false);
  std::jthread sending([&](const std::stop_token& stop) {
    const sockaddr_in group = DiscoveryGroup();
    while (!stop.stop_requested()) {
      sendto(sender, announcement.data(), announcement.size(), 0,
             reinterpret_cast<const sockaddr*>(&group), sizeof group);
      std::this_thread::sleep_for(milliseconds(2));
    }
  });
  meeting.a->Signal(SIGSTOP);  // so that the stranger is heard first
  meeting.b = std::make_unique<Peer>(meeting.machines->b(), meeting.session, keys_.peer(1),
                                     keys_.folder(1), std::string());
  BeganNs(meeting);
  std::this_thread::sleep_for(milliseconds(100));
  meeting.a->Signal(SIGCONT);
  const auto met = Together(*meeting.a, *meeting.b, MonotonicNowNs(), 20);
  EXPECT_TRUE(met) << meeting.a->output() << meeting.b->output();
  RecordProperty("met_s", std::to_string(met.value_or(-1)));
  sending.request_stop();
  sending.join();
  close(sender);
}

// The sleeper's clocks of the day and of the time with sleep are ten minutes ahead afterwards.
TEST_F(Networks, PeersMeetAgainAfterOneMachineSlept) {
#ifndef TANDEM_STEPPED_CLOCK
  GTEST_SKIP() << "a sanitizer's library must be the first, so no clock can be loaded before it";
#else
  ScratchFolder folder;
  for (const bool secured : {false, true}) {
    const std::string step = (folder.path() / "step").string();
    const auto set = [&step](std::int64_t ns) {
      const int file = open(step.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0600);
      EXPECT_EQ(pwrite(file, &ns, sizeof ns, 0), static_cast<ssize_t>(sizeof ns));
      close(file);
    };
    set(0);
    const Meeting meeting = Begin({.order = {"docker0", "lan", "vpn"}, .secured = secured},
                                  {"env", "LD_PRELOAD=" TANDEM_STEPPED_CLOCK,
                                   "STEPPED_CLOCK=" + step, "STEPPED_CLOCK_SLEEPS=1"});
    ASSERT_TRUE(Together(*meeting.a, *meeting.b, BeganNs(meeting), kMeetWithin_s))
        << meeting.b->output();
    meeting.b->Signal(SIGSTOP);
    std::this_thread::sleep_for(milliseconds(2500));
    set(600'000'000'000);
    meeting.b->Signal(SIGCONT);
    const auto again = Together(*meeting.a, *meeting.b, MonotonicNowNs(), kAgainWithin_s);
    EXPECT_TRUE(again) << secured << meeting.a->output() << meeting.b->output();
    RecordProperty(secured ? "secured_s" : "plain_s", std::to_string(again.value_or(-1)));
  }
#endif
}

}  // namespace
}  // namespace tandem
