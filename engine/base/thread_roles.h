#pragma once

#if defined(__clang__)
#define TANDEM_TSA(x) __attribute__((x))
#else
#define TANDEM_TSA(x)
#endif

namespace tandem {

/// A thread's role. clang's -Wthread-safety treats it as a lock that the thread holds for its whole
/// life.
class TANDEM_TSA(capability("thread role")) ThreadRole {
 public:
  /// Must be the first statement of that thread's main function.
  void Enter() const TANDEM_TSA(assert_capability(this)) {}
};

inline constexpr ThreadRole kHapticThread;
inline constexpr ThreadRole kSenderThread;
inline constexpr ThreadRole kReceiveThread;
inline constexpr ThreadRole kControlThread;

}  // namespace tandem

#define TANDEM_RUNS_ON(role) TANDEM_TSA(requires_capability(role))
