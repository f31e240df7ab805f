#include "collab/dds/partitions.h"

#include <gtest/gtest.h>

namespace tandem {
namespace {

TEST(Partitions, NameTheirOwner) {
  EXPECT_EQ(PeerPartition(0xABC), "peer.0000000000000abc");
  EXPECT_EQ(ViewPartition(~PeerId{0}), "view.ffffffffffffffff");
  EXPECT_EQ(OwnerOfPartition(PeerPartition(0xABC)), PeerId{0xABC});
  EXPECT_EQ(OwnerOfPartition(ViewPartition(~PeerId{0})), ~PeerId{0});
}

TEST(Partitions, OthersHaveNoOwner) {
  for (const char* name :
       {"", "peer.", "peer.*", "scene", "peer.abc", "peer.00000000000000000abc",
        "peer.-000000000000abc", "peer.0000000000000abg", "eye.00000000000000ab"}) {
    EXPECT_EQ(OwnerOfPartition(name), PeerId{0}) << name;
  }
}

}  // namespace
}  // namespace tandem
