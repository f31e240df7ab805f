#include "engine/contact/schedule/distance_queues.h"

#include <algorithm>
#include <map>
#include <random>
#include <set>
#include <vector>

#include <gtest/gtest.h>

namespace tandem {
namespace {

// 64 addresses a word, 4,096 a word of the upper level: the last of both are not full
constexpr std::size_t kAddresses = 9'001;

std::multiset<std::size_t> MembersOf(DistanceQueues& queues, int queue) {
  std::multiset<std::size_t> members;
  queues.VisitAll(queue, [&](std::size_t address) {
    members.insert(address);
  });
  return members;
}

TEST(DistanceQueues, MemberIsInItsLatestQueueOnly) {
  std::mt19937_64 random(7);
  DistanceQueues queues(kAddresses);
  std::map<std::size_t, int> stands;
  for (int move = 0; move < 20'000; ++move) {
    const std::size_t address = random() % kAddresses;
    const int queue = static_cast<int>(random() % (DistanceQueues::kQueues + 1));
    if (queue == DistanceQueues::kQueues) {
      queues.Sleep(address);
      stands.erase(address);
    } else {
      queues.Put(address, queue);
      stands[address] = queue;
    }
  }
  EXPECT_EQ(queues.awake(), stands.size());
  for (int queue = 0; queue < DistanceQueues::kQueues; ++queue) {
    std::multiset<std::size_t> members;
    for (const auto& [address, in] : stands) {
      if (in == queue) members.insert(address);
    }
    EXPECT_EQ(MembersOf(queues, queue), members) << "queue " << queue;
    EXPECT_EQ(queues.count(queue), members.size()) << "queue " << queue;
  }
}

// The shares of a round are powers of two, so that their sum is exact.
TEST(DistanceQueues, CursorVisitsEachMemberOncePerRound) {
  DistanceQueues queues(kAddresses);
  for (std::size_t address = 0; address < kAddresses; address += 3) queues.Put(address, 5);
  queues.Sweep(5, 0.375, [](std::size_t) {});  // a round may begin anywhere
  std::multiset<std::size_t> passed;
  for (const double share : {0.25, 0.0625, 0.0, 0.5, 0.125, 0.0625}) {
    queues.Sweep(5, share, [&](std::size_t address) {
      passed.insert(address);
    });
  }
  EXPECT_EQ(passed, MembersOf(queues, 5));
}

TEST(DistanceQueues, NoMemberWaitsForMoreThanOneRound) {
  std::mt19937_64 random(8);
  std::uniform_real_distribution<double> share(0, 0.1);
  DistanceQueues queues(kAddresses);
  std::map<std::size_t, double> waits_since;  // rounds of the cursor when it came
  double rounds = 0;
  double longest = 0;
  for (int frame = 0; frame < 2'000; ++frame) {
    for (int newcomer = 0; newcomer < 20; ++newcomer) {
      const std::size_t address = random() % kAddresses;
      if (waits_since.contains(address)) continue;
      queues.Put(address, 3);
      waits_since[address] = rounds;
    }
    const double advance = share(random);
    rounds += advance;
    std::set<std::size_t> passed;
    queues.Sweep(3, advance, [&](std::size_t address) {
      passed.insert(address);
    });
    for (const std::size_t address : passed) {
      ASSERT_TRUE(waits_since.contains(address));
      longest = std::max(longest, rounds - advance - waits_since.at(address));
      waits_since.erase(address);
      queues.Sleep(address);
    }
  }
  // it is passed in the frame in which the round is full, so it has waited for less before that
  EXPECT_LT(longest, 1.0);
  EXPECT_GT(longest, 0.9);
}

TEST(DistanceQueues, EmptyQueueIsSkippedInSpiteOfStaleUpperBits) {
  DistanceQueues queues(kAddresses);
  queues.Put(70, 2);
  queues.Put(8'000, 2);
  DistanceQueues::Moves moves{};
  queues.PutBeside(70, 4, moves);
  queues.PutBeside(8'000, 4, moves);
  queues.Add(moves);
  EXPECT_EQ(queues.count(2), 0U);
  queues.Sweep(2, 1.0, [](std::size_t address) {
    ADD_FAILURE() << address;
  });
  queues.VisitNext(2, 10, [](std::size_t address) {
    ADD_FAILURE() << address;
  });
  EXPECT_EQ(MembersOf(queues, 4), (std::multiset<std::size_t>{70, 8'000}));
}

TEST(DistanceQueues, NextMembersComeRoundRobinAsInThePaper) {
  DistanceQueues queues(kAddresses);
  for (const std::size_t address : {5U, 64U, 4'100U}) queues.Put(address, 0);
  std::vector<std::size_t> visited;
  for (int frame = 0; frame < 3; ++frame) {
    queues.VisitNext(0, 2, [&](std::size_t address) {
      visited.push_back(address);
    });
  }
  EXPECT_EQ(visited, (std::vector<std::size_t>{5, 64, 4'100, 5, 64, 4'100}));
}

}  // namespace
}  // namespace tandem
