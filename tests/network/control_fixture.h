#pragma once

#include <chrono>
#include <optional>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <unistd.h>

#include "app/process/child_processes.h"
#include "collab/controller/controller.h"

namespace tandem::testing {

/// Lets the host hear its controller until `done`, or for a minute. Returns whether it is done.
template <class Condition>
bool HearUntil(Controller& host, const Condition& done) {
  const auto until = std::chrono::steady_clock::now() + std::chrono::minutes(1);
  while (!done() && std::chrono::steady_clock::now() < until) {
    host.Wait(std::chrono::milliseconds(50));
  }
  return done();
}

/// A controller in a process of its own, and hosts in the test's.
class ControlTest : public ::testing::Test {
 protected:
  ControlTest() {
    // controllers of this test alone; CTest runs each test in a process of its own
    setenv("XDG_RUNTIME_DIR", folder_.path().c_str(), 1);  // NOLINT(concurrency-mt-unsafe)
  }
  void Start(std::vector<std::string> more = {}) {
    std::vector<std::string> words{
        TANDEM_PROGRAM, "peer",      "--session",
        name_,          "--scene",   std::string(TANDEM_SCENES) + "/peg_in_slot.json",
        "--interface",  "lo",        "--name",
        "anna",         "--control", name_,
        "--capacity",   "20000",     "--brief"};
    words.insert(words.end(), more.begin(), more.end());
    Result<ChildProcess> started = ChildProcess::Start(words);
    ASSERT_TRUE(started);
    controller_.emplace(*std::move(started));
  }
  Controller Attach() {
    Controller::Options options;
    options.host = "test";
    options.timeout_s = 60;
    Result<Controller> host = Controller::Attach(name_, options);
    EXPECT_TRUE(host) << host.error().what;
    Controller attached = *std::move(host);
    EXPECT_TRUE(HearUntil(attached, [&attached] {
      return !attached.snapshot().bodies.empty();
    }));
    return attached;
  }

  TemporaryFolder folder_;
  std::string name_ = "control-" + std::to_string(getpid());
  std::optional<ChildProcess> controller_;
};

}  // namespace tandem::testing
