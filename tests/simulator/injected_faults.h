#pragma once

#include <cstdint>

namespace tandem {

/// Faults of sessions, one at a time. The tests check that the session simulator finds each.
enum class Fault : std::uint8_t {
  kNone,
  kLinkSign,             // a link pushes instances apart
  kEchoOfArrival,        // the receiver's time of arrival is echoed instead of the sender's stamp
  kOwnStampForTheirs,    // the own stamp is echoed
  kUsersInPlaceOfLinks,  // stiffness is divided by N instead of N - 1
  kEveryLinkWhole,       // stiffness is not divided at all
  kHalfTheDelay,         // gains are made for half the delay
  kLostGoodbye,          // goodbyes are not heard
  kLostLease,            // crashes are not heard
  kLostReturn,           // a peer that comes back stays lost to the forces
  kOneDelayForAll,       // samples of all senders share one conditioner
  kStatesDropped,        // states of one sender in four are dropped
  kLinksDropped,         // links are dropped in three of four seconds
  kDueNever,             // samples delayed by more than 100 ms come 100 s later
  kNotFinite,            // NaN is published
  kNegativeStiffness,    // in a link, once a second
  kStaleState,           // older states count as newer
  kMirrorFrozen,         // only the first state of a body moves its mirror
  kOthersName,           // links are written in the coupled peer's name
  kClaimsForgotten,      // claims of other peers are not told to the forces
  kFadeNever,            // the pull of a peer that is gone stays
  kLinkTurn,             // a link turns instances away from one another
  kGateForgets,          // the energy gate does not charge the copy's moves
  kEchoForAnother,       // an echo for another peer counts
  kStaleClaim,           // a lesser claim replaces a greater one
  kGrantKept,            // a peer that grants a body goes on answering for it
  kHandsKept,            // a peer that hears of a greater claim keeps the body in hand
  kLostRelease,          // releases to another peer are not heard, nor followed by the owner's word
  kAllSucceed,           // all peers take over at once a body that has lost its authority
  kNoListening,          // a peer does not listen after a pause
  kNoGuard,              // no guard between the simulation and the hand
  kNoParkedPose,         // no peer says where its parked bodies are
  kMirrorNotTurned,      // mirrors follow in position only
  kViewerWrites,         // a viewer publishes
  kTurnTooLong,          // quaternions of states are longer than one
  kStampOfBefore,        // a state in a hundred has a stamp 50 ms too old
  kEpochOfBefore,        // parked states are sent under the previous epoch
  kBeatStands,           // the beat of a peer's information stands still
  kEventNumberStands,    // all events of a peer have one number
  kLinkToItself,         // a peer sends links to itself
  kBodyForObject,        // states name bodies by their index among the moving bodies
  kHeldGranted,          // a peer grants the body in its hand, and keeps holding it
  kNoSuccession,         // no peer takes over a body that has lost its authority
  kBodyNotFinite,        // the checker sees a body at NaN
  kHeldSlips,            // a body in hand slips by 3 mm once a second
  kContactOff,           // bodies pass through one another
  kMirrorTrembles,       // mirrors jump by 2 mm from frame to frame
  kNoNumberFelt,         // the hand gets NaN
  kReturnUnknown,        // the directory does not note a peer's return
  kViewerKeepsLost,      // a viewer does not note a peer's return
  kFeltTenfold,          // the device gets ten times the guarded force
  kSeizureBelieved,      // a greater claim counts even if another peer has the body
  kGrantBelieved,        // grants count from peers that do not answer for the body
  kLeapBelieved,         // claims count however far ahead their epochs are
  kNeverYields,          // a peer keeps its body even if another has it too
  kCount
};

inline Fault injected_fault = Fault::kNone;

/// Returns whether the present session has this fault.
inline bool Injected(Fault fault) noexcept {
  return fault == injected_fault;
}

}  // namespace tandem
