#pragma once

#include <cstdint>

namespace tandem {

/// Faults at the seams of a simulated controller, one at a time, to show that the checkers of hands
/// find them. They are in copies of collab/simulated/hands, by the patches in
/// tests/simulator/faults.
enum class HandFault : std::uint8_t {
  kNone,
  kAnswerTwice,        // some answers are given twice
  kNoAnswer,           // some answers are never given
  kAnswerUnasked,      // an answer comes without a request
  kStopUnheard,        // an emergency stop does not reach the hand
  kTakenWhileStopped,  // hosts' grabs go to the simulation during a stop
  kSilenceUnnoticed,   // the server's time stands still where it looks for silent hosts
  kHoldForgotten,      // the goal of a silent host is not held
  kForeignGoals,       // other hosts' goals count as those of the host that has the hand
  kForeignRequests,    // other hosts' grabs count as those of the host that has the hand
  kGoalWanders,        // the goal moves without a host's message
  kGoalsLost,          // poses do not reach the hand
  kHugeGoal,           // a goal that is no place gets through
  kNoLead,             // the force limit is ten times the requested one
  kNoSpeed,            // a part seems five times as fast as it is
  kTurnsAhead,         // the handle is turned by a third of a turn
  kHandPushes,         // the hand gets a wrench that no coupling gives
  kWayToNowhere,       // the answer to a way back is always ok
  kSlipsWhenLetGo,     // a released body moves on by itself
  kNoSnapshots,        // hosts get none
  kSnapshotStands,     // the first snapshot is sent again and again
  kBodyElsewhere,      // a body is shown a millimetre beside its place
  kBodyMissing,        // a snapshot lacks a body
  kSnapshotNoNumber,   // a pose in a snapshot is not a number
  kHolderMissing,      // snapshots show no holders
  kMotorTenfold,       // the motor gets ten times the guard's wrench
  kMotorJumps,         // the motor's force changes its sign from tick to tick
  kMotorNoNumber,      // the motor's wrench is not a number
  kMotorKeeps,         // the motor keeps the force that it had when orders ceased
  kMotorPushesOn,      // instead of damping, the motor pushes in the direction of the hand's motion
  kMotorAfterStop,     // the motor has force during a stop
  kMotorAfterFault,    // the motor has force after a fault of the driver
  kMotorAtOnce,        // the motor has force without a ramp-in
  kMotorTooFast,       // the motor has force however fast the handle is
  kCount
};

/// The fault of the present session.
inline HandFault injected_hand_fault = HandFault::kNone;

/// Returns whether the present session has this fault.
inline bool Injected(HandFault fault) noexcept {
  return fault == injected_hand_fault;
}

}  // namespace tandem
