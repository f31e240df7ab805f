#include "app/recording/network_plan.h"

#include <algorithm>
#include <set>
#include <string>
#include <vector>

#include <gmock/gmock.h>

#include "engine/base/units.h"
#include "tests/support/scratch_folder.h"

namespace tandem {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

PeerInfo Here(PeerId id, const std::string& name) {
  PeerInfo info;
  info.peer = id;
  info.name = name;
  return info;
}

/// A peer that hears Anna (11) and Ben (12) and follows a plan.
class NetworkPlanTest : public ::testing::Test {
 protected:
  NetworkPlanTest() {
    directory_.OnPeerInfo(Here(11, "anna"));
    directory_.OnPeerInfo(Here(12, "ben"));
  }
  void Start(const std::string& text) {
    Result<NetworkPlan> plan = LoadNetworkPlan(folder_.Write("plan.json", text));
    ASSERT_TRUE(plan) << plan.error().what;
    planned_.Start(*std::move(plan), kBegin);
  }
  std::vector<std::string> ApplyAt(double seconds) {
    now_ns_ = kBegin + static_cast<std::int64_t>(seconds * 1e9);
    return planned_.Apply(now_ns_, directory_, inbox_);
  }
  /// Returns when a sample that arrives now is due, ms from now; none: never.
  std::vector<double> Due(PeerId from) {
    ObjectState state;
    state.peer = from;
    state.seq = ++seq_;
    inbox_.OnState(state, now_ns_);
    inbox_.Collect();
    std::vector<double> due;
    for (std::int64_t later = 0; later < 3 * kSecondNs; later += 1'000'000) {
      while (const ObjectState* next = inbox_.states().Due(now_ns_ + later)) {
        EXPECT_EQ(next->peer, from);
        due.push_back(1e-6 * static_cast<double>(later));
        inbox_.states().Drop();
      }
    }
    return due;
  }

  static constexpr std::int64_t kBegin = 1000 * kSecondNs;
  ScratchFolder folder_;
  PeerDirectory directory_{1, 0};
  PeerInbox inbox_{LinkConditions{}, directory_};
  PlannedNetwork planned_;
  std::int64_t now_ns_ = kBegin;
  std::uint32_t seq_ = 0;
};

TEST_F(NetworkPlanTest, SendersUseTheirOwnOrTheDefaultSteps) {
  Start(R"({"links": [{"steps": [{"delay_ms": 40}, {"at_s": 9, "delay_ms": 70}]},
                      {"from": "ben", "steps": [{"at_s": 2, "delay_ms": 120},
                                                {"at_s": 5, "cut": true},
                                                {"at_s": 6, "duplicate": 1}]}]})");
  EXPECT_THAT(ApplyAt(0), ElementsAre("network: samples of all peers come 40 ms late"));
  EXPECT_THAT(ApplyAt(1), IsEmpty());
  EXPECT_THAT(Due(11), ElementsAre(40));
  EXPECT_THAT(Due(12), ElementsAre(40)) << "before its first step";
  EXPECT_THAT(ApplyAt(2), ElementsAre("network: samples of ben come 120 ms late"));
  EXPECT_THAT(Due(11), ElementsAre(40));
  EXPECT_THAT(Due(12), ElementsAre(120));
  EXPECT_THAT(ApplyAt(5.5), ElementsAre("network: samples of ben come no more"));
  EXPECT_THAT(Due(11), ElementsAre(40));
  EXPECT_THAT(Due(12), IsEmpty());
  ApplyAt(7);
  EXPECT_EQ(Due(12).size(), 2U) << "a step holds alone";
  // a switch for everybody leaves alone the peers that another link names
  EXPECT_THAT(ApplyAt(9), ElementsAre("network: samples of all peers come 70 ms late"));
  EXPECT_THAT(Due(11), ElementsAre(70));
  EXPECT_EQ(Due(12).size(), 2U);
}

