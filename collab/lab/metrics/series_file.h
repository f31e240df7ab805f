#pragma once

#include <filesystem>
#include <fstream>
#include <optional>
#include <span>

#include "collab/lab/metrics/metrics.h"

namespace tandem {

/// Writes a run's time series as CSV, a line every so many frames. The columns are t_s, apart_mm
/// (the farthest two), then for each user N from 1: xN_mm, yN_mm, zN_mm, vN_mm_s, wN_rad_s,
/// forceN_N (given to the hand), linkN_N (all its links), stiffnessN_N_m (mean of its links),
/// loopN_ms (the oldest), dragN_Ns_m, trappedN. The cells of an absent user are empty.
class SeriesFile {
 public:
  /// Error: the file cannot be written.
  static Result<SeriesFile> Create(const std::filesystem::path& file, std::size_t users,
                                   int every_frames);
  void Add(double t_s, std::span<const UserFrame> users);
  /// Closes the file; an error says that it could not be written to its end.
  std::optional<Error> Close();

 private:
  SeriesFile() = default;

  std::filesystem::path file_;
  std::ofstream out_;
  int every_frames_ = 1;
  std::int64_t frame_ = 0;
};

}  // namespace tandem
