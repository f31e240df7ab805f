#include "collab/dds/transport/dds_transport.h"

#include <cstdlib>
#include <mutex>
#include <set>
#include <thread>

#include <arpa/inet.h>
#include <gmock/gmock.h>
#include <pthread.h>
#include <sys/socket.h>
#include <unistd.h>

#include "collab/dds/cyclone/dds_api.h"
#include "collab/dds/transport/receive_thread.h"
#include "tests/collab/dds/child_peer.h"
#include "tests/collab/dds/live_peer.h"

namespace tandem::testing {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

constexpr PeerId kHere = 0xABCDEF0123456789;
constexpr PeerId kThere = 22;

std::unique_ptr<LivePeer> Join(const DdsOptions& options, Inbox& inbox) {
  auto transport = JoinOverDds(options, inbox);
  EXPECT_TRUE(transport.has_value()) << transport.error().what;
  if (!transport) return nullptr;
  return std::make_unique<LivePeer>(*std::move(transport), options, options.peer);
}

// Messages of an active peer reach another as they were said. Every field is set, none to its
// default.
TEST(DdsTransport, ActivePeersHearOneAnother) {
  const std::string session = RandomSession();
  ChildPeer there(session, kThere);
  Recorder received;
  const auto here = Join(LoopbackOptions(session, kHere, Role::kActive), received);
  ASSERT_NE(here, nullptr);

  ASSERT_TRUE(received.WaitFor([](const Recorder::Heard& h) {
    return h.states.contains(kThere) && h.links.contains(kThere) && h.infos.contains(kThere) &&
           !h.scenes.empty();
  }));
  const Recorder::Heard h = received.Now();
  const ObjectState& state = h.states.at(kThere);
  const ObjectState output = SampleState(kThere, 0);
  EXPECT_EQ(state.object, output.object);
  EXPECT_EQ(state.epoch, output.epoch);
  EXPECT_EQ(state.flags, output.flags);
  EXPECT_EQ(state.X_WB.p, output.X_WB.p);
  EXPECT_EQ(state.X_WB.q.coeffs(), output.X_WB.q.coeffs());
  EXPECT_EQ(h.links.at(kThere).count, 2U);
  EXPECT_EQ(h.links.at(kThere).entries[0].echo_ns, 123456789);
  EXPECT_EQ(h.infos.at(kThere).name, "Ada");
  EXPECT_THAT(h.infos.at(kThere).claims,
              ::testing::ElementsAre(Claim{7, 2, true}, Claim{9, 3, false}));
  EXPECT_EQ(h.scenes.front().content_hash, SampleScene(kThere).content_hash);
  EXPECT_EQ(h.scenes.front().file, SampleScene(kThere).file);
  EXPECT_TRUE(h.views.empty());

  const std::string id = std::to_string(kHere);
  EXPECT_TRUE(there.Says("state " + id));
  EXPECT_TRUE(there.Says("links " + id));
  EXPECT_TRUE(there.Says("info " + id));
  EXPECT_TRUE(there.Says("scene 42"));
  EXPECT_FALSE(received.Now().infos.contains(kHere)) << "a peer does not hear itself";
}

// Ports are fixed and one address alone is named, so that nothing is ever sent but to the address
// of --peers.
TEST(DdsTransport, PeersNamedByAddressMeetWithoutMulticast) {
  const std::string session = RandomSession();
  const std::uint16_t here_port = FreePortPair();
  const std::uint16_t there_port = FreePortPair();
  ChildPeer there(session, kThere, {.port = there_port, .peer_port = here_port});
  Recorder received;
  DdsOptions options = LoopbackOptions(session, kHere, Role::kActive);
  options.port = here_port;
  options.peers = {"127.0.0.1:" + std::to_string(there_port)};
  const auto here = Join(options, received);
  ASSERT_NE(here, nullptr);
  EXPECT_TRUE(received.WaitFor([](const Recorder::Heard& h) {
    return h.states.contains(kThere) && h.infos.contains(kThere);
  }));
  EXPECT_TRUE(there.Says("state " + std::to_string(kHere)));
}

TEST(DdsTransport, PortInUseIsNamed) {
  const int other = socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  ASSERT_EQ(bind(other, reinterpret_cast<sockaddr*>(&address), sizeof address), 0);
  socklen_t size = sizeof address;
  getsockname(other, reinterpret_cast<sockaddr*>(&address), &size);
  Recorder received;
  DdsOptions options = LoopbackOptions(RandomSession(), kHere, Role::kActive);
  options.port = ntohs(address.sin_port);
  const auto joined = JoinOverDds(options, received);
  close(other);
  ASSERT_FALSE(joined.has_value());
  EXPECT_THAT(joined.error().what, HasSubstr(std::to_string(options.port) + " is taken"));
}

TEST(DdsTransport, LateJoinersGetTheSceneAndThePeers) {
  const std::string session = RandomSession();
  ChildPeer early(session, kThere);
  ASSERT_TRUE(early.Says("ready"));
  Recorder received;
  const auto late = JoinOverDds(LoopbackOptions(session, kHere, Role::kViewer), received);
  ASSERT_TRUE(late.has_value());
  EXPECT_TRUE(received.WaitFor([](const Recorder::Heard& h) {
    return h.infos.contains(kThere) && !h.scenes.empty();
  }));
}

TEST(DdsTransport, ViewerReceivesViewsAndNoStates) {
  const std::string session = RandomSession();
  ChildPeer active(session, kThere);
  Recorder received;
  const auto viewer = Join(LoopbackOptions(session, kHere, Role::kViewer), received);
  ASSERT_NE(viewer, nullptr);
  ASSERT_TRUE(received.WaitFor([](const Recorder::Heard& h) {
    return h.views.contains(kThere) && h.views.at(kThere).seq > 100 && h.infos.contains(kThere);
  }));
  EXPECT_TRUE(received.Now().states.empty());
  EXPECT_TRUE(received.Now().links.empty());
  EXPECT_EQ(received.Now().views.at(kThere).bodies[0].object, 7U);
  // the viewer announces itself, and is heard as one
  EXPECT_TRUE(active.Says("info " + std::to_string(kHere)));
}

// Topics that each participant of the session subscribes to, as DDS itself tells an onlooker.
using Subscriptions = std::map<dds_instance_handle_t, std::set<std::string>>;

Subscriptions SubscriptionsSeenBy(dds_entity_t reader) {
  Subscriptions topics;
  std::array<void*, 100> samples{};
  std::array<dds_sample_info_t, 100> infos{};
  const auto read = dds_read(reader, samples.data(), infos.data(), samples.size(), samples.size());
  for (std::size_t i = 0; read > 0 && i < static_cast<std::size_t>(read); ++i) {
    const auto* endpoint = static_cast<dds_builtintopic_endpoint_t*>(samples[i]);
    if (infos[i].valid_data)
      topics[endpoint->participant_instance_handle].insert(endpoint->topic_name);
  }
  if (read > 0) dds_return_loan(reader, samples.data(), read);
  return topics;
}

TEST(DdsTransport, AViewerSubscribesToNoneOfTheFastTopics) {
  const std::string session = RandomSession();
  Recorder received;
  const auto active = Join(LoopbackOptions(session, kHere, Role::kActive), received);
  ASSERT_NE(active, nullptr);
  const Entity onlooker(dds_create_participant(DdsOptions().domain, nullptr, nullptr));
  const dds_entity_t reader =
      dds_create_reader(onlooker.get(), DDS_BUILTIN_TOPIC_DCPSSUBSCRIPTION, nullptr, nullptr);
  ASSERT_GT(reader, 0);
  ChildPeer viewer(session, kThere, {Role::kViewer, 0});
  ChildPeer other(session, 33);
  ASSERT_TRUE(viewer.Says("view " + std::to_string(kHere)));
  ASSERT_TRUE(received.WaitFor([](const Recorder::Heard& h) {
    return h.infos.contains(kThere) && h.states.contains(33);
  }));

  // a participant tells of its topics one by one
  const std::set<std::string> of_viewer{"view/1", "peer_info", "viewer_info", "scene"};
  Subscriptions seen;
  int viewers = 0;
  int active_peers = 0;
  for (int exact_queries = 0; exact_queries < 1000 && (viewers != 1 || active_peers != 2);
       ++exact_queries) {
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
    seen = SubscriptionsSeenBy(reader);
    viewers = active_peers = 0;
    for (const auto& [participant, topics] : seen) {
      viewers += topics == of_viewer ? 1 : 0;
      active_peers += topics.contains("state/1") ? 1 : 0;
    }
  }
  EXPECT_EQ(viewers, 1) << ::testing::PrintToString(seen);
  EXPECT_EQ(active_peers, 2) << ::testing::PrintToString(seen);
}

/// Notes which threads tell what is heard of motion.
class ThreadNotes : public Recorder {
 public:
  void OnState(const ObjectState& state, std::int64_t arrival_ns) override {
    Note();
    Recorder::OnState(state, arrival_ns);
  }
  void OnLinks(const CouplingLinks& links, std::int64_t arrival_ns) override {
    Note();
    Recorder::OnLinks(links, arrival_ns);
  }
  std::set<pthread_t> threads;
  std::set<int> policies;