TEST_F(NetworkPlanTest, AppliesToNamedPeersAcrossRestarts) {
  Start(R"({"links": [{"from": "carl", "steps": [{"delay_ms": 200}]}]})");
  EXPECT_THAT(ApplyAt(0), ElementsAre("network: samples of all peers come 0 ms late"));
  directory_.OnPeerInfo(Here(13, "carl"));
  EXPECT_THAT(ApplyAt(3), ElementsAre("network: samples of carl come 200 ms late"));
  EXPECT_THAT(Due(13), ElementsAre(200));
  EXPECT_THAT(Due(12), ElementsAre(0));
  directory_.OnPeerLeft(13);
  EXPECT_THAT(ApplyAt(4), IsEmpty());
  directory_.OnPeerInfo(Here(14, "carl"));
  EXPECT_THAT(ApplyAt(5), ElementsAre("network: samples of carl come 200 ms late"));
  EXPECT_THAT(Due(14), ElementsAre(200));
}

TEST_F(NetworkPlanTest, MayStartWithTheHand) {
  Start(
      R"({"begins": "hand", "links": [{"steps": [{"delay_ms": 40}, {"at_s": 2, "delay_ms": 70}]}]})");
  EXPECT_THAT(ApplyAt(0), ElementsAre("network: samples of all peers come 40 ms late"));
  EXPECT_THAT(ApplyAt(9), IsEmpty());
  planned_.HandBegins(now_ns_);
  EXPECT_THAT(ApplyAt(10.9), IsEmpty());
  EXPECT_THAT(ApplyAt(11.1), ElementsAre("network: samples of all peers come 70 ms late"));
  // a plan that is given later counts from when it is given
  Start(R"({"begins": "hand", "links": [{"steps": [{"at_s": 1, "delay_ms": 20}]}]})");
  ApplyAt(0);
  EXPECT_THAT(ApplyAt(1.1), ElementsAre("network: samples of all peers come 20 ms late"));
}

TEST_F(NetworkPlanTest, SeedDeterminesLosses) {
  // tells which of 200 samples from Ben are lost by the seed's plan; `before`: samples heard
  // without a plan
  const auto lost = [this](int seed, int before) {
    PeerInbox inbox(LinkConditions{.loss = 0.5}, directory_);
    ObjectState state;
    state.peer = 12;
    for (int i = 0; i < before; ++i) inbox.OnState(state, kBegin - 1);
    inbox.Collect();
    while (inbox.states().Due(kBegin) != nullptr) inbox.states().Drop();
    Start(R"({"seed": )" + std::to_string(seed) +
          R"(, "links": [{"from": "ben", "steps": [{"loss": 0.5}]}]})");
    planned_.Apply(kBegin, directory_, inbox);
    std::string received;
    for (int i = 0; i < 200; ++i) {
      inbox.OnState(state, kBegin);
      inbox.Collect();
      const bool came = inbox.states().Due(kBegin) != nullptr;
      received += came ? '1' : '0';
      if (came) inbox.states().Drop();
    }
    return received;
  };
  const std::string seven = lost(7, 0);
  EXPECT_EQ(seven, lost(7, 0));
  EXPECT_EQ(seven, lost(7, 30)) << "it is the plan's own";
  EXPECT_NE(seven, lost(8, 0));
  EXPECT_NEAR(static_cast<double>(std::ranges::count(seven, '1')), 100, 36);
}

TEST_F(NetworkPlanTest, OrderSwitchesItAtRunTime) {
  Start(R"({"links": [{"from": "ben", "steps": [{"cut": true}]}]})");
  ApplyAt(0);
  EXPECT_THAT(Due(12), IsEmpty());
  const std::string other =
      folder_.Write("other plan.json", R"({"links": [{"steps": [{"at_s": 1, "delay_ms": 30}]}]})")
          .string();
  ASSERT_TRUE(PlannedNetwork::IsOrder("network " + other));
  EXPECT_FALSE(PlannedNetwork::IsOrder("networks x"));
  EXPECT_FALSE(planned_.Obey("network " + other, kBegin + 10 * kSecondNs, 2));
  ApplyAt(10.5);
  EXPECT_THAT(Due(12), ElementsAre(0)) << "its time begins with the order";
  ApplyAt(11.5);
  EXPECT_THAT(Due(12), ElementsAre(30));
  // a file that cannot be read changes nothing
  const std::optional<Error> wrong =
      planned_.Obey("network /nowhere.json", kBegin + 12 * kSecondNs, 2);
  ASSERT_TRUE(wrong);
  EXPECT_THAT(wrong->what, HasSubstr("/nowhere.json"));
  ApplyAt(12.5);
  EXPECT_THAT(Due(12), ElementsAre(30));
  EXPECT_FALSE(planned_.Obey("network off", kBegin + 13 * kSecondNs, 2));
  ApplyAt(13);
  EXPECT_THAT(Due(12), ElementsAre(0));
  EXPECT_TRUE(planned_.Obey("network", kBegin, 2));
}

