#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <map>
#include <string>
#include <vector>

namespace tandem {

/// Lets news of other programs through at a pace that a person can read and that nobody can flood.
/// It passes at most kMostPerSecond lines in any second, and one line a second of each program.
/// Faster news waits: the newest kMostOfOne lines of a program, and kMostWaiting lines in all. It
/// counts the lines that it leaves out, and tells their number. Callers hand in the times.
class NotificationLimiter {
 public:
  static constexpr std::size_t kMostPerSecond = 6;
  static constexpr std::size_t kMostOfOne = 3;
  static constexpr std::size_t kMostWaiting = 24;
  static constexpr std::size_t kMostNames = 256;

  /// Adds a line. `about`: name of the program that made the news. Empty: this program's own news,
  /// whose lines do not wait for one another.
  void Add(const std::string& about, const std::string& line);

  /// Returns the lines to say, in the order in which they came, as far as the pace allows.
  std::vector<std::string> Due(std::int64_t now_ns);

  /// Returns the lines that still wait. For the end.
  std::vector<std::string> Rest();

  std::uint64_t left_out() const noexcept { return left_out_; }

 private:
  struct Line {
    std::string about;
    std::string text;
  };

  bool HasRoom(std::int64_t now_ns) const;
  void Say(std::int64_t now_ns, std::string line, std::vector<std::string>& output);
  void ForgetNames(std::int64_t now_ns);

  std::deque<Line> waiting_;
  std::deque<std::int64_t> said_ns_;             // times of the newest kMostPerSecond lines
  std::map<std::string, std::int64_t> told_ns_;  // time of the last line about each program
  std::uint64_t left_out_ = 0;
  std::uint64_t left_out_told_ = 0;
};

/// Returns the longest of `names` that the line begins with; empty: none.
std::string SubjectOf(const std::string& line, const std::vector<std::string>& names);

}  // namespace tandem
