#include <functional>
#include <limits>

#include <dds/dds.h>
#undef restrict
#include <gtest/gtest.h>

#include "collab/dds/partitions.h"
#include "collab/dds/qos.h"
#include "collab/drop_counts.h"
#include "engine/haptics/force_guard.h"
#include "tandem.h"  // idlc's
#include "tests/network/own_peer.h"
#include "tests/network/real_peers.h"

namespace tandem {
namespace {

using testing::OwnPeer;
using testing::RealPeers;

constexpr std::uint32_t kDomain = 42;
constexpr PeerId kHostile = 0x99;

/// Writers of motion of a participant beside that of the program's own peer, which is known to the
/// session: whatever it writes in that peer's partition comes as that peer's.
class HostileWriters {
 public:
  HostileWriters() : participant_(dds_create_participant(kDomain, nullptr, nullptr)) {
    states_ = Writer(tandem_ObjectState_desc, "state/1", {PeerPartition(kHostile)});
    links_ = Writer(tandem_CouplingLinks_desc, "link/1", {PeerPartition(kHostile)});
    twofold_ = Writer(tandem_ObjectState_desc, "state/1",
                      {PeerPartition(kHostile), PeerPartition(kHostile + 1)});
  }
  ~HostileWriters() { dds_delete(participant_); }
  HostileWriters(const HostileWriters&) = delete;
  HostileWriters& operator=(const HostileWriters&) = delete;

  void State(const std::function<void(tandem_ObjectState&)>& spoil) { Write(states_, spoil); }
  void StateOfTwo() {
    Write(twofold_, [](tandem_ObjectState&) {});
  }
  void Links(const std::function<void(tandem_CouplingLinks&)>& spoil) {
    tandem_CouplingLinks links{};
    links.peer = kHostile;
    links.object = 1;
    links.seq = 1'000'000 + ++seq_;
    spoil(links);
    dds_write(links_, &links);
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
  void Write(dds_entity_t writer, const std::function<void(tandem_ObjectState&)>& spoil) {
    tandem_ObjectState state{};
    state.peer = kHostile;
    state.object = 1;
    state.epoch = 1;
    state.seq = 1'000'000 + ++seq_;
    state.pose.q[3] = 1;
    spoil(state);
    dds_write(writer, &state);
  }

  dds_entity_t participant_;
  dds_entity_t states_ = 0;
  dds_entity_t links_ = 0;
  dds_entity_t twofold_ = 0;
  std::uint32_t seq_ = 0;
};

TEST(Hostile, SamplesThatNoSoundPeerSendsAreDroppedAndCountedByReason) {
  RealPeers peers({.count = 1, .seconds = 8});
  {
    OwnPeer known(peers.session(), kHostile, OwnPeer::Stepped{});
    HostileWriters hostile;
    known.StepFrames(2000);
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
      hostile.Links([](tandem_CouplingLinks& l) {
        l.count = 1000;
      });
      known.StepFrames(5);
    }
    known.StepFrames(500);
  }
  EXPECT_EQ(peers.Wait(), std::vector<int>{0});

  const nlohmann::json report = peers.Report(0);
  ASSERT_TRUE(report.is_object());
  const nlohmann::json& drops = report.at("drops");
  for (const Drop reason :
       {Drop::kNotFinite, Drop::kHuge, Drop::kNotUnit, Drop::kBadCount, Drop::kWrongOwner,
        Drop::kNoOwner, Drop::kReplayed, Drop::kWrongEpoch}) {
    EXPECT_GE(drops.at(NameOf(reason)).get<int>(), 10) << NameOf(reason);
  }
  const nlohmann::json& felt = report.at("felt");
  EXPECT_GT(felt.at("peak_N").get<double>(), 0.0);
  EXPECT_LE(felt.at("peak_N").get<double>(), 1.000001 * DeviceLimits{}.force);
  EXPECT_LE(felt.at("peak_Nm").get<double>(), 1.000001 * DeviceLimits{}.moment);
  EXPECT_LE(felt.at("peak_step_N").get<double>(), 1.000001 * ForceGuard::kForceStep);
}

}  // namespace
}  // namespace tandem