const char* const kHeldLong = R"({"links": [{"steps": [{"delay_ms": 2000, "jitter_ms": 1000,
    "swing_ms": 1000, "reorder": 0.5, "reorder_ms": 1000, "duplicate": 1}]}]})";

/// Counts the samples lost for want of room while three peers speak for eight seconds at 1 kHz.
std::uint64_t LostOfThree(const NetworkPlan& plan, std::size_t room) {
  PeerDirectory directory(1, 0);
  PeerInbox inbox(plan.links.at(0).steps.at(0).conditions, directory, room);
  for (std::int64_t ms = 0; ms < 8000; ++ms) {
    for (const PeerId peer : {11, 12, 13}) {
      ObjectState state;
      state.peer = peer;
      state.seq = static_cast<std::uint32_t>(ms + 1);
      inbox.OnState(state, ms * 1'000'000);
    }
    inbox.Collect();
    while (inbox.states().Due(ms * 1'000'000) != nullptr) inbox.states().Drop();
  }
  return inbox.overflows();
}

TEST_F(NetworkPlanTest, BufferHoldsAllDelayedSamplesOfAPlan) {
  const Result<NetworkPlan> plan = LoadNetworkPlan(folder_.Write("long.json", kHeldLong));
  ASSERT_TRUE(plan) << plan.error().what;
  EXPECT_GT(LostOfThree(*plan, PeerInbox::kDefaultWaiting), 0U) << "a plan that needs more";
  EXPECT_EQ(LostOfThree(*plan, MostWaiting(*plan, 3)), 0U);
}

TEST_F(NetworkPlanTest, OrderBeyondTheBufferIsRefused) {
  const std::string order = "network " + folder_.Write("long.json", kHeldLong).string();
  EXPECT_FALSE(planned_.Obey(order, kBegin, 1));
  const std::optional<Error> wrong = planned_.Obey(order, kBegin, 3);
  ASSERT_TRUE(wrong);
  // two delays of 5.1 s, for three senders
  EXPECT_THAT(wrong->what, HasSubstr("delays up to 30601 samples of 3 senders"));
}

TEST_F(NetworkPlanTest, ReadsEveryConditionAndReportsErrors) {
  const Result<NetworkPlan> plan = LoadNetworkPlan(folder_.Write("all.json", R"({"seed": 9,
    "links": [{"steps": [{"delay_ms": 1, "jitter_ms": 2, "swing_ms": 3, "swing_period_s": 4,
      "loss": 0.05, "burst_enter": 0.06, "burst_leave": 0.07, "burst_loss": 0.08, "reorder": 0.09,
      "reorder_ms": 10, "duplicate": 0.11, "cut": true}]}]})"));
  ASSERT_TRUE(plan) << plan.error().what;
  const LinkConditions& c = plan->links.at(0).steps.at(0).conditions;
  EXPECT_THAT((std::vector<double>{c.delay_ms, c.jitter_ms, c.swing_ms, c.swing_period_s, c.loss,
                                   c.burst_enter, c.burst_leave, c.burst_loss, c.reorder,
                                   c.reorder_ms, c.duplicate}),
              ElementsAre(1, 2, 3, 4, 0.05, 0.06, 0.07, 0.08, 0.09, 10, 0.11));
  EXPECT_TRUE(c.cut);
  EXPECT_EQ(c.seed, 9U);

  const auto wrong = [this](const std::string& steps) {
    const Result<NetworkPlan> bad =
        LoadNetworkPlan(folder_.Write("bad.json", R"({"links": [{"steps": )" + steps + "}]}"));
    return bad ? std::string("nothing") : bad.error().what;
  };
  EXPECT_THAT(wrong(R"([{"delay": 1}])"), HasSubstr("links[0].steps[0].delay"));
  EXPECT_THAT(wrong(R"([{"loss": 1.5}])"), HasSubstr("a number from 0 to 1"));
  EXPECT_THAT(wrong(R"([{"delay_ms": 5000}])"), HasSubstr("a number from 0 to 2000"));
  EXPECT_THAT(wrong(R"([{"at_s": 2}, {"at_s": 2}])"), HasSubstr("later than the step before"));
  EXPECT_THAT(wrong("[{]"), HasSubstr("line 1"));
}

