#pragma once

#include <cerrno>
#include <chrono>
#include <cstdlib>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include <sys/stat.h>

#include "app/process/child_processes.h"

namespace tandem::testing {

/// Two networks with a router between them, and a machine in each: network namespaces of the
/// kernel, for which a program needs rights. Nothing that is sent to a multicast group gets across.
class TwoNetworks {
 public:
  static constexpr const char* kHere = "10.71.1.2";
  static constexpr const char* kThere = "10.71.2.2";

  TwoNetworks() {
    for (std::optional<ChildProcess>* machine : {&here_, &there_, &router_}) {
      Result<ChildProcess> started =
          ChildProcess::Start({"/bin/sh", "-c", "exec unshare -n sleep 1000"});
      if (!started || !IsApart(started->pid())) {
        why_not_ = "no network namespace can be made here: it takes root's rights and 'unshare'";
        return;
      }
      machine->emplace(*std::move(started));
    }
    const std::string here = std::to_string(here_->pid());
    const std::string there = std::to_string(there_->pid());
    const std::string router = std::to_string(router_->pid());
    const auto at = [](const std::string& pid, const std::string& command) {
      return "nsenter -t " + pid + " -n " + command;
    };
    for (const std::string& command :
         {"ip link add here netns " + here + " type veth peer name r1 netns " + router,
          "ip link add there netns " + there + " type veth peer name r2 netns " + router,
          at(here, "ip addr add 10.71.1.2/24 dev here"),
          at(there, "ip addr add 10.71.2.2/24 dev there"),
          at(router, "ip addr add 10.71.1.1/24 dev r1"),
          at(router, "ip addr add 10.71.2.1/24 dev r2"), at(here, "ip link set here up"),
          at(here, "ip link set lo up"), at(there, "ip link set there up"),
          at(there, "ip link set lo up"), at(router, "ip link set r1 up"),
          at(router, "ip link set r2 up"),
          at(router, "sh -c 'echo 1 >/proc/sys/net/ipv4/ip_forward'"),
          at(here, "ip route add default via 10.71.1.1"),
          at(there, "ip route add default via 10.71.2.1")}) {
      if (std::system(("( " + command + " ) >/dev/null 2>&1").c_str()) == 0) continue;
      why_not_ = "networks cannot be set up here, by: " + command;
      return;
    }
  }

  /// Returns why there are none; empty: there are.
  const std::string& why_not() const { return why_not_; }
  /// Returns the command that runs another one on one of the two machines.
  std::vector<std::string> Here(const std::vector<std::string>& command) const {
    return On(*here_, command);
  }
  std::vector<std::string> There(const std::vector<std::string>& command) const {
    return On(*there_, command);
  }

 private:
  static ino_t NetworkOf(const std::string& process) {
    struct stat status {};
    return stat(("/proc/" + process + "/ns/net").c_str(), &status) == 0 ? status.st_ino : 0;
  }
  static bool IsApart(pid_t pid) {
    for (int i = 0; i < 100; ++i) {
      const ino_t its = NetworkOf(std::to_string(pid));
      if (its != 0 && its != NetworkOf("self")) return true;
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
    }
    return false;
  }
  static std::vector<std::string> On(const ChildProcess& machine,
                                     const std::vector<std::string>& command) {
    std::vector<std::string> all{"nsenter", "-t", std::to_string(machine.pid()), "-n"};
    all.insert(all.end(), command.begin(), command.end());
    return all;
  }

  std::string why_not_;
  std::optional<ChildProcess> here_;
  std::optional<ChildProcess> there_;
  std::optional<ChildProcess> router_;
};

}  // namespace tandem::testing
