#pragma once

#include <chrono>
#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <mutex>
#include <string>

namespace tandem {

/// Writes text to a file descriptor from a thread of its own, so that a terminal that is stopped, a
/// pipe that nobody reads or a slow disk holds up nobody else. What finds no room is dropped and
/// counted. Any thread, but no haptic one: it locks and allocates.
///
/// Its thread takes no signal. It is never joined: a write that blocks ends with the process.
class LineWriter {
 public:
  static constexpr std::size_t kMostTexts = 512;

  /// Does not own `fd`.
  explicit LineWriter(int fd);
  LineWriter(const LineWriter&) = delete;
  LineWriter& operator=(const LineWriter&) = delete;

  /// The line without its end.
  void WriteLine(const std::string& line) { Write(line + '\n'); }
  /// Text as it is.
  void Write(std::string text);
  /// Waits until all is written, or so long. Returns whether all is.
  bool Flush(std::chrono::milliseconds patience);
  /// Texts that found no room, or whose reader has gone.
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

/// The program's stderr. At the program's ordinary end what waits is written, if that takes no
/// longer than kLastWordsPatience.
LineWriter& StandardError();
inline constexpr std::chrono::milliseconds kLastWordsPatience{200};

}  // namespace tandem