constexpr const char* kTrace = "# {\"tandem_trace\": 1, \"rate_hz\": 2}\nseq,there_ms,back_ms\n";

TEST_F(NetworkPlanTest, StepPlaysATraceFileBesideThePlan) {
  folder_.Write("line.csv", std::string(kTrace) + "0,10,300\n1,,5\n2,80,6\n");
  Start(R"({"links": [{"steps": [{"trace": "line.csv"}]},
                      {"from": "ben", "steps": [{"trace": "line.csv", "way": "back",
                                                 "stretch": 2, "delay_ms": 7}]}]})");
  EXPECT_THAT(ApplyAt(0),
              ElementsAre(HasSubstr("line.csv, 0 ms late"), HasSubstr("line.csv, way back, 7 ms")));
  EXPECT_THAT(Due(11), ElementsAre(10));
  EXPECT_THAT(Due(12), ElementsAre(607));
  ApplyAt(0.6);
  EXPECT_THAT(Due(11), IsEmpty());
  ApplyAt(1.1);
  EXPECT_THAT(Due(11), ElementsAre(80));
  ApplyAt(1.6);
  EXPECT_THAT(Due(11), ElementsAre(10)) << "it begins again";
}

TEST_F(NetworkPlanTest, TraceStartsAsThePlanOrSeedSays) {
  folder_.Write("line.csv", std::string(kTrace) + "0,10,1\n1,20,1\n2,30,1\n3,40,1\n");
  Start(R"({"links": [{"steps": [{"trace": "line.csv", "start_s": 1}]}]})");
  ApplyAt(0);
  EXPECT_THAT(Due(11), ElementsAre(30));
  int requested = 0;
  const auto first = [this, &requested](int seed) {
    Start(R"({"seed": )" + std::to_string(seed) +
          R"(, "links": [{"steps": [{"trace": "line.csv", "mix": true}]}]})");
    // each sample comes later than the last: it waits for those that came before it
    ApplyAt(++requested);
    return Due(11);
  };
  std::set<std::vector<double>> found;
  for (int seed = 1; seed < 40; ++seed) found.insert(first(seed));
  EXPECT_EQ(found.size(), 4U);
  const std::vector<double> fifth = first(5);
  first(6);  // else it is the trace that goes on
  EXPECT_EQ(first(5), fifth);
}

TEST_F(NetworkPlanTest, BufferHoldsAllDelayedSamplesOfATrace) {
  const Result<NetworkPlan> plan =
      LoadNetworkPlan(folder_.Write("plan.json", R"({"links": [{"steps": [{"model": "geo"}]}]})"));
  ASSERT_TRUE(plan) << plan.error().what;
  EXPECT_GE(MostWaiting(*plan, 1), 400U);
}

TEST_F(NetworkPlanTest, ReportsInvalidTraces) {
  folder_.Write("bad.csv", std::string(kTrace) + "1,10,1\n");
  const auto fault = [this](const std::string& step) {
    const Result<NetworkPlan> plan =
        LoadNetworkPlan(folder_.Write("plan.json", R"({"links": [{"steps": [)" + step + "]}]}"));
    return plan ? std::string("none") : plan.error().what;
  };
  EXPECT_THAT(fault(R"({"trace": "none.csv"})"), HasSubstr("steps[0].trace: "));
  EXPECT_THAT(fault(R"({"trace": "bad.csv"})"), HasSubstr("bad.csv:3: expected 0"));
  EXPECT_THAT(fault(R"({"model": "6g"})"), HasSubstr("steps[0].model: no model of a network"));
  EXPECT_THAT(fault(R"({"model": "lte", "trace": "bad.csv"})"), HasSubstr("one of both"));
  EXPECT_THAT(fault(R"({"stretch": 2})"), HasSubstr("steps[0].stretch: there is no trace"));
  EXPECT_THAT(fault(R"({"way": "back"})"), HasSubstr("steps[0].way: give "));
  EXPECT_THAT(fault(R"({"model": "lte", "way": "up"})"), HasSubstr("expected there or back"));
  EXPECT_THAT(fault(R"({"model": "geo", "stretch": 50})"), HasSubstr("more than 10 s"));
}

}  // namespace
}  // namespace tandem
