#pragma once

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <fstream>
#include <optional>
#include <random>
#include <sstream>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <sys/stat.h>
#include <unistd.h>

#include "app/common/exit_codes.h"
#include "app/process/child_processes.h"
#include "tests/app/cli/program_run.h"
#include "tests/support/obj_text.h"

// Runs `tandem peer` beside a test, and sessions of it.

namespace tandem::testing {

/// A peer, or another command, that runs beside the test and takes orders from it.
class Running {
 public:
  Running(const std::string& arguments, const std::filesystem::path& output,
          const std::string& command = "peer")
      : output_(output) {
    // a pipe with a name, so that the started process is the program itself and ends when it is
    // told to
    const std::string orders = output.string() + ".orders";
    EXPECT_EQ(mkfifo(orders.c_str(), 0600), 0);
    orders_ = open(orders.c_str(), O_RDWR | O_CLOEXEC);
    EXPECT_GE(orders_, 0);
    Result<ChildProcess> started =
        ChildProcess::Start({"/bin/sh", "-c",
                             std::string("exec ") + TANDEM_PROGRAM + " " + command + " " +
                                 arguments + " <" + orders + " >" + output.string() + " 2>&1"});
    EXPECT_TRUE(started);
    process_.emplace(*std::move(started));
  }
  Running(Running&& other) noexcept
      : output_(std::move(other.output_)),
        orders_(std::exchange(other.orders_, -1)),
        process_(std::move(other.process_)) {}
  Running& operator=(Running&&) = delete;
  ~Running() {
    if (orders_ >= 0) close(orders_);
  }

  /// Writes a line to its input.
  void Order(const std::string& line) const {
    EXPECT_EQ(write(orders_, (line + "\n").data(), line.size() + 1),
              static_cast<ssize_t>(line.size() + 1));
  }
  std::string output() const {
    std::ostringstream text;
    text << std::ifstream(output_).rdbuf();
    return text.str();
  }
  /// Returns whether it says this within some seconds.
  bool WaitFor(const std::string& words, double seconds = 15) const {
    const auto until = std::chrono::steady_clock::now() + std::chrono::duration<double>(seconds);
    while (std::chrono::steady_clock::now() < until) {
      if (output().find(words) != std::string::npos) return true;
      std::this_thread::sleep_for(std::chrono::milliseconds(20));
    }
    return false;
  }
  /// Returns what follows `of` in /proc's text on its memory.
  std::string Memory(const std::string& of) const {
    std::ifstream status("/proc/" + std::to_string(process_->pid()) + "/status");
    for (std::string line; std::getline(status, line);) {
      if (line.rfind(of + ":", 0) == 0) return line.substr(of.size() + 1);
    }
    return {};
  }
  /// Returns the page faults so far of its thread of that name, of either kind; nothing if there is
  /// none.
  std::optional<long> PageFaults(const std::string& thread) const {
    const std::string tasks = "/proc/" + std::to_string(process_->pid()) + "/task";
    std::error_code gone;
    for (const auto& task : std::filesystem::directory_iterator(tasks, gone)) {
      std::ifstream stat(task.path() / "stat");
      std::string line;
      std::getline(stat, line);
      const std::size_t end = line.rfind(") ");
      if (end == std::string::npos || line.find(thread + ")") == std::string::npos) continue;
      // state, ppid, pgrp, session, tty, tpgid, flags, minflt, cminflt, majflt
      std::istringstream words(line.substr(end + 2));
      std::vector<std::string> field(10);
      for (std::string& word : field) words >> word;
      return std::stol(field[7]) + std::stol(field[9]);
    }
    return std::nullopt;
  }
  int Wait() { return process_->Wait(std::chrono::seconds(30)).value_or(-1); }
  void Kill() { process_->Signal(SIGKILL); }
  int End() {
    process_->Signal(SIGTERM);
    return Wait();
  }

 private:
  std::filesystem::path output_;
  int orders_ = -1;
  std::optional<ChildProcess> process_;
};

/// Scenes of two boxes, the right one shared, by voxels of 1 mm (`one`) and 2 mm (`two`). `other`
/// has another mesh for the right box.
class PeerCommand : public ::testing::Test {
 protected:
  PeerCommand() : session_("peers-" + std::to_string(std::random_device{}())) {
    const std::string box = BoxObjText(0.02, 0.02, 0.02);
    folder_.Write("left.obj", box);
    folder_.Write("right.obj", box);
    folder_.Write("wrong.obj", box + "# another\n");
    folder_.Write("shift.json", R"({"waypoints": [
        {"t_s": 0, "p_W": [0, 0, 0], "q_xyzw": [0, 0, 0, 1]},
        {"t_s": 0.5, "p_W": [0, 0, 0.03], "q_xyzw": [0, 0, 0, 1]}]})");
    WriteScene("one", 0.001, "right.obj");
    WriteScene("two", 0.002, "right.obj");
    WriteScene("other", 0.001, "wrong.obj");
  }
  void WriteScene(const std::string& name, double voxel_m, const std::string& mesh,
                  double right_x = 0.05) {
    nlohmann::json scene{{"name", "boxes"}, {"voxel_m", voxel_m}};
    scene["bodies"] = {{{"name", "left"},
                        {"mesh", "left.obj"},
                        {"mass_kg", 0.1},
                        {"pose", {{"p_W", {-0.05, 0, 0}}}}},
                       {{"name", "right"},
                        {"mesh", mesh},
                        {"mass_kg", 0.1},
                        {"sharing", "shared"},
                        {"pose", {{"p_W", {right_x, 0, 0}}}}}};
    folder_.Write(name + ".json", scene.dump());
  }
  std::string In(const std::string& file) const { return (folder_.path() / file).string(); }
  /// Returns the options of a peer in one of the scenes.
  std::string By(const std::string& scene, const std::string& more) const {
    return "--interface lo --capacity 20000 --session " + session_ + " --scene " +
           In(scene + ".json") + " " + more;
  }
  Running Start(const std::string& scene, const std::string& more) {
    return {By(scene, more), In("said" + std::to_string(started_++))};
  }
  ProgramOutput Run(const std::string& scene, const std::string& more) const {
    return RunTandem("peer " + By(scene, more), "timeout 40 ");
  }

  ScratchFolder folder_;
  std::string session_;
  int started_ = 0;
};

}  // namespace tandem::testing
