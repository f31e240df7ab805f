#pragma once

#include <atomic>
#include <chrono>
#include <functional>

#include "engine/base/sanitized.h"

namespace tandem {

/// Handles SIGINT, SIGTERM and SIGHUP in a thread of its own, so that the program ends whatever its
/// other threads do. Without StopOnSignals() the signal ends the program at once. With it the
/// program has kEndingPatience to end by itself, again after each SayStillEnding(), and
/// kLongestEnding in all. A second signal ends this time, if it comes kSecondSignal after the first
/// or later: a program such as timeout(1) sends one request as two signals.
///
/// When the time is over, the thread runs the acts of AtForcedEnd, and the signal has its ordinary
/// effect. A signal that was ignored at the start stays ignored, except SIGINT and SIGTERM after
/// StopOnSignals(). SIGPIPE has no effect, so a reader that goes away does not end the program.
///
/// Called once, at the beginning of main().
void HandleSignals();

// longer with a sanitizer, which slows the end too
inline constexpr std::chrono::milliseconds kEndingPatience{kIsSanitized ? 6000 : 600};
inline constexpr std::chrono::milliseconds kLongestEnding{kIsSanitized ? 30'000 : 3000};
inline constexpr std::chrono::milliseconds kSecondSignal{300};

/// Declares that this program ends by itself on a signal. Returns the flag that the signal sets.
/// Calls HandleSignals() first.
const std::atomic<bool>& StopOnSignals();

/// Waits up to `time` for a signal. Returns whether a signal has come. Needs StopOnSignals().
bool StopRequestedWithin(std::chrono::nanoseconds time);

/// Tells the thread of signals that a step of the end is done; the next may take kEndingPatience.
void SayStillEnding() noexcept;

/// Has `act` run before a signal ends the program by force, as long as this object lives. The
/// newest act runs first. An act runs while other threads are at any point, and must not wait for
/// them. Acts set zero force, say goodbye, or remove files.
class AtForcedEnd {
 public:
  explicit AtForcedEnd(std::function<void()> act);
  ~AtForcedEnd();
  AtForcedEnd(const AtForcedEnd&) = delete;
  AtForcedEnd& operator=(const AtForcedEnd&) = delete;
};

}  // namespace tandem
