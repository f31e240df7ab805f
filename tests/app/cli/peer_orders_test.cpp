#include "app/cli/peer_orders.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/support/shapes.h"
#include "tests/support/test_world.h"

namespace tandem {
namespace {

using ::testing::HasSubstr;

/// A fixed plate, an own and a shared box; Anna is here, and Ben, who only looks on.
struct Room {
  Room() : directory(1, 42, "me") {
    const TriangleMesh box = testing::Box(Vec3(0.02, 0.02, 0.02));
    auto made = std::make_shared<WorldModel>(*testing::MakeWorldModel(
        {{testing::At(box, Vec3(0, 0, -0.1)), true}, {box}, {testing::At(box, Vec3(0.1, 0, 0))}},
        0.004));
    made->scene.bodies[0].name = "plate";
    made->scene.bodies[1].name = "own";
    made->scene.bodies[2].name = "both";
    made->scene.bodies[2].shared = true;
    model = made;
    PeerInfo info;
    info.scene_hash = 42;
    info.peer = 7;
    info.name = "Anna Maria";
    directory.OnPeerInfo(info);
    info.peer = 8;
    info.name = "Ben";
    info.role = Role::kViewer;
    directory.OnPeerInfo(info);
  }
  Result<Command> Order(const std::string& line, bool own_only = false) {
    return ParseOrder(line, *model, directory, own_only);
  }
  std::shared_ptr<const WorldModel> model;
  PeerDirectory directory;
};

TEST(PeerOrders, SayWhatToDoWithWhichBodyAndToWhom) {
  Room room;
  const auto grab = room.Order("grab both");
  ASSERT_TRUE(grab);
  EXPECT_EQ(grab->kind, Command::Kind::kGrab);
  EXPECT_EQ(grab->object, 2U);
  const auto release = room.Order("  release ");
  ASSERT_TRUE(release);
  EXPECT_EQ(release->kind, Command::Kind::kRelease);
  const auto give = room.Order("give own Anna Maria");
  ASSERT_TRUE(give);
  EXPECT_EQ(give->kind, Command::Kind::kGive);
  EXPECT_EQ(give->object, 1U);
  EXPECT_EQ(give->to, 7U);
}

TEST(PeerOrders, WhatIsNotUnderstoodOrNotThereIsSaid) {
  Room room;
  for (const char* line : {"", "grab", "grab own now", "give own", "release own", "throw own"}) {
    const auto order = room.Order(line);
    ASSERT_FALSE(order) << line;
    EXPECT_THAT(order.error().what, HasSubstr(std::string(line) + "' is no order"));
  }
  EXPECT_THAT(room.Order("grab hose").error().what, HasSubstr("no moving body 'hose'"));
  EXPECT_THAT(room.Order("grab plate").error().what, HasSubstr("no moving body 'plate'"));
  EXPECT_THAT(room.Order("give own Carl").error().what, HasSubstr("called 'Carl'"));
  // who looks on holds nothing
  EXPECT_THAT(room.Order("give own Ben").error().what, HasSubstr("called 'Ben'"));
}

TEST(PeerOrders, WithOtherForceParametersNoSharedBodyIsTaken) {
  Room room;
  EXPECT_TRUE(room.Order("grab own", true));
  EXPECT_THAT(room.Order("grab both", true).error().what, HasSubstr("'both' is shared"));
}

}  // namespace
}  // namespace tandem
