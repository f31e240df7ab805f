#pragma once

#include <cstdlib>
#include <string>

#include "engine/realtime/line_writer.h"

namespace tandem {

/// Says a line to a person, on stderr, in the window's name.
inline void SayFromView(const std::string& line) {
  StandardError().WriteLine("tandem-view: " + line);
}

/// Says a line in the window's name and returns the exit code to end with.
inline int FailFromView(int exit_code, const std::string& line) {
  SayFromView(line);
  return exit_code;
}

/// Returns a variable of the environment. Empty: it is not set.
inline std::string EnvironmentVariable(const char* name) {
  const char* value = std::getenv(name);  // NOLINT(concurrency-mt-unsafe)
  return value != nullptr ? value : "";
}

}  // namespace tandem
