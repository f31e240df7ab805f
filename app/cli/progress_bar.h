#pragma once

#include <cstddef>
#include <cstdint>
#include <string>

namespace tandem {

/// "[########            ] 123 of 536, 41 s left", without its line's beginning and end. `share` of
/// the work is done, `elapsed_s` after its start.
std::string ProgressLine(std::size_t done, std::size_t of, double share, double elapsed_s);

/// How far a long run is, for a person: one line on stderr, written anew at most five times a
/// second. One thread at a time.
class ProgressBar {
 public:
  /// Shown on a terminal, or if `always`.
  ProgressBar(std::size_t of, bool always);
  /// Wipes the line.
  ~ProgressBar();
  ProgressBar(const ProgressBar&) = delete;
  ProgressBar& operator=(const ProgressBar&) = delete;

  /// `share`: of the work, as the parts that are done cost.
  void Show(std::size_t done, double share);

 private:
  std::size_t of_;
  bool shown_;
  std::int64_t began_ns_;
  std::int64_t last_ns_ = 0;
};

}  // namespace tandem
