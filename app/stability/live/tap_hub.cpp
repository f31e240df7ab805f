#include "app/stability/live/tap_hub.h"

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <cstdio>
#include <cstring>
#include <map>
#include <optional>
#include <utility>

#include <fcntl.h>
#include <linux/if.h>
#include <linux/if_tun.h>
#include <poll.h>
#include <pthread.h>
#include <sys/ioctl.h>
#include <sys/prctl.h>
#include <sys/stat.h>
#include <unistd.h>

#include "app/process/child_processes.h"
#include "engine/realtime/clock.h"

namespace tandem {

namespace {

constexpr const char* kIp = "/usr/sbin/ip";
constexpr std::size_t kLongestFrame = 2048;  // bytes of an Ethernet frame
constexpr int kBurst = 64;                   // frames of a port in a row

/// Runs `ip WORDS` to its end. Returns whether it succeeded.
bool Ip(std::vector<std::string> words) {
  words.insert(words.begin(), kIp);
  Result<ChildProcess> ip = ChildProcess::Start(words);
  return ip && ip->Wait(std::chrono::seconds(10)) == 0;
}

/// The frames under way, ordered by due time and then by arrival.
using UnderWay = std::multimap<std::int64_t, std::pair<std::size_t, std::vector<char>>>;

}  // namespace

Result<std::unique_ptr<TapHub>> TapHub::Open(std::size_t ports, const Conditions& conditions) {
  if (geteuid() != 0) return Error{"a network of its own needs root"};
  struct stat found {};
  if (stat(kIp, &found) != 0) return Error{"a network of its own needs the package iproute2"};
  std::unique_ptr<TapHub> hub(new TapHub);
  for (std::size_t port = 0; port < ports; ++port) {
    if (const auto fault = hub->AddPort()) return *fault;
  }
  for (std::size_t from = 0; from < ports; ++from) {
    for (std::size_t to = 0; to < ports; ++to) {
      hub->links_.emplace_back(from == to ? LinkConditions{} : conditions(from, to), from);
    }
  }
  hub->thread_ = std::thread([raw = hub.get()] {
    raw->Run();
  });
  // with this priority, where permitted, no packet waits for a core, as none does in a network
  const sched_param before_ordinary_threads{.sched_priority = 1};
  pthread_setschedparam(hub->thread_.native_handle(), SCHED_FIFO, &before_ordinary_threads);
  return hub;
}

std::optional<Error> TapHub::AddPort() {
  const std::string number = std::to_string(ports_.size() + 1);
  const std::string own = "tandem" + std::to_string(getpid()) + "-" + number;
  if (!Ip({"netns", "add", own})) return Error{"no network namespace can be made here"};
  Port& port = ports_.emplace_back();
  port.space = own;
  port.descriptor = open("/dev/net/tun", O_RDWR | O_NONBLOCK | O_CLOEXEC);
  ifreq wanted{};
  std::snprintf(wanted.ifr_name, sizeof wanted.ifr_name, "tt%.5d-%.3s", getpid() % 100000,
                number.c_str());
  wanted.ifr_flags = IFF_TAP | IFF_NO_PI;
  if (port.descriptor < 0 || ioctl(port.descriptor, TUNSETIFF, &wanted) != 0) {
    return Error{std::string("/dev/net/tun: ") + std::strerror(errno)};
  }
  const std::string name = wanted.ifr_name;
  const bool made =
      Ip({"link", "set", name, "netns", own}) &&
      Ip({"-n", own, "link", "set", name, "name", kInterface}) &&
      Ip({"-n", own, "addr", "add", "10.78.0." + number + "/24", "dev", kInterface}) &&
      Ip({"-n", own, "link", "set", kInterface, "up", "multicast", "on"}) &&
      Ip({"-n", own, "link", "set", "lo", "up"});
  if (!made) return Error{"the network of port " + number + " cannot be set up"};
  return std::nullopt;
}

TapHub::~TapHub() {
  stop_ = true;
  if (thread_.joinable()) thread_.join();
  for (const Port& port : ports_) {
    if (port.descriptor >= 0) close(port.descriptor);
    Ip({"netns", "del", port.space});
  }
}

void TapHub::Switch(std::size_t from, std::size_t to, const LinkConditions& conditions) {
  const std::lock_guard lock(mutex_);
  links_[from * ports_.size() + to].Switch(conditions);
}

std::vector<std::string> TapHub::At(std::size_t port, std::vector<std::string> command) const {
  command.insert(command.begin(), {kIp, "netns", "exec", ports_[port].space});
  return command;
}

void TapHub::Run() {
  prctl(PR_SET_TIMERSLACK, 1, 0, 0, 0);
  UnderWay under_way;
  std::vector<pollfd> polled;
  for (const Port& port : ports_) polled.push_back({port.descriptor, POLLIN, 0});
  std::array<char, kLongestFrame> frame{};
  while (!stop_) {
    constexpr std::int64_t kLongestWait = 50'000'000;
    std::int64_t wait_ns = kLongestWait;
    if (!under_way.empty()) {
      wait_ns = std::clamp<std::int64_t>(under_way.begin()->first - MonotonicNowNs(), 0, wait_ns);
    }
    const timespec timeout{0, wait_ns};
    ppoll(polled.data(), polled.size(), &timeout, nullptr);
    for (std::size_t from = 0; from < ports_.size(); ++from) {
      for (int i = 0; i < kBurst; ++i) {
        const ssize_t size = read(ports_[from].descriptor, frame.data(), frame.size());
        if (size <= 0) break;
        const std::int64_t now_ns = MonotonicNowNs();
        const std::lock_guard lock(mutex_);
        for (std::size_t to = 0; to < ports_.size(); ++to) {
          if (to == from) continue;
          std::array<std::int64_t, 2> due_ns{};
          const std::size_t copies = links_[from * ports_.size() + to].Due(now_ns, due_ns);
          if (copies == 0) ++lost_;
          for (std::size_t copy = 0; copy < copies; ++copy) {
            under_way.emplace(due_ns[copy],
                              std::pair(to, std::vector<char>(frame.data(), frame.data() + size)));
          }
        }
      }
    }
    const std::int64_t now_ns = MonotonicNowNs();
    while (!under_way.empty() && under_way.begin()->first <= now_ns) {
      const auto& [to, bytes] = under_way.begin()->second;
      // a port whose queue is full loses the frame, as a network card does
      const ssize_t written = write(ports_[to].descriptor, bytes.data(), bytes.size());
      (written < 0 ? lost_ : carried_) += 1;
      under_way.erase(under_way.begin());
    }
  }
}

}  // namespace tandem
