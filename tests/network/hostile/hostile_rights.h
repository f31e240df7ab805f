#pragma once

#include <algorithm>
#include <array>
#include <chrono>
#include <ctime>
#include <filesystem>
#include <fstream>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <unistd.h>

#include "collab/dds/security/keys.h"
#include "collab/dds/security/permissions.h"
#include "collab/dds/security/signing.h"
#include "tests/collab/dds/child_peer.h"
#include "tests/collab/dds/live_peer.h"
#include "tests/network/running_program.h"

namespace tandem::testing {

inline constexpr PeerId kLooker = 44;
inline constexpr PeerId kMallory = 0x999;
// 1,200 attacks, or 48 that an honest peer's pace hides; a peer is lost after a second.
inline constexpr std::chrono::milliseconds kAttack{1200};
// All attacks one after the other take longer.
inline constexpr std::time_t kKeysLast = 18;  // s

/// The input from which a program reads its orders.
class Orders {
 protected:
  Orders() { EXPECT_EQ(pipe2(ends_.data(), O_CLOEXEC), 0); }
  ~Orders() {
    for (const int end : ends_) close(end);
  }
  Orders(const Orders&) = delete;
  Orders& operator=(const Orders&) = delete;

  /// Returns a name under which another program of this user can open it.
  std::string Input() const {
    return "/proc/" + std::to_string(getpid()) + "/fd/" + std::to_string(ends_[0]);
  }
  void Order(const std::string& line) const {
    EXPECT_EQ(write(ends_[1], (line + "\n").data(), line.size() + 1),
              static_cast<ssize_t>(line.size() + 1));
  }

 private:
  std::array<int, 2> ends_{-1, -1};
};

/// A peer of the product that ends when an order tells it to. After a signal it would have less
/// than a second, which it does not get of a machine that has too much to do. Then it ends by that
/// signal, and how it ends says nothing of what it went through.
class PeerWithOrders : private Orders, private Program {
 public:
  using Program::output;
  using Program::Says;
  using Program::Wait;
  PeerWithOrders(const std::vector<std::string>& command, const std::filesystem::path& output)
      : Program(command, output, Input()) {}

  void Quit() const { Order("quit"); }
  /// Orders it to end, and returns its exit code.
  std::optional<int> QuitAndWait() {
    Quit();
    return Wait(kQuitWithin);
  }
  static constexpr double kQuitWithin = 60;  // s; for an end that must come
};

/// Anna holds the ball and Ben the socket, in two processes of the product; a viewer looks on from
/// here.
class HostileRights : public ::testing::Test {
 protected:
  void TearDown() override { EndAll(); }
  void EndAll() {
    for (auto& [name, program] : programs_) program->Quit();
    for (auto& [name, program] : programs_) {
      EXPECT_EQ(program->Wait(PeerWithOrders::kQuitWithin), 0) << program->output();
    }
    programs_.clear();
  }

  void BeginPlain() { Begin(LoopbackOptions(session_, kLooker, Role::kViewer)); }
  void BeginSecured() {
    ASSERT_TRUE(MakeSessionKeys(In("keys")));
    for (const auto& [name, role] : std::map<std::string, Role>{{"anna", Role::kActive},
                                                                {"ben", Role::kActive},
                                                                {"dave", Role::kActive},
                                                                {"carl", Role::kActive},
                                                                {"vic", Role::kViewer},
                                                                {"wes", Role::kViewer}}) {
      MakeKeys(name, role);
    }
    secured_ = true;
    DdsOptions options = LoopbackOptions(session_, ids_.at("wes"), Role::kViewer);
    options.secure = In("keys-wes").string();
    Begin(options);
  }

  void MakeKeys(const std::string& name, Role role) {
    const Result<PeerId> made = MakeMemberKeys(In("keys"), name, role, In("keys-" + name));
    ASSERT_TRUE(made) << made.error().what;
    ids_[name] = *made;
  }
  /// Makes keys that are as good as others for so long, s.
  void MakeKeysFor(const std::string& name, std::time_t seconds) {
    MakeKeys(name, Role::kActive);
    const std::filesystem::path folder = In("keys-" + name);
    const PeerId id = ids_.at(name);
    std::string subject = "/" + SubjectOf(name, id);
    std::ranges::replace(subject, ',', '/');
    ASSERT_TRUE(MakeRequest(subject, folder / "identity.key", folder / "request"));
    const std::time_t until = std::time(nullptr) + seconds;
    ASSERT_TRUE(SignRequest(folder / "request", IdentityAuthority(In("keys")), false, id, until,
                            folder / "identity.pem"));
    constexpr std::time_t kDay = 86'400;  // s
    const std::string may = PermissionsXml(name, id, Role::kActive, until - kDay, until);
    ASSERT_TRUE(SignDocument(may, PermissionsAuthority(In("keys")), folder / "permissions.p7s"));
  }

  /// Starts an attacker; `outsider`: the id of one without keys.
  ChildPeer Attacker(const std::string& mode, const std::string& keys,
                     PeerId outsider = kMallory) const {
    const bool plain = keys == "-";
    return ChildPeer({TANDEM_DDS_ATTACKER, session_, plain ? "-" : In("keys-" + keys).string(),
                      plain ? "-" : TANDEM_LAX_ACCESS_CONTROL, mode,
                      std::to_string(plain ? outsider : ids_.at(keys)), keys,
                      std::to_string(ids_.at("anna"))});
  }
  /// Attacks the peer that holds the ball, with those keys and no check of the attacker's own ("-":
  /// none).
  void Attack(const std::string& mode, const std::string& keys) {
    const Recorder::Heard before = received_.Now();
    ChildPeer attacker = Attacker(mode, keys);
    EXPECT_TRUE(attacker.Says("attacking")) << mode;
    const auto ends_of = [this](const Recorder::Heard& h) {
      int ends = 0;
      for (const char* name : {"anna", "ben"}) {
        if (const auto left = h.left.find(ids_.at(name)); left != h.left.end())
          ends += left->second;
        if (const auto lost = h.lost.find(ids_.at(name)); lost != h.lost.end())
          ends += lost->second;
      }
      return ends;
    };
    EXPECT_FALSE(received_.WaitFor(
        [&](const Recorder::Heard& h) {
          return ends_of(h) != ends_of(before);
        },
        kAttack))
        << mode << ": a peer seems to be gone";
    attacker.Command("end");
    ExpectNobodyLetGo(mode);
  }

