#include "tests/network/networks/machines.h"

#include <chrono>
#include <cstdlib>
#include <thread>

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sched.h>
#include <sys/stat.h>
#include <unistd.h>

namespace tandem::testing {
namespace {

ino_t NetworkOf(const std::string& process) {
  struct stat status {};
  return stat(("/proc/" + process + "/ns/net").c_str(), &status) == 0 ? status.st_ino : 0;
}

bool IsApart(pid_t pid) {
  for (int i = 0; i < 500; ++i) {
    const ino_t its = NetworkOf(std::to_string(pid));
    if (its != 0 && its != NetworkOf("self")) return true;
    std::this_thread::sleep_for(std::chrono::milliseconds(2));
  }
  return false;
}

}  // namespace

Machine::Machine() {
  Result<ChildProcess> started =
      ChildProcess::Start({"/bin/sh", "-c", "exec unshare -n sleep 1000"});
  if (!started || !IsApart(started->pid())) {
    why_not_ = "no network namespace can be made here: it takes root's rights and 'unshare'";
    return;
  }
  process_.emplace(*std::move(started));
  if (!Run("ip link set lo up")) why_not_ = "'ip' does not work here";
}

bool Machine::Run(const std::string& lines) const {
  const std::string command = "nsenter -t " + pid() + " -n sh -ec '" + lines + "' >/dev/null 2>&1";
  return std::system(command.c_str()) == 0;
}

std::vector<std::string> Machine::At(const std::vector<std::string>& command) const {
  std::vector<std::string> all{"nsenter", "-t", pid(), "-n"};
  all.insert(all.end(), command.begin(), command.end());
  return all;
}

void Machine::Within(const std::function<void()>& work) const {
  std::thread([&] {
    const int space = open(("/proc/" + pid() + "/ns/net").c_str(), O_RDONLY | O_CLOEXEC);
    ASSERT_GE(space, 0);
    ASSERT_EQ(setns(space, CLONE_NEWNET), 0);
    close(space);
    work();
  }).join();
}

bool Link(const Machine& a, const std::string& name_a, const Machine& b,
          const std::string& name_b) {
  const std::string command = "ip link add " + name_a + " netns " + a.pid() +
                              " type veth peer name " + name_b + " netns " + b.pid() +
                              " >/dev/null 2>&1";
  return std::system(command.c_str()) == 0;
}

}  // namespace tandem::testing
