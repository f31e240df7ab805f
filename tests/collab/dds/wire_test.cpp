#include "collab/dds/wire.h"

#include <limits>

#include <gmock/gmock.h>

namespace tandem {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinity = std::numeric_limits<double>::infinity();

template <typename Wire, typename Message>
bool Sound(const Wire& wire, Message& message) {
  return !FromWire(wire, message).has_value();
}

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

TEST(Wire, AStateComesBackAsItWas) {
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

TEST(Wire, QuaternionsGoAsXyzw) {
  ObjectState state;
  state.X_WB.q = Quat(0.8, 0, 0.6, 0);  // Eigen's order here is w first
  tandem_ObjectState wire;
  ToWire(state, wire);
  EXPECT_THAT(wire.pose.q, ::testing::ElementsAre(0, 0.6, 0, 0.8));
}

TEST(Wire, AStateWithANumberThatIsNotFiniteIsRefused) {
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

TEST(Wire, AQuaternionOffUnitLengthIsRefused) {
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

TEST(Wire, LinksComeBackAsTheyWereBesideTheirState) {
  const LinkedState said = FullLinks();
  tandem_LinkedState wire;
  ToWire(said, wire);
  LinkedState heard;
  ASSERT_TRUE(Sound(wire, heard));
  EXPECT_EQ(heard.state.peer, said.state.peer);
  EXPECT_EQ(heard.state.seq, said.state.seq);
  EXPECT_EQ(heard.state.X_WB.p, said.state.X_WB.p);
  EXPECT_EQ(heard.state.contact_B_W.f, said.state.contact_B_W.f);
  const CouplingLinks& back = heard.links;
  EXPECT_EQ(back.from, said.state.peer);
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

TEST(Wire, UnsoundLinksAreRefused) {
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
  // what lies beyond the count is not looked at
  EXPECT_FALSE(refuses([](auto& w) {
    w.count = 7, w.entries[7].applied.f[2] = kInfinity;
  }));
}

TEST(Wire, AStateBesideLinksIsJudgedAsAlone) {
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

TEST(Wire, AViewComesBackInSinglePrecision) {
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

TEST(Wire, UnsoundViewsAreRefused) {
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

TEST(Wire, PeerInfoComesBackAsItWas) {
  const PeerInfo info{3,        kProtocol, 9,  Role::kViewer,
                      "Żaneta", 77,        78, {{1, 2, true}, {5, 0, false}}};
  tandem_PeerInfo wire{};
  std::vector<tandem_Claim> room;
  ASSERT_TRUE(ToWire(info, wire, room));
  PeerInfo back;
  ASSERT_TRUE(FromWire(wire, back));
  EXPECT_EQ(back.peer, 3U);
  EXPECT_EQ(back.protocol, kProtocol);
  EXPECT_EQ(back.beat, 9U);
  EXPECT_EQ(back.role, Role::kViewer);
  EXPECT_EQ(back.name, "Żaneta");
  EXPECT_EQ(back.scene_hash, 77U);
  EXPECT_EQ(back.params_hash, 78U);
  EXPECT_EQ(back.claims, info.claims);
}

TEST(Wire, LongNamesAreCutBetweenCharacters) {
  PeerInfo info;
  info.peer = 1;
  info.name =
      std::string(63, 'a') + "Ż";  // 65 bytes; 64 fit, and would hold half of the last letter
  tandem_PeerInfo wire{};
  std::vector<tandem_Claim> room;
  ASSERT_TRUE(ToWire(info, wire, room));
  EXPECT_EQ(std::string(wire.name), std::string(63, 'a'));
}

TEST(Wire, NamesCannotSteerATerminal) {
  PeerInfo info;
  info.peer = 1;
  info.name = "a\x1b[2Jb\n";
  tandem_PeerInfo wire{};
  std::vector<tandem_Claim> room;
  ASSERT_TRUE(ToWire(info, wire, room));
  PeerInfo back;
  ASSERT_TRUE(FromWire(wire, back));
  EXPECT_EQ(back.name, "a?[2Jb?");
}

TEST(Wire, PeerInfoBeyondTheBoundIsNotSentNorTaken) {
  PeerInfo info;
  info.peer = 1;
  info.claims.resize(65);
  tandem_PeerInfo wire{};
  std::vector<tandem_Claim> room;
  EXPECT_FALSE(ToWire(info, wire, room));
  info.claims.resize(64);
  ASSERT_TRUE(ToWire(info, wire, room));
  PeerInfo back;
  EXPECT_TRUE(FromWire(wire, back));
  wire.claims._length = 65;
  EXPECT_FALSE(FromWire(wire, back));
}

TEST(Wire, AnEventComesBackAsItWas) {
  Event event;
  event.peer = 3;
  event.seq = 4;
  event.kind = EventKind::kRelease;
  event.object = 5;
  event.epoch = 6;
  event.to = 7;
  event.X_WB = {Quat(0.5, 0.5, -0.5, 0.5), Vec3(1, 2, 3)};
  tandem_Event wire{};
  ToWire(event, wire);
  Event back;
  ASSERT_TRUE(FromWire(wire, back));
  EXPECT_EQ(back.peer, 3U);
  EXPECT_EQ(back.seq, 4U);
  EXPECT_EQ(back.kind, EventKind::kRelease);
  EXPECT_EQ(back.object, 5U);
  EXPECT_EQ(back.epoch, 6U);
  EXPECT_EQ(back.to, 7U);
  EXPECT_EQ(back.X_WB.p, Vec3(1, 2, 3));
  EXPECT_EQ(back.X_WB.q.coeffs(), event.X_WB.q.coeffs());
}

TEST(Wire, UnsoundEventsAreRefused) {
  Event event;
  event.peer = 3;
  Event out;
  tandem_Event wire{};
  ToWire(event, wire);
  EXPECT_TRUE(FromWire(wire, out));
  wire.pose.p[1] = kNan;
  EXPECT_FALSE(FromWire(wire, out));
  ToWire(event, wire);
  wire.peer = 0;
  EXPECT_FALSE(FromWire(wire, out));
}

SceneManifest Bracket() {
  SceneManifest manifest;
  manifest.offered_by = 9;
  manifest.revision = 2;
  manifest.content_hash = 8;
  manifest.name = "bracket";
  manifest.file = "/tmp/b.json";
  manifest.voxel_size = 0.002;
  manifest.contact_stiffness = 750;
  manifest.force_layer = 2;
  manifest.contact_model = 1;
  manifest.friction = 0.25;
  manifest.bodies = {{"plate", 11, 13}, {"bracket", 12, 14}};
  return manifest;
}

TEST(Wire, AManifestComesBackAsItWas) {
  tandem_SceneManifest wire{};
  std::vector<tandem_BodyDecl> room;
  ASSERT_TRUE(ToWire(Bracket(), wire, room));
  SceneManifest back;
  ASSERT_TRUE(FromWire(wire, back));
  EXPECT_EQ(back.offered_by, 9U);
  EXPECT_EQ(back.revision, 2U);
  EXPECT_EQ(back.content_hash, 8U);
  EXPECT_EQ(back.name, "bracket");
  EXPECT_EQ(back.file, "/tmp/b.json");
  EXPECT_EQ(back.voxel_size, 0.002);
  EXPECT_EQ(back.contact_stiffness, 750);
  EXPECT_EQ(back.force_layer, 2);
  EXPECT_EQ(back.contact_model, 1);
  EXPECT_EQ(back.friction, 0.25);
  EXPECT_EQ(back.bodies, Bracket().bodies);
}

TEST(Wire, AFileNameTooLongIsLeftOut) {
  SceneManifest manifest = Bracket();
  manifest.file = std::string(2000, 'f');
  tandem_SceneManifest wire{};
  std::vector<tandem_BodyDecl> room;
  ASSERT_TRUE(ToWire(manifest, wire, room));
  EXPECT_EQ(std::string(wire.file), "");
}

TEST(Wire, AManifestThatNoSoundPeerSendsIsRefused) {
  SceneManifest out;
  std::vector<tandem_BodyDecl> room;
  for (const double size : {0.0, -1.0, kNan, kInfinity}) {
    SceneManifest manifest = Bracket();
    manifest.voxel_size = size;
    tandem_SceneManifest wire{};
    ASSERT_TRUE(ToWire(manifest, wire, room));
    EXPECT_FALSE(FromWire(wire, out)) << size;
  }
  for (const auto& [layer, model] : {std::pair{-1, 1}, {1000, 1}, {1, 2}}) {
    SceneManifest manifest = Bracket();
    manifest.force_layer = layer;
    manifest.contact_model = static_cast<std::uint8_t>(model);
    tandem_SceneManifest wire{};
    ASSERT_TRUE(ToWire(manifest, wire, room));
    EXPECT_FALSE(FromWire(wire, out)) << layer << " " << model;
  }
  SceneManifest crowded = Bracket();
  crowded.bodies.resize(kMaxSceneBodies + 1);
  tandem_SceneManifest wire{};
  EXPECT_FALSE(ToWire(crowded, wire, room));
}

}  // namespace
}  // namespace tandem
