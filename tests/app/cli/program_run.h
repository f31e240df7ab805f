#pragma once

#include <algorithm>
#include <array>
#include <cstdio>
#include <fstream>
#include <sstream>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/wait.h>

#include "tests/support/scratch_folder.h"

namespace tandem::testing {

/// The exit code and the output of a run of the program.
struct ProgramOutput {
  int exit_code = -1;
  std::string out;  // stdout
  std::string err;  // stderr
};

/// Runs `tandem ARGUMENTS` to its end; `before` goes in front, as "timeout 5 " or "HOME=/ ".
inline ProgramOutput RunTandem(const std::string& arguments, const std::string& before = "") {
  const ScratchFolder folder;
  const std::filesystem::path err = folder.path() / "err";
  const std::string command =
      before + std::string(TANDEM_PROGRAM) + " " + arguments + " </dev/null 2>" + err.string();
  FILE* pipe = popen(command.c_str(), "r");
  if (pipe == nullptr) return {};
  ProgramOutput output;
  std::array<char, 4096> buffer{};
  while (const std::size_t got = fread(buffer.data(), 1, buffer.size(), pipe)) {
    output.out.append(buffer.data(), got);
  }
  const int status = pclose(pipe);
  if (WIFEXITED(status)) output.exit_code = WEXITSTATUS(status);
  std::ostringstream text;
  text << std::ifstream(err).rdbuf();
  output.err = text.str();
  return output;
}

/// Expects one line with these words, and this exit code.
inline void ExpectRefused(const ProgramOutput& output, int exit_code, const std::string& words) {
  EXPECT_EQ(output.exit_code, exit_code) << output.err;
  EXPECT_THAT(output.err, ::testing::HasSubstr(words));
  EXPECT_EQ(std::count(output.err.begin(), output.err.end(), '\n'), 1) << output.err;
}

}  // namespace tandem::testing
