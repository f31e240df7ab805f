#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>

namespace tandem {

/// The options of `tandem doctor --trace`, which records a line to a machine that answers.
struct LineArguments {
  std::string file;  // the trace; empty: none is recorded
  double seconds = 10;
  int rate_hz = 1000;
};

void AddLineOptions(CLI::App& doctor, LineArguments& arguments);

/// Records the line to the only machine in `peers`, at UDP `port`, and describes it. Returns the
/// exit code.
int RunDoctorTrace(const LineArguments& arguments, const std::vector<std::string>& peers,
                   std::uint16_t port, bool json);

}  // namespace tandem
