#pragma once

#include <string>

namespace tandem {

/// Sends Cyclone's messages to stderr, one line each, at most four a second; further messages are
/// counted. Hostile packets make Cyclone write thousands. Call it before the domain is made; a
/// second call in a process changes nothing.
void RedirectCycloneLog();

/// Writes a line about DDS for a person. Does not wait for stderr.
void ReportDdsMessage(const std::string& line);

/// Returns one of Cyclone's messages, with its meaning for a person before it.
std::string ExplainMessage(const std::string& message);

/// Keeps Cyclone's messages back while it lives, so that one line of Tandem's can report a failure.
/// One at a time.
class CycloneLogCapture {
 public:
  CycloneLogCapture();
  ~CycloneLogCapture();  // writes the messages that were kept back, unless Take() was called
  CycloneLogCapture(const CycloneLogCapture&) = delete;
  CycloneLogCapture& operator=(const CycloneLogCapture&) = delete;

  /// Returns the newest message, empty when there was none.
  std::string Take();
};

}  // namespace tandem