 private:
  void Note() {
    const std::scoped_lock lock(mutex_);
    threads.insert(pthread_self());
    sched_param parameters{};
    int policy = 0;
    pthread_getschedparam(pthread_self(), &policy, &parameters);
    policies.insert(policy);
  }
  std::mutex mutex_;
};

TEST(DdsTransport, OneThreadReceivesAllMotionInRealTime) {
  const std::string session = RandomSession();
  ThreadNotes received;
  auto here = Join(LoopbackOptions(session, kHere, Role::kActive), received);
  ASSERT_NE(here, nullptr);
  {
    ChildPeer one(session, kThere);
    ChildPeer other(session, 33);
    ASSERT_TRUE(received.WaitFor([](const Recorder::Heard& h) {
      return h.links.contains(kThere) && h.links.at(kThere).seq > 300 && h.links.contains(33) &&
             h.links.at(33).seq > 300;
    }));
  }
  here.reset();  // ends the calls
  EXPECT_EQ(received.threads.size(), 1U);
  EXPECT_EQ(received.policies, std::set<int>{RealTimeIsPermitted() ? SCHED_FIFO : SCHED_OTHER});
}

TEST(DdsTransport, SessionsAreIsolated) {
  const std::string session = RandomSession();
  ChildPeer stranger(session + " & <more>", kThere);
  ASSERT_TRUE(stranger.Says("ready"));
  Recorder received;
  const auto here = Join(LoopbackOptions(session, kHere, Role::kActive), received);
  ASSERT_NE(here, nullptr);
  // a peer of our own session that comes later than the stranger is heard in both directions
  ChildPeer friendly(session, 33);
  ASSERT_TRUE(received.WaitFor([](const Recorder::Heard& h) {
    return h.infos.contains(33) && h.states.contains(33) && h.states.at(33).seq > 500;
  }));
  ASSERT_TRUE(friendly.Says("state " + std::to_string(kHere)));
  EXPECT_FALSE(received.Now().infos.contains(kThere));
  EXPECT_FALSE(received.Now().states.contains(kThere));
  EXPECT_FALSE(stranger.Says("info 33", std::chrono::milliseconds(0)));
}

TEST(DdsTransport, PeerIsHeardOnlyInItsOwnPartition) {
  const std::string session = RandomSession();
  Recorder received;
  const auto here = Join(LoopbackOptions(session, kHere, Role::kActive), received);
  ASSERT_NE(here, nullptr);
  // the liar says each thing first in peer 99's name, then in its own
  ChildPeer liar(session, kThere, {Role::kActive, 99});
  ASSERT_TRUE(received.WaitFor([](const Recorder::Heard& h) {
    return h.states.contains(kThere) && h.states.at(kThere).seq > 200 && h.links.contains(kThere);
  }));
  EXPECT_FALSE(received.Now().states.contains(99));
  EXPECT_FALSE(received.Now().links.contains(99));
}

TEST(DdsTransport, UnknownInterfaceIsReportedInOneLine) {
  DdsOptions options = LoopbackOptions(RandomSession(), kHere, Role::kActive);
  options.interface = "nosuch0";
  Recorder received;
  ::testing::internal::CaptureStderr();
  const auto joined = JoinOverDds(options, received);
  const std::string printed = ::testing::internal::GetCapturedStderr();
  ASSERT_FALSE(joined.has_value());
  EXPECT_THAT(joined.error().what, HasSubstr("no network interface 'nosuch0'"));
  EXPECT_THAT(joined.error().what, HasSubstr("lo"));
  EXPECT_THAT(joined.error().what, Not(HasSubstr("\n")));
  EXPECT_EQ(printed, "");
}

// RTPS: port 7400 + 250 domain + 10 + 2 index, for each index that a participant may have.
TEST(DdsTransport, MissingFreePortIsReportedInOneLine) {
  DdsOptions options = LoopbackOptions(RandomSession(), kHere, Role::kActive);
  options.domain = 199;
  std::vector<int> sockets;
  for (int index = 0; index <= 60; ++index) {
    sockets.push_back(socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0));
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_port = htons(static_cast<std::uint16_t>(7400 + 250 * 199 + 10 + 2 * index));
    bind(sockets.back(), reinterpret_cast<sockaddr*>(&address), sizeof address);
  }
  Recorder received;
  ::testing::internal::CaptureStderr();
  const auto joined = JoinOverDds(options, received);
  const std::string printed = ::testing::internal::GetCapturedStderr();
  for (const int one : sockets) close(one);
  ASSERT_FALSE(joined.has_value());
  EXPECT_THAT(joined.error().what, HasSubstr("199"));
  EXPECT_THAT(joined.error().what, HasSubstr("port"));
  EXPECT_THAT(joined.error().what, Not(HasSubstr("\n")));
  EXPECT_EQ(printed, "");
}

