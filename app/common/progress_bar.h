#pragma once

#include <cstddef>
#include <cstdint>
#include <string>

namespace tandem {

/// Returns "[########            ] 123 of 536, 41 s left", without the line's beginning and end.
/// `share`: part of the work that is done `elapsed_s` after its start.
std::string ProgressLine(std::size_t done, std::size_t of, double share, double elapsed_s);

/// Shows a person how far a long run is, in one line on stderr, written anew at most five times a
/// second. One thread at a time.
class ProgressBar {
 public:
  /// Shows the bar on a terminal, or if `always`.
  ProgressBar(std::size_t of, bool always);
  /// Wipes the line.
  ~ProgressBar();
  ProgressBar(const ProgressBar&) = delete;
  ProgressBar& operator=(const ProgressBar&) = delete;

  /// `share`: part of the work that is done, weighted by what its parts cost.
  void Show(std::size_t done, double share);

 private:
  std::size_t of_;
  bool shown_;
  std::int64_t began_ns_;
  std::int64_t last_ns_ = 0;
};

}  // namespace tandem