  /// Attacks by all means, and by those that an honest peer's pace hides slowly, too.
  void AttackByAllMeans(const std::string& keys) {
    for (const char* mode :
         {"claim", "claim_slowly", "claim_next_slowly", "claim_as_victim_slowly", "sit_down_slowly",
          "end", "end_slowly", "grant", "grant_here_slowly", "grant_as_victim", "look_on_as_victim",
          "offer_as_first", "offer_absurd", "state_as_victim"}) {
      Attack(mode, keys);
      if (HasFailure()) return;
    }
  }

  /// Returns how often a user was told such words of the attacker.
  int Told(const std::string& name, const std::string& words) const {
    int reported = 0;
    for (const std::string& line : LinesOf(programs_.at(name)->output())) {
      reported += line.find(words) != std::string::npos ? 1 : 0;
    }
    return reported;
  }
  nlohmann::json ReportOf(const std::string& name) {
    EXPECT_EQ(programs_.at(name)->QuitAndWait(), 0);
    programs_.erase(name);
    std::ifstream stream(In(name + ".report"));
    return nlohmann::json::parse(stream, nullptr, false);
  }

  std::unique_ptr<PeerWithOrders> Peer(const std::string& name,
                                       const std::vector<std::string>& more) const {
    std::vector<std::string> words{TANDEM_PROGRAM,
                                   "peer",
                                   "--session",
                                   session_,
                                   "--interface",
                                   "lo",
                                   "--scene",
                                   TANDEM_SCENES "/ball_and_socket.json",
                                   "--name",
                                   name,
                                   "--capacity",
                                   "20000",
                                   "--brief",
                                   "--report",
                                   In(name + ".report").string()};
    if (secured_) words.insert(words.end(), {"--secure", In("keys-" + name).string()});
    words.insert(words.end(), more.begin(), more.end());
    return std::make_unique<PeerWithOrders>(words, In(name));
  }
  std::filesystem::path In(const std::string& file) const { return folder_.path() / file; }

  /// Expects that the words of the program so far are text, without a control character or a change
  /// of direction.
  void ExpectReadable(const std::string& name) const {
    const std::string output = programs_.at(name)->output();
    EXPECT_NO_THROW(static_cast<void>(nlohmann::json(output).dump())) << "no UTF-8";
    for (const char* bad : {"\x1b", "\xc2\x9b", "\xe2\x80\xae"}) {
      EXPECT_THAT(output, ::testing::Not(::testing::HasSubstr(bad)));
    }
  }

  void ExpectNobodyLetGo(const std::string& mode) {
    using ::testing::AllOf;
    using ::testing::HasSubstr;
    using ::testing::Not;
    const Recorder::Heard now = received_.Now();
    for (const char* name : {"anna", "ben"}) {
      const PeerId id = ids_.at(name);
      EXPECT_TRUE(received_.WaitFor([&](const Recorder::Heard& h) {
        return h.views.at(id).seq > now.views.at(id).seq && Holds(h, id);
      })) << mode
          << ": " << name << " holds nothing any more";
      EXPECT_THAT(programs_.at(name)->output(),
                  AllOf(Not(HasSubstr("let go of it")), Not(HasSubstr("anna left")),
                        Not(HasSubstr("anna is lost")), Not(HasSubstr("ben left")),
                        Not(HasSubstr("ben is lost"))))
          << mode;
    }
  }

  void Begin(const DdsOptions& looks_on) {
    auto joined = JoinOverDds(looks_on, received_);
    ASSERT_TRUE(joined.has_value()) << joined.error().what;
    looker_ = *std::move(joined);
    programs_["anna"] = Peer("anna", {"--hold", "ball"});
    ASSERT_TRUE(programs_.at("anna")->Says("you hold ball")) << programs_.at("anna")->output();
    programs_["ben"] = Peer("ben", {"--hold", "socket"});
    ASSERT_TRUE(programs_.at("ben")->Says("you hold socket")) << programs_.at("ben")->output();
    for (const char* name : {"anna", "ben"}) {
      EXPECT_TRUE(received_.WaitFor([&](const Recorder::Heard& h) {
        for (const auto& [id, info] : h.infos) {
          if (info.name == name) ids_[name] = id;
        }
        return ids_.contains(name) && Holds(h, ids_[name]);
      }));
    }
  }

  static bool Holds(const Recorder::Heard& received, PeerId peer) {
    if (!received.views.contains(peer)) return false;
    const ViewFrame& view = received.views.at(peer);
    for (std::uint32_t i = 0; i < view.count; ++i) {
      if ((view.bodies[i].flags & ViewBody::kHeld) != 0) return true;
    }
    return false;
  }

  const TemporaryFolder folder_;
  bool secured_ = false;
  std::map<std::string, PeerId> ids_;
  Recorder received_;
  std::unique_ptr<Transport> looker_;

 protected:
  const std::string session_ = RandomSession();
  std::map<std::string, std::unique_ptr<PeerWithOrders>> programs_;
};

}  // namespace tandem::testing
