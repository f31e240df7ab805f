#pragma once

#include <array>
#include <cstdio>
#include <fstream>
#include <sstream>
#include <string>

#include <sys/wait.h>

#include "tests/support/scratch_folder.h"

namespace tandem::testing {

/// What a run of the program left behind.
struct Said {
  int exit_code = -1;
  std::string out;  // stdout
  std::string err;  // stderr
};

/// Runs `tandem ARGUMENTS` to its end; `before` goes in front, as "timeout 5 " or "HOME=/ ".
inline Said RunTandem(const std::string& arguments, const std::string& before = "") {
  const ScratchFolder folder;
  const std::filesystem::path err = folder.path() / "err";
  const std::string command =
      before + std::string(TANDEM_PROGRAM) + " " + arguments + " </dev/null 2>" + err.string();
  FILE* pipe = popen(command.c_str(), "r");
  if (pipe == nullptr) return {};
  Said said;
  std::array<char, 4096> buffer{};
  while (const std::size_t got = fread(buffer.data(), 1, buffer.size(), pipe)) {
    said.out.append(buffer.data(), got);
  }
  const int status = pclose(pipe);
  if (WIFEXITED(status)) said.exit_code = WEXITSTATUS(status);
  std::ostringstream text;
  text << std::ifstream(err).rdbuf();
  said.err = text.str();
  return said;
}

}  // namespace tandem::testing
