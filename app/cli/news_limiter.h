#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <map>
#include <string>
#include <vector>

namespace tandem {

/// Lets news of other programs through at a pace that a person can read and that nobody can flood: at
/// most kMostPerSecond lines in any second, and of one program one line a second. What comes faster
/// waits, the newest kMostOfOne of a program and kMostWaiting in all; what is left out is counted and
/// told. Times are handed in.
class NewsLimiter {
 public:
  static constexpr std::size_t kMostPerSecond = 6;
  static constexpr std::size_t kMostOfOne = 3;
  static constexpr std::size_t kMostWaiting = 24;
  static constexpr std::size_t kMostNames = 256;

  /// `about`: the name of the program that made the news; empty: this program's own, which wait for
  /// no other line of theirs.
  void Add(const std::string& about, const std::string& line);

  /// The lines to say now, in the order in which they came as far as the pace allows.
  std::vector<std::string> Due(std::int64_t now_ns);

  /// The lines that still wait, at the end.
  std::vector<std::string> Rest();

  std::uint64_t left_out() const noexcept { return left_out_; }

 private:
  struct Line {
    std::string about;
    std::string text;
  };

  bool HasRoom(std::int64_t now_ns) const;
  void Say(std::int64_t now_ns, std::string line, std::vector<std::string>& said);
  void ForgetNames(std::int64_t now_ns);

  std::deque<Line> waiting_;
  std::deque<std::int64_t> said_ns_;             // of the newest kMostPerSecond lines
  std::map<std::string, std::int64_t> told_ns_;  // when each program was told of last
  std::uint64_t left_out_ = 0;
  std::uint64_t left_out_told_ = 0;
};

/// Of `names` the longest that the line begins with; empty: none.
std::string AboutWhom(const std::string& line, const std::vector<std::string>& names);

}  // namespace tandem
