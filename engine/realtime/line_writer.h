#pragma once

#include <chrono>
#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <mutex>
#include <string>
#include <string_view>

namespace tandem {

/// Writes text to a file descriptor from its own thread. So a terminal that is stopped, a pipe
/// without reader or a slow disk delays no other thread. Text that finds no room is dropped and
/// counted. For any thread but a haptic one: it locks and allocates.
///
/// Its thread takes no signal. It is never joined: a write that blocks ends with the process.
class LineWriter {
 public:
  static constexpr std::size_t kMostTexts = 512;

  /// Does not own `fd`.
  explicit LineWriter(int fd);
  LineWriter(const LineWriter&) = delete;
  LineWriter& operator=(const LineWriter&) = delete;

  /// Writes a line, given without its end. The line stays one line of plain text, whatever it says:
  /// CleanText() replaces its line ends and control characters.
  void WriteLine(std::string_view line);
  /// Writes text as it is.
  void Write(std::string text);
  /// Waits until all is written, at most for `patience`. Returns whether all is.
  bool Flush(std::chrono::milliseconds patience);
  /// Returns the number of texts that found no room, or whose reader has gone.
  std::uint64_t dropped() const;

 private:
  ~LineWriter() = default;

  static void* Run(void* self);
  void WriteAll();

  const int fd_;
  mutable std::mutex mutex_;
  std::condition_variable work_;
  std::condition_variable idle_;
  std::deque<std::string> waiting_;
  bool writing_ = false;
  std::uint64_t dropped_ = 0;
  std::uint64_t dropped_told_ = 0;
};

/// Returns the writer of the program's stderr. At the program's ordinary end waiting texts are
/// written, if that takes no longer than kLastWordsPatience.
LineWriter& StandardError();
inline constexpr std::chrono::milliseconds kLastWordsPatience{200};

}  // namespace tandem
