#include "collab/dds/cyclone/partitions.h"

#include <random>
#include <vector>

#include <gtest/gtest.h>

#include "collab/dds/cyclone/qos.h"
#include "collab/dds/transport/domain.h"
#include "collab/dds/wire/wire.h"

namespace tandem {
namespace {

/// A participant with a reader of all peers' states, and writers of many peers beside it.
class WriterOwnersTest : public ::testing::Test {
 protected:
  WriterOwnersTest() {
    DdsOptions options;
    options.session = "writers-" + std::to_string(std::random_device{}());
    options.interface = "lo";
    Result<Entity> domain = CreateDomain(options);
    EXPECT_TRUE(domain);
    domain_ = *std::move(domain);
    here_ = Entity(dds_create_participant(options.domain, nullptr, nullptr));
    there_ = Entity(dds_create_participant(options.domain, nullptr, nullptr));
    const Qos qos = MakeQos(Purpose::kMotion, kEveryPeer);
    reader_ = dds_create_reader(here_.get(), Topic(here_), qos.get(), nullptr);
    EXPECT_GT(reader_, 0);
    topic_ = Topic(there_);
  }
  static dds_entity_t Topic(const Entity& participant) {
    return dds_create_topic(participant.get(), &tandem_ObjectState_desc, "state/1", nullptr,
                            nullptr);
  }
  /// Adds writers of peers first, first + 1, …
  void AddWriters(PeerId first, std::size_t count) {
    for (std::size_t i = 0; i < count; ++i) {
      const Qos qos = MakeQos(Purpose::kMotion, PeerPartition(first + i));
      writers_.emplace_back(dds_create_writer(there_.get(), topic_, qos.get(), nullptr));
      ASSERT_GT(writers_.back().get(), 0);
    }
  }
  /// Returns the reader's handle of a peer's writer.
  dds_instance_handle_t HandleOf(std::size_t writer) {
    dds_instance_handle_t handle = 0;
    dds_get_instance_handle(writers_[writer].get(), &handle);
    return handle;
  }

  Entity domain_, here_, there_;
  dds_entity_t reader_ = 0;
  dds_entity_t topic_ = 0;
  std::vector<Entity> writers_;
};

TEST_F(WriterOwnersTest, DistinguishesAHundredPeers) {
  AddWriters(1, 100);
  WriterOwners owners;
  EXPECT_EQ(owners.Refresh(reader_), 0U);
  for (std::size_t i = 0; i < 100; ++i) EXPECT_EQ(owners.Find(HandleOf(i)), i + 1);
}

TEST_F(WriterOwnersTest, NewcomerFloodMutesNoKnownPeer) {
  AddWriters(1, 16);
  WriterOwners owners;
  owners.Refresh(reader_);
  AddWriters(1000, 300);
  EXPECT_EQ(owners.Refresh(reader_), 316 - WriterOwners::kMaxWriters);
  for (std::size_t i = 0; i < 16; ++i) EXPECT_EQ(owners.Find(HandleOf(i)), i + 1);
  // a peer that goes makes room for those who had none
  while (writers_.size() > 200) writers_.erase(writers_.begin() + 16);
  EXPECT_EQ(owners.Refresh(reader_), 0U);
  for (std::size_t i = 0; i < 16; ++i) EXPECT_EQ(owners.Find(HandleOf(i)), i + 1);
  EXPECT_EQ(owners.Find(HandleOf(199)), 1299U);
}

TEST_F(WriterOwnersTest, PeerTakesOnlyItsOwnSlots) {
  for (std::size_t i = 0; i < WriterOwners::kMaxWriters; ++i) AddWriters(7, 1);
  AddWriters(8, 1);
  WriterOwners owners;
  EXPECT_EQ(owners.Refresh(reader_), WriterOwners::kMaxWriters - WriterOwners::kMaxOfOne);
  EXPECT_EQ(owners.Find(HandleOf(WriterOwners::kMaxWriters)), 8U);
}

TEST_F(WriterOwnersTest, AnnouncedPeerReplacesAnUnannouncedOne) {
  AddWriters(1000, WriterOwners::kMaxWriters);
  WriterOwners owners;
  EXPECT_EQ(owners.Refresh(reader_), 0U);
  AddWriters(8, 1);
  EXPECT_EQ(owners.Refresh(reader_), 1U);
  const dds_instance_handle_t participant =
      FactsOfWriter(reader_, HandleOf(WriterOwners::kMaxWriters)).participant;
  EXPECT_EQ(owners.Refresh(reader_, {{8, participant}}), 1U);
  EXPECT_EQ(owners.Find(HandleOf(WriterOwners::kMaxWriters)), 8U);
}

TEST(Partitions, NameTheirOwner) {
  EXPECT_EQ(PeerPartition(0xABC), "peer.0000000000000abc");
  EXPECT_EQ(ViewPartition(~PeerId{0}), "view.ffffffffffffffff");
  EXPECT_EQ(OwnerOfPartition(PeerPartition(0xABC)).peer, PeerId{0xABC});
  EXPECT_EQ(OwnerOfPartition(ViewPartition(~PeerId{0})).peer, ~PeerId{0});
  EXPECT_EQ(OwnerOfPartition(ScenePartition(0xABC)).peer, PeerId{0xABC});
  EXPECT_EQ(OwnerOfPartition(ViewerPartition(0xABC)).peer, PeerId{0xABC});
}

TEST(Partitions, OfMembersHaveTheirNames) {
  const std::string partition = NamedPartition(PeerPartition(0xABC), "anna.of_b-1");
  EXPECT_EQ(partition, "peer.0000000000000abc.anna.of_b-1");
  EXPECT_EQ(OwnerOfPartition(partition), (PartitionOwner{0xABC, "anna.of_b-1"}));
  EXPECT_EQ(OwnerOfPartition(PeerPartition(0xABC)).name, "");
  EXPECT_EQ(OwnerOfPartition(NamedPartition(PeerPartition(0xABC), "a *?")).name, "a___");
}

TEST(Partitions, OthersHaveNoOwner) {
  for (const char* name : {"", "peer.", "peer.*", "scene", "peer.abc", "peer.00000000000000000abc",
                           "peer.-000000000000abc", "peer.0000000000000abg", "eye.00000000000000ab",
                           "peer.0000000000000abc.", "peer.0000000000000abc-anna", "scene."}) {
    EXPECT_EQ(OwnerOfPartition(name), PartitionOwner{}) << name;
  }
}

}  // namespace
}  // namespace tandem
