#pragma once

#include <string>

namespace tandem {

/// Sends the meanings of Cyclone's messages to stderr, a line each, and each at most once a minute.
/// Hostile packets make Cyclone write thousands of messages. Call it before the domain is made; a
/// second call in a process changes nothing.
void RedirectCycloneLog();

/// Writes a line about DDS for a person. Does not wait for stderr.
void ReportDdsMessage(const std::string& line);

/// Returns the meaning of one of Cyclone's messages for a person, without the message.
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
