#include <algorithm>
#include <array>
#include <csignal>
#include <functional>
#include <limits>
#include <map>

#include <dds/dds.h>
#undef restrict
#include <gtest/gtest.h>

#include "collab/dds/cyclone/partitions.h"
#include "collab/dds/cyclone/qos.h"
#include "collab/session/drop_counts.h"
#include "engine/safety/force_guard.h"
#include "tandem.h"  // idlc's
#include "tests/network/in_process_peer.h"
#include "tests/network/real_peers.h"

namespace tandem {
namespace {

using testing::InProcessPeer;
using testing::RealPeers;

constexpr std::uint32_t kDomain = 42;
constexpr PeerId kHostile = 0x99;

/// Further writers of motion of the participant of the program's own peer, which is known to the
/// session. Everything that they write in that peer's partition comes as that peer's.
class HostileWriters {
 public:
  HostileWriters() {
    EXPECT_EQ(dds_lookup_participant(kDomain, &participant_, 1), 1);
    states_ = Writer(tandem_ObjectState_desc, "state/1", {PeerPartition(kHostile)});
    linked_ = Writer(tandem_LinkedState_desc, "link/2", {PeerPartition(kHostile)});
    twofold_ = Writer(tandem_ObjectState_desc, "state/1",
                      {PeerPartition(kHostile), PeerPartition(kHostile + 1)});
  }
  ~HostileWriters() {
    for (const dds_entity_t writer : {states_, linked_, twofold_}) dds_delete(writer);
  }
  HostileWriters(const HostileWriters&) = delete;
  HostileWriters& operator=(const HostileWriters&) = delete;

  /// Tells whether each writer has a reader in another's participant.
  bool AreHeard() const { return IsHeard(states_) && IsHeard(linked_) && IsHeard(twofold_); }
  /// Writes a state of one peer alone, and one with links beside it.
  void State(const std::function<void(tandem_ObjectState&)>& spoil) {
    const tandem_ObjectState alone = Spoilt(spoil);
    dds_write(states_, &alone);
    Linked([&](tandem_LinkedState& linked) {
      spoil(linked.state);
    });
  }
  void StateOfTwo() {
    const tandem_ObjectState state = Spoilt([](tandem_ObjectState&) {});
    dds_write(twofold_, &state);
  }
  void Linked(const std::function<void(tandem_LinkedState&)>& spoil) {
    tandem_LinkedState linked{};
    linked.peer = kHostile;
    linked.state = Spoilt([](tandem_ObjectState&) {});
    linked.links.object = 1;
    linked.links.seq = linked.state.seq;
    spoil(linked);
    dds_write(linked_, &linked);
  }

 private:
  dds_entity_t Writer(const dds_topic_descriptor_t& type, const char* topic,
                      const std::vector<std::string>& partitions) const {
    const Qos qos = MakeQos(Purpose::kMotion, partitions[0]);
    std::vector<const char*> names;
    for (const std::string& partition : partitions) names.push_back(partition.c_str());
    dds_qset_partition(qos.get(), static_cast<std::uint32_t>(names.size()), names.data());
    const dds_entity_t made = dds_create_topic(participant_, &type, topic, nullptr, nullptr);
    return dds_create_writer(participant_, made, qos.get(), nullptr);
  }
  bool IsHeard(dds_entity_t writer) const {
    std::array<dds_instance_handle_t, 16> readers{};
    const int count = dds_get_matched_subscriptions(writer, readers.data(), readers.size());
    dds_instance_handle_t own = 0;
    EXPECT_EQ(dds_get_instance_handle(participant_, &own), DDS_RETCODE_OK);
    for (int k = 0; k < std::min<int>(count, readers.size()); ++k) {
      dds_builtintopic_endpoint_t* reader =
          dds_get_matched_subscription_data(writer, readers[static_cast<std::size_t>(k)]);
      if (reader == nullptr) continue;
      const bool foreign = reader->participant_instance_handle != own;
      dds_builtintopic_free_endpoint(reader);
      if (foreign) return true;
    }
    return false;
  }
  tandem_ObjectState Spoilt(const std::function<void(tandem_ObjectState&)>& spoil) {
    tandem_ObjectState state{};
    state.peer = kHostile;
    state.object = 1;
    state.epoch = 1;
    state.seq = 1'000'000 + ++seq_;
    state.pose.q[3] = 1;
    spoil(state);
    return state;
  }

