#pragma once

#include <cstdint>
#include <cstdio>
#include <string>
#include <string_view>

#include "engine/base/text/hex.h"
#include "engine/realtime/line_writer.h"

namespace tandem {

/// Returns a count and its noun: "1 pose", "2 poses".
inline std::string WithPlural(std::uint64_t count, const std::string& one) {
  return std::to_string(count) + " " + one + (count == 1 ? "" : "s");
}

/// Returns the name that is put before each line, where a command has started several programs.
/// Empty: no name. Set it before the program's threads start.
inline std::string& LinePrefix() {
  static std::string speaker;
  return speaker;
}

/// Returns the newest line that this thread has said, for code that must tell another program why.
inline std::string& LastMessage() {
  thread_local std::string line;
  return line;
}

/// Says a line to a person, on stderr, because programs read stdout. Never waits for a terminal or
/// a pipe. No control character of a name or a path reaches the terminal.
inline void Say(const std::string& line) {
  LastMessage() = line;
  const std::string who = LinePrefix().empty() ? "" : LinePrefix() + ": ";
  StandardError().WriteLine("tandem: " + who + line);
}

/// Says a line and returns the exit code to end with.
inline int Fail(int exit_code, const std::string& line) {
  Say(line);
  return exit_code;
}

/// Prints one line on stdout, as printf() does; the end of the line is not in `format`. The line
/// stays one line of plain text, whatever the arguments hold.
[[gnu::format(printf, 1, 2)]] void PrintLine(const char* format, ...);

/// Prints text of several lines on stdout, and ends it with the end of a line. All other control
/// characters become '?'. JsonText() escapes them before, so that JSON keeps its strings.
void PrintText(std::string_view text);

/// Says a line on stderr in another name than tandem's, at once. For a process that must not start
/// the thread of StandardError().
void SayAs(const char* program, std::string_view line);

}  // namespace tandem
