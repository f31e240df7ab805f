#include "collab/session/peer_map.h"

#include <algorithm>
#include <iterator>
#include <vector>

#include <gtest/gtest.h>

#include "tests/support/allocation_counter.h"

namespace tandem {
namespace {

struct Numbered {
  PeerId peer = 0;
  int number = 7;
};

using SmallMap = PeerMap<Numbered, 4>;

static_assert(std::forward_iterator<SmallMap::iterator>);
static_assert(std::forward_iterator<SmallMap::const_iterator>);

std::vector<PeerId> PeersIn(const SmallMap& map) {
  std::vector<PeerId> peers;
  for (const Numbered& value : map) peers.push_back(value.peer);
  return peers;
}

SmallMap MapOf(const std::vector<PeerId>& peers) {
  SmallMap map;
  for (const PeerId peer : peers) map.FindOrInsert(peer);
  return map;
}

TEST(PeerMap, FindsOnlyInsertedPeers) {
  SmallMap map;
  EXPECT_EQ(map.Find(5), nullptr);
  Numbered* const value = map.FindOrInsert(5);
  ASSERT_NE(value, nullptr);
  EXPECT_EQ(value->peer, 5U);
  value->number = 50;
  EXPECT_EQ(map.Find(5), value);
  EXPECT_EQ(map.FindOrInsert(5), value);
  EXPECT_EQ(map.Find(5)->number, 50);
  EXPECT_EQ(map.Find(6), nullptr);
  const SmallMap& unchangeable = map;
  EXPECT_EQ(unchangeable.Find(5), value);
  EXPECT_EQ(unchangeable.Find(6), nullptr);
}

// 0 marks free slots, so no search may take one of them for a peer
TEST(PeerMap, ZeroIsNotAPeer) {
  SmallMap map;
  EXPECT_EQ(map.Find(0), nullptr);
  EXPECT_EQ(map.FindOrInsert(0), nullptr);
  map.FindOrInsert(5);
  map.Erase(0);
  EXPECT_EQ(PeersIn(map), (std::vector<PeerId>{5}));
}

TEST(PeerMap, RefusesInsertionBeyondCapacity) {
  SmallMap map = MapOf({1, 2, 3, 4});
  EXPECT_EQ(map.FindOrInsert(5), nullptr);
  EXPECT_NE(map.FindOrInsert(4), nullptr);
  EXPECT_EQ(PeersIn(map), (std::vector<PeerId>{1, 2, 3, 4}));
}

TEST(PeerMap, NewPeerGetsTheFirstFreeSlotWithAFreshValue) {
  SmallMap map = MapOf({9, 3, 7, 1});
  for (Numbered& value : map) value.number = 1;
  map.Erase(7);
  map.Erase(3);
  EXPECT_EQ(PeersIn(map), (std::vector<PeerId>{9, 1}));
  EXPECT_EQ(map.FindOrInsert(8)->number, 7);
  EXPECT_EQ(PeersIn(map), (std::vector<PeerId>{9, 8, 1}));
  map.FindOrInsert(2);
  EXPECT_EQ(PeersIn(map), (std::vector<PeerId>{9, 8, 2, 1}));
}

TEST(PeerMap, ValuesKeepTheirSlots) {
  SmallMap map = MapOf({9, 3, 7});
  Numbered* const last = map.Find(7);
  map.Erase(9);
  EXPECT_EQ(map.Find(7), last);
  EXPECT_EQ(map.SlotOf(*last), 2U);
  EXPECT_EQ(map.InSlot(2), last);
  EXPECT_EQ(map.InSlot(0), nullptr);
  EXPECT_EQ(map.InSlot(3), nullptr);
  EXPECT_EQ(SmallMap::capacity(), 4U);
}

TEST(PeerMap, ErasingDuringIterationIsSafe) {
  SmallMap map = MapOf({1, 2, 3, 4});
  std::vector<PeerId> visited;
  for (const Numbered& value : map) {
    const PeerId peer = value.peer;
    visited.push_back(peer);
    if (peer != 3) map.Erase(peer);
  }
  EXPECT_EQ(visited, (std::vector<PeerId>{1, 2, 3, 4}));
  EXPECT_EQ(PeersIn(map), (std::vector<PeerId>{3}));
}

TEST(PeerMap, ClearFreesAllSlots) {
  SmallMap map = MapOf({1, 2});
  map.Find(1)->number = 1;
  map.Clear();
  EXPECT_EQ(map.begin(), map.end());
  EXPECT_EQ(map.FindOrInsert(1)->number, 7);
}

TEST(PeerMap, AlgorithmsSeeOnlyUsedSlots) {
  SmallMap map = MapOf({4, 6, 8});
  map.Erase(6);
  EXPECT_EQ(std::ranges::distance(map), 2);
  EXPECT_EQ(std::ranges::count(map, 7, &Numbered::number), 2);
  map.Find(8)->number = 2;
  EXPECT_EQ(std::ranges::min_element(map, {}, &Numbered::number)->peer, 8U);
}

TEST(PeerMap, AllocatesNothing) {
  const testing::AllocationCounter counter;
  SmallMap map;
  for (PeerId peer = 1; peer < 100; ++peer) {
    map.FindOrInsert(peer);
    map.Erase(peer / 2);
  }
  EXPECT_EQ(counter.count(), 0);
}

TEST(PeerSet, HoldsOnlyInsertedPeers) {
  PeerSet<2> set;
  EXPECT_EQ(set.Find(5), nullptr);
  EXPECT_NE(set.FindOrInsert(5), nullptr);
  EXPECT_NE(set.Find(5), nullptr);
}

}  // namespace
}  // namespace tandem