  dds_entity_t participant_ = 0;
  dds_entity_t states_ = 0;
  dds_entity_t linked_ = 0;
  dds_entity_t twofold_ = 0;
  std::uint32_t seq_ = 0;
};

TEST(Hostile, InvalidSamplesAreDroppedAndCountedByReason) {
  RealPeers peers({.count = 1, .seconds = 120});
  {
    InProcessPeer known(peers.session(), kHostile, InProcessPeer::Stepped{});
    HostileWriters hostile;
    ASSERT_TRUE(known.StepUntilCoupled());
    for (int tenth = 0; tenth < 600 && !hostile.AreHeard(); ++tenth) known.StepFrames(100);
    ASSERT_TRUE(hostile.AreHeard());
    constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
    for (int i = 0; i < 20; ++i) {
      hostile.State([](tandem_ObjectState& s) {
        s.pose.p[1] = kNan;
      });
      hostile.State([](tandem_ObjectState& s) {
        s.contact.t[2] = kNan;
      });
      hostile.State([](tandem_ObjectState& s) {
        s.pose.p[0] = 1e6;
      });
      hostile.State([](tandem_ObjectState& s) {
        s.twist.v[0] = -1e4;
      });
      hostile.State([](tandem_ObjectState& s) {
        s.pose.q[3] = 2;
      });
      hostile.State([](tandem_ObjectState& s) {
        s.peer = 0x1234;
      });
      hostile.State([](tandem_ObjectState& s) {
        s.object = 77;
      });
      hostile.State([](tandem_ObjectState& s) {
        s.epoch = 1'000'000;
      });
      hostile.State([](tandem_ObjectState& s) {
        s.seq = 1;
      });
      hostile.StateOfTwo();
      hostile.Linked([](tandem_LinkedState& l) {
        l.links.count = 1000;
      });
      known.StepFrames(5);
    }
    known.StepFrames(500);
  }
  peers.peer(0).Signal(SIGTERM);
  EXPECT_EQ(peers.Wait(), std::vector<int>{0});

  const nlohmann::json report = peers.Report(0);
  ASSERT_TRUE(report.is_object());
  const nlohmann::json& drops = report.at("drops");
  // more than one of the two ways brings
  const std::map<Drop, int> least{{Drop::kNotFinite, 50},  {Drop::kHuge, 50},
                                  {Drop::kNotUnit, 25},    {Drop::kBadCount, 10},
                                  {Drop::kWrongOwner, 25}, {Drop::kNoOwner, 10},
                                  {Drop::kReplayed, 25},   {Drop::kWrongEpoch, 25}};
  for (const auto& [reason, count] : least) {
    EXPECT_GE(drops.at(NameOf(reason)).get<int>(), count) << NameOf(reason);
  }
  // the hand's spring, before anything guards the hand: bad samples do not move the body
  EXPECT_LE(report.at("peak_force_N").get<double>(), 20.0);
  const nlohmann::json& felt = report.at("felt");
  EXPECT_GT(felt.at("peak_N").get<double>(), 0.0);
  EXPECT_LE(felt.at("peak_N").get<double>(), 1.000001 * DeviceLimits{}.force);
  EXPECT_LE(felt.at("peak_Nm").get<double>(), 1.000001 * DeviceLimits{}.moment);
  EXPECT_LE(felt.at("peak_step_N").get<double>(), 1.000001 * ForceGuard::kForceStep);
}

}  // namespace
}  // namespace tandem
