#pragma once

#include <string>

namespace tandem {

/// From here on Cyclone's messages go to stderr one line each, at most four a second, and the rest
/// are counted: hostile packets make it write thousands. Once a process; again does nothing. Before
/// the domain is made.
void TakeOverCycloneLog();

/// A line about DDS for a person. Does not wait for stderr.
void SayOfDds(const std::string& line);

/// One of Cyclone's messages with what it means for a person before it.
std::string InPlainWords(const std::string& message);

/// While it lives, Cyclone's messages are kept back, so that a failure can be told in one line of
/// ours. One at a time.
class CycloneLogCapture {
 public:
  CycloneLogCapture();
  ~CycloneLogCapture();  // says what was kept back, unless Take() was called
  CycloneLogCapture(const CycloneLogCapture&) = delete;
  CycloneLogCapture& operator=(const CycloneLogCapture&) = delete;

  /// The newest message, empty when there was none.
  std::string Take();
};

}  // namespace tandem
