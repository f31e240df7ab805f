#pragma once

#include <atomic>
#include <chrono>
#include <functional>

#include "engine/base/sanitized.h"

namespace tandem {

/// Takes over SIGINT, SIGTERM and SIGHUP, for a program that must end whatever it is doing: a thread
/// that does nothing else waits for them. A program that has not called StopOnSignals() ends at once;
/// another has kEndingPatience to end by itself, again after each StillEnding(), but never longer than
/// kLongestEnding in all. Then it is ended: what stands in AtForcedEnd is done, and the signal has its
/// ordinary effect. A second signal does not wait. A signal that was ignored at the start stays so,
/// but SIGINT and SIGTERM after StopOnSignals().
///
/// A reader of ours that goes away ends nothing: SIGPIPE has no effect. Once, first thing in main().
void HandleSignals();

// a sanitizer makes the end slower, too
inline constexpr std::chrono::milliseconds kEndingPatience{kIsSanitized ? 6000 : 600};
inline constexpr std::chrono::milliseconds kLongestEnding{kIsSanitized ? 30'000 : 3000};

/// Says that this program ends by itself on a signal, which sets the flag that is returned. Calls
/// HandleSignals() where nobody has.
const std::atomic<bool>& StopOnSignals();

/// Waits for a signal, so long at the most. Returns whether one has come. After StopOnSignals().
bool StopAskedWithin(std::chrono::nanoseconds time);

/// One more step of the end is done, and the next may take as long.
void StillEnding() noexcept;

/// While it lives, `act` is done before a signal ends the program by force: the newest first. It may
/// be called while any other thread is anywhere, and must not wait for one: zero force, a goodbye,
/// the removal of files.
class AtForcedEnd {
 public:
  explicit AtForcedEnd(std::function<void()> act);
  ~AtForcedEnd();
  AtForcedEnd(const AtForcedEnd&) = delete;
  AtForcedEnd& operator=(const AtForcedEnd&) = delete;
};

}  // namespace tandem
