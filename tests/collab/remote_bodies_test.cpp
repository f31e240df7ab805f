#include "collab/remote_bodies.h"

#include <gtest/gtest.h>

#include "tests/support/shapes.h"
#include "tests/support/test_world.h"

namespace tandem {
namespace {

// A free body that nobody holds moves while we are alone, and stands while anybody else is there,
// holding something or not.
TEST(RemoteBodies, AFreeBodyIsSimulatedOnlyWhileNoOtherPeerIsThere) {
  const TriangleMesh box = testing::Box(Vec3(0.02, 0.02, 0.02));
  WorldModel model = *testing::MakeWorldModel({{box}, {box}, {box}}, 0.001);
  model.scene.bodies[1].free = true;
  using Kind = MembershipChange::Kind;
  RemoteBodies remote(model);
  StepInputs inputs = testing::FreeInputs(model);
  const auto drives = [&] {
    remote.Prepare(0, inputs);
    return std::vector<BodyDrive>{inputs.bodies[0].drive, inputs.bodies[1].drive,
                                  inputs.bodies[2].drive};
  };
  const std::vector<BodyDrive> alone{BodyDrive::kSimulated, BodyDrive::kSimulated,
                                     BodyDrive::kParked};
  const std::vector<BodyDrive> in_company{BodyDrive::kSimulated, BodyDrive::kParked,
                                          BodyDrive::kParked};
  EXPECT_EQ(drives(), alone);
  remote.OnMembership({.kind = Kind::kJoined, .peer = 7});
  remote.OnMembership({.kind = Kind::kClaims, .peer = 7});  // it took something else
  remote.OnMembership({.kind = Kind::kJoined, .peer = 9});
  EXPECT_EQ(drives(), in_company);
  remote.OnMembership({.kind = Kind::kLeft, .peer = 7});
  EXPECT_EQ(drives(), in_company);
  remote.OnMembership({.kind = Kind::kLost, .peer = 9});
  EXPECT_EQ(drives(), alone);
}

}  // namespace
}  // namespace tandem
