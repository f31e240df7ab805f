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

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/mman.h>
#include <unistd.h>

#include "collab/dds/security/keys.h"
#include "engine/realtime/clock.h"
#include "tests/network/networks/machines.h"
#include "tests/network/networks/meeting_status.h"
#include "tests/network/running_program.h"
#include "tests/support/scratch_folder.h"

// Two machines with one path between them, and networks beside it that lead nowhere: peers meet,
// and meet again when the path changes.

namespace tandem {
namespace {

using std::chrono::milliseconds;
using testing::Machine;
using testing::MeetingStatus;

constexpr double kMeetWithin_s = 5;
constexpr double kAgainWithin_s = 10;
constexpr double kSteady_s = 1;  // both are heard for so long
constexpr std::int64_t kFreshNs = 400'000'000;

enum class Bridge : std::uint8_t { kWithoutCarrier, kWithCarrier };

struct Arrangement {
  std::array<std::string, 3> order;  // in which the interfaces are made
  Bridge bridge = Bridge::kWithoutCarrier;
  std::string path = "lan";  // the interface that leads to the other machine
  bool named = false;        // --peers
  bool secured = false;

  std::string Text() const {
    return order[0] + " " + order[1] + " " + order[2] +
           (bridge == Bridge::kWithCarrier ? ", carrier" : ", no carrier") + ", path " + path +
           (named ? ", --peers" : "") + (secured ? ", secured" : "");
  }
};

/// Returns all arrangements: six orders, the bridge, the path, --peers, keys. The path is the LAN
/// in one half and the VPN in the other, so that each path meets each of the other choices.
std::vector<Arrangement> AllArrangements() {
  std::vector<Arrangement> all;
  std::array<std::string, 3> order{"docker0", "lan", "vpn"};
  do {
    for (int i = 0; i < 16; ++i) {
      all.push_back({.order = order,
                     .bridge = (i & 1) != 0 ? Bridge::kWithCarrier : Bridge::kWithoutCarrier,
                     .path = (i & 2) != 0 ? "vpn" : "lan",
                     .named = (i & 4) != 0,
                     .secured = (i & 8) != 0});
    }
  } while (std::ranges::next_permutation(order).found);
  return all;
}

/// Keys of a session of two, made once.
class Keys {
 public:
  Keys() {
    const std::filesystem::path session = folder_.path() / "s";
    EXPECT_TRUE(MakeSessionKeys(session).has_value());
    for (std::size_t i = 0; i < 2; ++i) {
      const std::filesystem::path member = session / ("m" + std::to_string(i));
      const Result<PeerId> made =
          MakeMemberKeys(session, "m" + std::to_string(i), Role::kActive, member, 30);
      EXPECT_TRUE(made.has_value());
      peers_[i] = made ? *made : 0;
      folders_[i] = member.string();
    }
  }
  PeerId peer(std::size_t i) const { return peers_[i]; }
  const std::string& folder(std::size_t i) const { return folders_[i]; }

 private:
  ScratchFolder folder_;
  std::array<PeerId, 2> peers_{};
  std::array<std::string, 2> folders_;
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

/// Two machines, made as an arrangement says.
class TwoMachines {
 public:
  TwoMachines(const Arrangement& arrangement, const Machine& nowhere) : made_(arrangement) {
    for (const Machine* one : {&a_, &b_}) {
      if (!one->why_not().empty()) return;
    }
    for (const std::string& name : arrangement.order) good_ = good_ && Make(name, nowhere);
  }
  bool good() const { return good_; }
  const std::string& why_not() const { return a_.why_not(); }
  const Machine& a() const { return a_; }
  const Machine& b() const { return b_; }
  std::string AddressOf(int i) const {
    return (made_.path == "lan" ? "10.9.0." : "10.8.0.") + std::to_string(i + 1);
  }
  /// Gives `b` another address on the path, and takes the old one away. The kernel takes the VPN's
  /// route away with the last address.
  bool Move() const {
    if (made_.path == "lan") {
      return b_.Run("ip addr del 10.9.0.2/24 dev lan; ip addr add 10.9.0.7/24 dev lan");
    }
    return a_.Run("ip route add 10.8.0.7/32 dev vpn") &&
           b_.Run(
               "ip addr del 10.8.0.2/32 dev vpn; ip addr add 10.8.0.7/32 dev vpn; "
               "ip route replace 10.8.0.1/32 dev vpn");
  }
  /// Links the two by a new network.
  bool Add(const std::string& name, const std::string& network) const {
    return Link(a_, name, b_, name) &&
           a_.Run("ip addr add " + network + ".1/24 dev " + name + "; ip link set " + name +
                  " up") &&
           b_.Run("ip addr add " + network + ".2/24 dev " + name + "; ip link set " + name + " up");
  }
  bool Remove(const std::string& name) const { return a_.Run("ip link del " + name); }

