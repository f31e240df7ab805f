#pragma once

#include <array>
#include <cstdint>

#include "collab/coupling/link_views.h"
#include "collab/session/messages.h"
#include "engine/haptics/path_backtracker.h"
#include "engine/safety/safety_state.h"

namespace tandem {

/// Facts of a frame from the haptic thread for the controller's server, through a TripleBuffer. Its
/// size is fixed, for it is filled without allocating.
struct SimulationFacts {
  static constexpr std::size_t kMostBodies = 64;    // moving bodies
  static constexpr std::size_t kMostContacts = 32;  // the deepest contacts

  struct Body {
    Pose X_WB;
    std::uint32_t holder_count = 0;  // this peer included
    std::array<PeerId, kMaxPeers> holders{};
  };
  struct ContactFact {
    Vec3 p_W = Vec3::Zero();
    Vec3 n_W = Vec3::Zero();
    double depth = 0;  // m
    double force = 0;  // N
    int other = -1;    // number of the moving body that the part in hand meets; -1: a fixed one
  };

  std::uint64_t scene_number = 0;  // ControlScene::number
  std::uint64_t frame = 0;
  std::int64_t time_ns = 0;
  std::uint32_t body_count = 0;
  std::array<Body, kMostBodies> bodies{};

  // the hand; bodies by their number among the moving ones
  int wanted = -1;
  int held = -1;
  bool attached = false;
  bool goal_device = false;  // a host's goals move the hand
  std::uint32_t grasp_seq = 0;
  std::uint32_t way_seq = 0;
  PathBacktracker::State way = PathBacktracker::State::kIdle;
  int way_body = -1;
  Pose X_WG{};
  Pose requested{};
  Pose handle{};
  Wrench hand_G_W{};  // wrench of the hand on the part, about the grasped point
  double felt = 0;    // N; force given to the device
  SafetyState safety = SafetyState::kOn;
  SafetyCounts safety_counts{};

  std::uint32_t instance_count = 0;
  std::array<InstanceView, kMaxLinks> instances{};  // instances of the body in hand at other peers
  int contact_points = 0;
  std::uint32_t contact_count = 0;
  std::array<ContactFact, kMostContacts> contacts{};
};

}  // namespace tandem
