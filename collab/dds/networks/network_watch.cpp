#include "collab/dds/networks/network_watch.h"

#include <algorithm>
#include <array>
#include <ctime>
#include <mutex>

#include <linux/netlink.h>
#include <linux/rtnetlink.h>
#include <poll.h>
#include <pthread.h>
#include <sys/socket.h>

#include "collab/dds/networks/live_domains.h"
#include "collab/dds/networks/network_table.h"
#include "engine/base/units.h"
#include "engine/realtime/clock.h"

namespace tandem {
namespace {

// A peer's memory is locked, so a thread costs its whole stack.
constexpr std::size_t kStackBytes = 256U << 10U;
constexpr int kTurnMs = 500;
// Changes come in groups: an address goes before the next one comes.
constexpr int kSettleMs = 200;
constexpr std::int64_t kLongestSettleNs = kSecondNs;

std::int64_t NowWithSleep_ns() {
  timespec now{};
  clock_gettime(CLOCK_BOOTTIME, &now);
  return std::int64_t{now.tv_sec} * kSecondNs + now.tv_nsec;
}

// The kernel's messages about interfaces and addresses.
class ChangeSocket {
 public:
  ChangeSocket() : handle_(socket(AF_NETLINK, SOCK_RAW | SOCK_CLOEXEC, NETLINK_ROUTE)) {
    sockaddr_nl own{};
    own.nl_family = AF_NETLINK;
    own.nl_groups = RTMGRP_LINK | RTMGRP_IPV4_IFADDR;
    bind(handle_, reinterpret_cast<const sockaddr*>(&own), sizeof own);
  }
  /// Returns whether something has changed within that time.
  bool Changed(int wait_ms) const {
    pollfd wait{handle_, POLLIN, 0};
    if (poll(&wait, 1, wait_ms) <= 0) return false;
    // the table of networks tells what has changed
    std::array<char, 8192> unread;
    while (recv(handle_, unread.data(), unread.size(), MSG_DONTWAIT) > 0) {
    }
    return true;
  }
  /// Waits until changes have come to rest.
  void Settle() const {
    const std::int64_t until_ns = MonotonicNowNs() + kLongestSettleNs;
    while (Changed(kSettleMs) && MonotonicNowNs() < until_ns) {
    }
  }

 private:
  int handle_;
};

void TakeChange(std::int64_t now_ns, bool cut_all) {
  const NetworkTable before = CurrentNetworks();
  const bool changed = RefreshNetworks();
  if (!changed && !cut_all) return;
  ForEachLiveDomain([&](DomainNetworks& domain) {
    if (domain.reach() == DomainNetworks::Reach::kLoopback) return;
    const bool lost = changed && domain.OnChange(before, CurrentNetworks(), now_ns);
    if (lost || cut_all) domain.Cut(now_ns + kCutNs);
  });
}

[[noreturn]] void Watch(const ChangeSocket& changes) {
  PauseDetector pauses(MonotonicNowNs(), NowWithSleep_ns());
  for (;;) {
    const bool changed = changes.Changed(kTurnMs);
    if (changed) changes.Settle();
    const std::int64_t now_ns = MonotonicNowNs();
    const bool paused = pauses.Paused(now_ns, NowWithSleep_ns());
    if (changed || paused) TakeChange(now_ns, paused);
  }
}

}  // namespace

bool PauseDetector::Paused(std::int64_t monotonic_ns, std::int64_t with_sleep_ns) {
  const std::int64_t turn_ns =
      std::max(monotonic_ns - monotonic_ns_, with_sleep_ns - with_sleep_ns_);
  monotonic_ns_ = monotonic_ns;
  with_sleep_ns_ = with_sleep_ns;
  return turn_ns > kLongestTurnNs;
}

void WatchNetworks() {
  static std::once_flag once;
  std::call_once(once, [] {
    // neither ends before the process
    static const auto& changes = *new ChangeSocket;
    RefreshNetworks();  // changes before this socket are in no message
    pthread_attr_t attributes;
    pthread_attr_init(&attributes);
    pthread_attr_setstacksize(&attributes, kStackBytes);
    pthread_attr_setdetachstate(&attributes, PTHREAD_CREATE_DETACHED);
    pthread_t thread{};
    pthread_create(
        &thread, &attributes,
        [](void*) -> void* {
          pthread_setname_np(pthread_self(), "networks");
          Watch(changes);
        },
        nullptr);
    pthread_attr_destroy(&attributes);
  });
}

}  // namespace tandem
