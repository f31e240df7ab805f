#include "collab/dds/wire/wire.h"

#include <limits>

#include <gmock/gmock.h>

#include "tests/collab/dds/wire/sound_wire.h"

namespace tandem {
namespace {

using testing::kInfinity;
using testing::kNan;
using testing::Sound;

tandem_ObjectState SoundState() {
  ObjectState state;
  state.peer = 5;
  state.object = 6;
  state.epoch = 7;
  state.seq = 8;
  state.flags = 9;
  state.sample_ns = -10;
  state.X_WB = {Quat(0.5, 0.5, -0.5, 0.5), Vec3(1, 2, 3)};
  state.V_WB = {Vec3(4, 5, 6), Vec3(7, 8, 9)};
  state.contact_B_W = {Vec3(10, 11, 12), Vec3(13, 14, 15)};
  tandem_ObjectState wire;
  ToWire(state, wire);
  return wire;
}

TEST(Wire, StatesRoundTrip) {
  ObjectState state;
  ASSERT_TRUE(Sound(SoundState(), state));
  EXPECT_EQ(state.peer, 5U);
  EXPECT_EQ(state.object, 6U);
  EXPECT_EQ(state.epoch, 7U);
  EXPECT_EQ(state.seq, 8U);
  EXPECT_EQ(state.flags, 9U);
  EXPECT_EQ(state.sample_ns, -10);
  EXPECT_EQ(state.X_WB.q.coeffs(), Quat(0.5, 0.5, -0.5, 0.5).coeffs());
  EXPECT_EQ(state.X_WB.p, Vec3(1, 2, 3));
  EXPECT_EQ(state.V_WB.w, Vec3(4, 5, 6));
  EXPECT_EQ(state.V_WB.v, Vec3(7, 8, 9));
  EXPECT_EQ(state.contact_B_W.tau, Vec3(10, 11, 12));
  EXPECT_EQ(state.contact_B_W.f, Vec3(13, 14, 15));
}

TEST(Wire, QuaternionsAreSentAsXyzw) {
  ObjectState state;
  state.X_WB.q = Quat(0.8, 0, 0.6, 0);  // Eigen's order here is w first
  tandem_ObjectState wire;
  ToWire(state, wire);
  EXPECT_THAT(wire.pose.q, ::testing::ElementsAre(0, 0.6, 0, 0.8));
}

TEST(Wire, NonFiniteStateIsRefused) {
  ObjectState out;
  for (const double bad : {kNan, kInfinity, -kInfinity}) {
    for (std::size_t i = 0; i < 3; ++i) {
      for (double* (*member)(tandem_ObjectState&) : {+[](tandem_ObjectState& s) {
                                                       return s.pose.p;
                                                     },
                                                     +[](tandem_ObjectState& s) {
                                                       return s.pose.q;
                                                     },
                                                     +[](tandem_ObjectState& s) {
                                                       return s.twist.v;
                                                     },
                                                     +[](tandem_ObjectState& s) {
                                                       return s.twist.w;
                                                     },
                                                     +[](tandem_ObjectState& s) {
                                                       return s.contact.f;
                                                     },
                                                     +[](tandem_ObjectState& s) {
                                                       return s.contact.t;
                                                     }}) {
        tandem_ObjectState wire = SoundState();
        member(wire)[i] = bad;
        EXPECT_FALSE(Sound(wire, out));
      }
    }
  }
}

TEST(Wire, NonUnitQuaternionIsRefused) {
  ObjectState out;
  for (const double scale : {0.0, 0.9, 0.998, 1.002, 2.0, 1e-320, 1e200}) {
    tandem_ObjectState wire = SoundState();
    for (double& component : wire.pose.q) component *= scale;
    EXPECT_FALSE(Sound(wire, out)) << scale;
  }
  tandem_ObjectState wire = SoundState();
  for (double& component : wire.pose.q) component *= 1.0005;
  EXPECT_TRUE(Sound(wire, out));
}

TEST(Wire, PeerZeroIsRefused) {
  tandem_ObjectState wire = SoundState();
  wire.peer = 0;
  ObjectState out;
  EXPECT_FALSE(Sound(wire, out));
}

LinkedState FullLinks() {
  tandem_ObjectState state = SoundState();
  LinkedState linked;
  EXPECT_FALSE(FromWire(state, linked.state));
  CouplingLinks& links = linked.links;
  links.from = linked.state.peer;
  links.object = 2;
  links.seq = 3;
  links.sample_ns = 4;
  links.count = kMaxLinks;
  for (std::size_t i = 0; i < kMaxLinks; ++i) {
    const auto x = static_cast<double>(i);
    links.entries[i] = {
        i + 10, static_cast<std::int64_t>(i), 100 * x, 0.5 * x, {Vec3(x, 1, 2), Vec3(3, x, 5)}};
  }
  return linked;
}

TEST(Wire, LinksRoundTripWithTheirState) {
  const LinkedState output = FullLinks();
  tandem_LinkedState wire;
  ToWire(output, wire);
  LinkedState received;
  ASSERT_TRUE(Sound(wire, received));
  EXPECT_EQ(received.state.peer, output.state.peer);
  EXPECT_EQ(received.state.seq, output.state.seq);
  EXPECT_EQ(received.state.X_WB.p, output.state.X_WB.p);
  EXPECT_EQ(received.state.contact_B_W.f, output.state.contact_B_W.f);
  const CouplingLinks& back = received.links;
  EXPECT_EQ(back.from, output.state.peer);
  EXPECT_EQ(back.object, 2U);
  EXPECT_EQ(back.seq, 3U);
  EXPECT_EQ(back.sample_ns, 4);
  ASSERT_EQ(back.count, kMaxLinks);
  const LinkEntry& last = back.entries[kMaxLinks - 1];
  EXPECT_EQ(last.to, kMaxLinks + 9);
  EXPECT_EQ(last.echo_ns, static_cast<std::int64_t>(kMaxLinks - 1));
  EXPECT_EQ(last.stiffness, 700.0);
  EXPECT_EQ(last.gate_overflow, 3.5);
  EXPECT_EQ(last.applied_B_W.tau, Vec3(7, 1, 2));
  EXPECT_EQ(last.applied_B_W.f, Vec3(3, 7, 5));
}

TEST(Wire, InvalidLinksAreRefused) {
  tandem_LinkedState sound;
  ToWire(FullLinks(), sound);
  LinkedState out;
  auto refuses = [&](auto spoil) {
    tandem_LinkedState wire = sound;
    spoil(wire.links);
    return !Sound(wire, out);
  };
  EXPECT_TRUE(refuses([](auto& w) {
    w.count = kMaxLinks + 1;
  }));
  EXPECT_TRUE(refuses([](auto& w) {
    w.count = 0xFFFFFFFF;
  }));
  EXPECT_TRUE(refuses([](auto& w) {
    w.entries[3].to = 0;
  }));
  EXPECT_TRUE(refuses([](auto& w) {
    w.entries[3].stiffness = -1;
  }));
  EXPECT_TRUE(refuses([](auto& w) {
    w.entries[3].stiffness = kNan;
  }));
  EXPECT_TRUE(refuses([](auto& w) {
    w.entries[3].gate_overflow = -1;
  }));
  EXPECT_TRUE(refuses([](auto& w) {
    w.entries[7].applied.f[2] = kInfinity;
  }));
  // elements beyond the count are not looked at
  EXPECT_FALSE(refuses([](auto& w) {
    w.count = 7, w.entries[7].applied.f[2] = kInfinity;
  }));
}

TEST(Wire, LinksDoNotAffectTheStatesValidation) {
  tandem_LinkedState sound;
  ToWire(FullLinks(), sound);
  LinkedState out;
  const auto fault = [&](auto spoil) {
    tandem_LinkedState wire = sound;
    spoil(wire);
    return FromWire(wire, out);
  };
  EXPECT_EQ(fault([](auto&) {}), std::nullopt);
  EXPECT_EQ(fault([](auto& w) {
              w.peer = w.state.peer = 0;
            }),
            Drop::kNoOwner);
  EXPECT_EQ(fault([](auto& w) {
              w.state.peer += 1;
            }),
            Drop::kWrongOwner);
  EXPECT_EQ(fault([](auto& w) {
              w.state.pose.p[2] = kNan;
            }),
            Drop::kNotFinite);
  EXPECT_EQ(fault([](auto& w) {
              w.state.pose.q[0] += 1;
            }),
            Drop::kNotUnit);
}

TEST(Wire, ViewsRoundTripInSinglePrecision) {
  ViewFrame frame;
  frame.peer = 1;
  frame.seq = 2;
  frame.sample_ns = 3;
  frame.delay_ms = 4.5F;
  frame.mirror_lag_mm = 5.5F;
  frame.link_force = 6.5F;
  frame.V_W = {Vec3(0.5, 1.5, 2.5), Vec3(-0.5, -1.5, -2.5)};
  frame.count = kMaxViewBodies;
  const Pose X_W{RotationBy(Vec3(0.3, -0.7, 1.1)), Vec3(0.1, 0.2, 0.3)};
  for (ViewBody& body : frame.bodies) body = {6, ViewBody::kInContact, X_W, Vec3(1.1, 2, 3)};
  tandem_ViewFrame wire;
  ToWire(frame, wire);
  ViewFrame back;
  ASSERT_TRUE(Sound(wire, back));
  EXPECT_EQ(back.peer, 1U);
  EXPECT_EQ(back.seq, 2U);
  EXPECT_EQ(back.sample_ns, 3);
  EXPECT_EQ(back.delay_ms, 4.5F);
  EXPECT_EQ(back.mirror_lag_mm, 5.5F);
  EXPECT_EQ(back.link_force, 6.5F);
  EXPECT_EQ(back.V_W.w, frame.V_W.w);
  EXPECT_EQ(back.V_W.v, frame.V_W.v);
  ASSERT_EQ(back.count, kMaxViewBodies);
  const ViewBody& last = back.bodies[kMaxViewBodies - 1];
  EXPECT_EQ(last.object, 6U);
  EXPECT_EQ(last.flags, ViewBody::kInContact);
  EXPECT_LT((last.X_W.p - X_W.p).norm(), 1e-7);
  EXPECT_LT(last.X_W.q.angularDistance(X_W.q), 1e-6);
  EXPECT_NEAR(last.X_W.q.norm(), 1.0, 1e-15);
  EXPECT_LT((last.hand_force_W - Vec3(1.1, 2, 3)).norm(), 1e-6);
}

TEST(Wire, InvalidViewsAreRefused) {
  ViewFrame frame;
  frame.peer = 1;
  frame.count = 2;
  tandem_ViewFrame sound;
  ToWire(frame, sound);
  ViewFrame out;
  auto refuses = [&](auto spoil) {
    tandem_ViewFrame wire = sound;
    spoil(wire);
    return !Sound(wire, out);
  };
  const float nan = std::numeric_limits<float>::quiet_NaN();
  EXPECT_FALSE(refuses([](auto&) {}));
  EXPECT_TRUE(refuses([](auto& w) {
    w.count = kMaxViewBodies + 1;
  }));
  EXPECT_TRUE(refuses([](auto& w) {
    w.peer = 0;
  }));
  EXPECT_TRUE(refuses([&](auto& w) {
    w.delay_ms = nan;
  }));
  EXPECT_TRUE(refuses([](auto& w) {
    w.delay_ms = -1;
  }));
  EXPECT_TRUE(refuses([](auto& w) {
    w.mirror_lag_mm = -1;
  }));
  EXPECT_TRUE(refuses([](auto& w) {
    w.link_force = 1e9F;
  }));
  EXPECT_TRUE(refuses([&](auto& w) {
    w.v[1] = nan;
  }));
  EXPECT_TRUE(refuses([](auto& w) {
    w.w[2] = 1e6F;
  }));
  EXPECT_TRUE(refuses([&](auto& w) {
    w.bodies[1].p[0] = nan;
  }));
  EXPECT_TRUE(refuses([](auto& w) {
    w.bodies[1].q[3] = 0;
  }));
  EXPECT_TRUE(refuses([&](auto& w) {
    w.bodies[0].hand_force[2] = nan;
  }));
}

}  // namespace
}  // namespace tandem
