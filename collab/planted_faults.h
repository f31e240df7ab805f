#pragma once

#include <cstdint>

namespace tandem {

/// Faults that the tests of the session simulator plant, one at a time, to see that it finds them.
/// In the product Planted() is false for the compiler, and nothing of them is left.
enum class Fault : std::uint8_t {
  kNone,
  kLinkSign,             // a link pushes instances apart
  kEchoOfArrival,        // the time of hearing is sent back in place of the sender's stamp
  kOwnStampForTheirs,    // the own stamp is sent back
  kUsersInPlaceOfLinks,  // stiffness is shared by N, not by N - 1
  kEveryLinkWhole,       // stiffness is not shared at all
  kHalfTheDelay,         // gains made for half the delay
  kLostGoodbye,          // leaving is not heard of
  kLostLease,            // a crash is not heard of
  kLostReturn,           // who comes back stays lost to the forces
  kOneDelayForAll,       // samples of all senders wait in one row
  kStatesDropped,        // states of one sender in four are thrown away
  kLinksDropped,         // links are thrown away once some have come
  kDueNever,             // the time at which samples are due is never reached again after a pause
  kNotFinite,            // not a number in what is published
  kNegativeStiffness,    // of a link on its first frames
  kStaleState,           // older states count as newer
  kMirrorFrozen,         // only the first state of a body moves its mirror
  kOthersName,           // links are written in the partner's name
  kClaimsForgotten,      // what another holds is not told to the forces
  kFadeNever,            // the pull of one who is gone stays
  kLinkTurn,             // a link turns instances away from one another
  kGateForgets,          // what energy a copy's way has cost is not noted
  kEchoForAnother,       // an echo that is meant for another peer counts
  kStaleClaim,           // a smaller claim counts in place of a greater one
  kGrantKept,            // who grants a body goes on to answer for it
  kHandsKept,            // who hears of a greater claim keeps the body in hand
  kLostRelease,          // hand-overs by letting go are not heard of, nor told of by words
  kAllSucceed,           // all take over at once what nobody answers for
  kNoListening,          // no silence after a pause
  kNoGuard,              // nothing between the simulation and the hand
  kNoParkedPose,         // bodies that nobody holds are not said to be anywhere
  kMirrorNotTurned,      // mirrors follow in place alone
  kViewerWrites,         // a viewer publishes
  kTurnTooLong,          // quaternions of states are longer than one
  kStampOfBefore,        // a state in a hundred has the stamp of an earlier one
  kEpochOfBefore,        // a parked body is told of under the epoch before its own
  kBeatStands,           // the beat of a peer's information does not go on
  kEventNumberStands,    // all events of a peer have one number
  kLinkToItself,         // a peer tells of a link to itself
  kBodyForObject,        // states name bodies by their place among those that move
  kHeldGranted,          // a peer grants what it has in hand, and holds on
  kNoSuccession,         // nobody takes over what has no authority
  kBodyNotFinite,        // a body leaves the numbers for a frame
  kHeldSlips,            // a body in hand slips by 3 mm now and then
  kContactOff,           // bodies pass through one another
  kMirrorTrembles,       // mirrors jump by 2 mm from frame to frame
  kNoNumberFelt,         // the hand gets what is not a number
  kReturnUnknown,        // the directory does not note a peer's return
  kViewerKeepsLost,      // a viewer does not note a peer's return
  kFeltTenfold,          // the device makes ten times of what it is given
  kSeizureBelieved,      // a greater claim counts whoever has the body
  kGrantBelieved,        // grants of those count who do not answer for the body
  kLeapBelieved,         // claims count however far ahead they are
  kNeverYields,          // who has a body keeps it, whoever else has it
  kCount
};

#ifdef TANDEM_PLANTED_FAULTS
inline Fault planted_fault = Fault::kNone;
inline bool Planted(Fault fault) noexcept {
  return fault == planted_fault;
}
#else
constexpr bool Planted(Fault) noexcept {
  return false;
}
#endif

}  // namespace tandem
