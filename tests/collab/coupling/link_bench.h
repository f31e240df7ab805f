#pragma once

#include <array>

#include <gtest/gtest.h>

#include "collab/coupling/shared_body.h"
#include "engine/base/units.h"
#include "engine/world/world.h"

namespace tandem::testing {

inline constexpr PeerId kMe = 1;
inline constexpr PeerId kOther = 2;
inline constexpr ObjectId kObject = 3;

/// Runs our end of a link, with a partner of which each test says what it sends.
struct LinkBench {
  explicit LinkBench(const SharedBody::Options& options = {*MakeLaw("p+d")})
      : body(kMe, kObject, {0.3, 1e-4 * Mat3::Identity()}, options) {
    inputs.instances.resize(1);
    for (int i = 0; i < 3000; ++i) Alone();  // sent stamps may be echoed
  }

  /// Runs a frame in which nothing comes.
  void Alone() {
    now += kMs;
    body.Prepare(now, own, inputs);
    body.Describe(now, ++frame, report, out);
  }

  /// Runs a frame with the partner's state, held still at `place`. The state echoes our stamp of
  /// `loop_ms` ago.
  void Frame(double place_m, std::int64_t loop_ms, double its_stiffness, bool received = true) {
    if (!received) return Alone();
    Hear(kOther, place_m, loop_ms, its_stiffness);
    Alone();
  }

  void Hear(PeerId peer, double place_m, std::int64_t loop_ms, double its_stiffness) {
    ++seq;
    const std::int64_t then = now + kMs;
    received_ns = then;
    ObjectState state;
    state.peer = peer;
    state.object = kObject;
    state.epoch = 1;
    state.seq = seq;
    state.sample_ns = 7'000'000'000 + then;  // another clock
    state.X_WB.p.x() = place_m;
    state.V_WB.v.x() = its_speed;
    state.V_WB.w.x() = its_turning;
    body.OnState(state);
    CouplingLinks links;
    links.from = peer;
    links.object = kObject;
    links.seq = seq;
    links.count = 1;
    links.entries[0] = {
        .to = kMe, .echo_ns = then - loop_ms * kMs, .stiffness = its_stiffness, .applied_B_W = {}};
    links.entries[0].applied_B_W.f.x() = its_force;
    body.OnLinks(links);
  }
  /// Returns the energy of the one link's gate, J.
  double tank() const {
    std::array<LinkView, kMaxLinks> views;
    EXPECT_EQ(body.Links(now, views), 1U);
    return views[0].tank;
  }
  double stiffness() const {
    return inputs.link_count == 0 ? 0.0 : inputs.links[0].gains.stiffness;
  }

  double its_force = 0;    // N; force that the partner says is on its instance
  double its_speed = 0;    // m/s; speed of its instance
  double its_turning = 0;  // rad/s
  SharedBody body;
  RigidState own;
  StepInputs inputs;
  StepReport report;
  CouplingLinks out;
  std::uint32_t frame = 0;
  std::int64_t now = 1000 * kMs;
  std::int64_t received_ns = 0;  // time at which a partner was heard last
  std::uint32_t seq = 0;
};

}  // namespace tandem::testing