TEST(DdsTransport, ProcessJoinsADomainOnlyOnceAtATime) {
  const DdsOptions options = LoopbackOptions(RandomSession(), kHere, Role::kActive);
  Recorder received;
  {
    const auto first = JoinOverDds(options, received);
    ASSERT_TRUE(first.has_value());
    const auto second = JoinOverDds(options, received);
    ASSERT_FALSE(second.has_value());
    EXPECT_THAT(second.error().what, HasSubstr("already"));
  }
  EXPECT_TRUE(JoinOverDds(options, received).has_value());
}

// The variable would keep both from joining at all, because Cyclone refuses elements that it does
// not know.
TEST(DdsTransport, EnvironmentConfigurationIsIgnoredWithANotice) {
  setenv("CYCLONEDDS_URI", "<CycloneDDS><Domain Id=\"any\"><NoSuchThing/></Domain></CycloneDDS>",
         1);
  const std::string session = RandomSession();
  ::testing::internal::CaptureStderr();
  {
    Recorder received;
    ChildPeer there(session, kThere);
    const auto here = Join(LoopbackOptions(session, kHere, Role::kActive), received);
    EXPECT_NE(here, nullptr);
    EXPECT_TRUE(received.WaitFor([](const Recorder::Heard& h) {
      return h.states.contains(kThere);
    }));
  }
  const std::string printed = ::testing::internal::GetCapturedStderr();
  unsetenv("CYCLONEDDS_URI");
  EXPECT_THAT(printed, HasSubstr("CYCLONEDDS_URI"));
  // one line from the child, one from here
  EXPECT_EQ(std::count(printed.begin(), printed.end(), '\n'), 2) << printed;
}

}  // namespace
}  // namespace tandem::testing
