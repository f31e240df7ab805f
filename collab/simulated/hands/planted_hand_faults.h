#pragma once

#include <cstdint>

namespace tandem {

/// Faults that the tests plant at the seams of a simulated controller, one at a time, to see that
/// the checkers of hands find them. In the product PlantedInHand() is false for the compiler, and
/// nothing of them is left.
enum class HandFault : std::uint8_t {
  kNone,
  kAnswerTwice,        // some answers are given twice
  kNoAnswer,           // some answers are never given
  kAnswerUnasked,      // an answer comes to nobody's request
  kStopUnheard,        // an emergency stop does not reach the hand
  kTakenWhileStopped,  // hosts' grabs go on to the simulation during a stop
  kSilenceUnnoticed,   // time stands still for the server where it looks for silent hosts
  kHoldForgotten,      // a goal of a silent host is not held
  kForeignGoals,       // other hosts' goals count as those of the host that has the hand
  kForeignRequests,    // other hosts' grabs count as its own
  kGoalWanders,        // the goal moves on without a word
  kGoalsLost,          // poses do not reach the hand
  kHugeGoal,           // a goal that is no place gets through
  kNoLead,             // the force limit is ten times as large as was asked for
  kNoSpeed,            // a part goes five times as fast as it does
  kTurnsAhead,         // the handle is turned by a third of a turn
  kHandPushes,         // a wrench that no coupling gives
  kWayToNowhere,       // the answer to a way back is always ok
  kSlipsWhenLetGo,     // a body that was let go of goes on by itself
  kNoSnapshots,        // hosts see none
  kSnapshotStands,     // the first snapshot is sent for ever
  kBodyElsewhere,      // a body is shown a millimetre beside its place
  kBodyMissing,        // a snapshot has a body less
  kSnapshotNoNumber,   // a pose in it is not a number
  kHolderMissing,      // nobody holds anything, by the snapshots
  kMotorTenfold,       // the motor gets ten times of what the guard lets through
  kMotorJumps,         // the motor's force changes its sign from tick to tick
  kMotorNoNumber,      // what the motor gets is not a number
  kMotorKeeps,         // the motor keeps the force that it had when orders ceased
  kMotorPushesOn,      // in place of damping it is pushed where the hand goes
  kMotorAfterStop,     // it has force during a stop
  kMotorAfterFault,    // or after a fault of the driver
  kMotorAtOnce,        // it has force without a ramp-in
  kMotorTooFast,       // it has force however fast the handle is
  kCount
};

#ifdef TANDEM_PLANTED_HAND_FAULTS
inline HandFault planted_hand_fault = HandFault::kNone;
inline bool PlantedInHand(HandFault fault) noexcept {
  return fault == planted_hand_fault;
}
#else
constexpr bool PlantedInHand(HandFault) noexcept {
  return false;
}
#endif

}  // namespace tandem
