#pragma once

#include <chrono>
#include <filesystem>
#include <fstream>
#include <optional>
#include <sstream>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "app/process/child_processes.h"

namespace tandem::testing {

inline std::string TextOf(const std::filesystem::path& file) {
  std::ostringstream text;
  text << std::ifstream(file).rdbuf();
  return text.str();
}

inline std::vector<std::string> LinesOf(const std::string& text) {
  std::vector<std::string> lines;
  std::istringstream stream(text);
  for (std::string line; std::getline(stream, line);) lines.push_back(line);
  return lines;
}

/// A program that runs beside the test, with what it says in a file and its input from another.
class Program {
 public:
  Program(const std::vector<std::string>& command, std::filesystem::path output,
          const std::filesystem::path& input = "/dev/null")
      : output_(std::move(output)) {
    std::vector<std::string> all{"/bin/sh",
                                 "-c",
                                 R"(f="$1"; i="$2"; shift 2; exec "$@" >>"$f" 2>&1 <"$i")",
                                 "sh",
                                 output_.string(),
                                 input.string()};
    all.insert(all.end(), command.begin(), command.end());
    Result<ChildProcess> started = ChildProcess::Start(all);
    EXPECT_TRUE(started);
    process_.emplace(*std::move(started));
  }

  std::string output() const { return TextOf(output_); }
  bool Says(const std::string& words, double seconds = 30) const {
    for (double waited = 0; waited < seconds; waited += 0.02) {
      if (output().find(words) != std::string::npos) return true;
      std::this_thread::sleep_for(std::chrono::milliseconds(20));
    }
    return false;
  }
  /// Returns the bytes in memory now.
  std::int64_t Memory() const {
    std::ifstream status("/proc/" + std::to_string(process_->pid()) + "/status");
    for (std::string line; std::getline(status, line);) {
      if (line.rfind("VmRSS:", 0) == 0) return 1024 * std::stoll(line.substr(6));
    }
    return 0;
  }
  std::optional<int> Wait(double seconds = 20) {
    return process_->Wait(std::chrono::milliseconds(static_cast<long>(1000 * seconds)));
  }
  ChildProcess& process() { return *process_; }

 private:
  std::filesystem::path output_;
  std::optional<ChildProcess> process_;
};

}  // namespace tandem::testing