 private:
  bool Make(const std::string& name, const Machine& nowhere) const {
    static int links = 0;
    const bool leads = name == made_.path;
    if (leads && !Link(a_, name, b_, name)) return false;
    for (int i = 0; i < 2; ++i) {
      const Machine& machine = i == 0 ? a_ : b_;
      if (name == "docker0") {
        // both machines have the same, as they come from the factory
        const bool carrier = made_.bridge == Bridge::kWithCarrier;
        if (!machine.Run(
                "ip link add docker0 type bridge; ip link add port type veth peer name "
                "inside; ip link set port master docker0; ip addr add 172.17.0.1/16 dev "
                "docker0; " +
                std::string(carrier ? "ip link set port up; ip link set inside up; " : "") +
                "ip link set docker0 up")) {
          return false;
        }
        continue;
      }
      if (!leads) {
        const std::string end = "end" + std::to_string(++links);
        if (!Link(machine, name, nowhere, end) || !nowhere.Run("ip link set " + end + " up")) {
          return false;
        }
      }
      const std::string own = std::to_string(i + 1);
      const std::string lines =
          name == "lan" ? "ip addr add 10.9.0." + own + "/24 dev lan; ip link set lan up"
                        : "ip addr add 10.8.0." + own +
                              "/32 dev vpn; ip link set vpn up; ip route add 10.8.0." +
                              std::to_string(2 - i) + "/32 dev vpn";
      if (!machine.Run(lines)) return false;
    }
    return true;
  }

  Arrangement made_;
  Machine a_;
  Machine b_;
  bool good_ = true;
};

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
    std::optional<std::int64_t> from_ns;
    while (seconds_since(since_ns) < within_s + kSteady_s) {
      if (!a.Hears() || !b.Hears()) {
        from_ns.reset();
      } else if (!from_ns) {
        from_ns = MonotonicNowNs();
      } else if (seconds_since(*from_ns) > kSteady_s) {
        return 1e-9 * static_cast<double>(*from_ns - since_ns);
      }
      std::this_thread::sleep_for(milliseconds(10));
    }
    return std::nullopt;
  }
  struct Meeting {
    std::unique_ptr<TwoMachines> machines;
    std::unique_ptr<Peer> a;
    std::unique_ptr<Peer> b;
  };
  Meeting Begin(const Arrangement& arrangement, const std::vector<std::string>& before_b = {}) {
    Meeting meeting;
    meeting.machines = std::make_unique<TwoMachines>(arrangement, nowhere_);
    EXPECT_TRUE(meeting.machines->good()) << arrangement.Text();
    const std::string session = "networks-" + std::to_string(++sessions_);
    const auto peer = [&](std::size_t i, const std::vector<std::string>& before) {
      const Machine& machine = i == 0 ? meeting.machines->a() : meeting.machines->b();
      return std::make_unique<Peer>(
          machine, session, arrangement.secured ? keys_.peer(i) : 11 + i,
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
        best_s = std::min(best_s, met[i].value_or(1e9));
        worst_s = std::max(worst_s, met[i].value_or(1e9));
        if (std::getenv("TANDEM_ALL_NETWORKS") != nullptr) {
          std::printf("%s: %.2f s\n", all[first + i].Text().c_str(), met[i].value_or(-1));
        }
      }
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
