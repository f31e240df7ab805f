#pragma once

#include <condition_variable>
#include <cstddef>
#include <filesystem>
#include <fstream>
#include <functional>
#include <mutex>
#include <span>
#include <string>
#include <thread>
#include <vector>

#include "collab/peer/peer.h"
#include "engine/base/result.h"

namespace tandem {

/// The columns of a trace, a file of doubles: the frame's time as whole seconds and the rest (both
/// s), p_WB (m), q_WB (x, y, z, w), the angular (rad/s) and linear (m/s) velocity in W, the hand's
/// force (N), and the number of contact points, plus 0.5 if contact pushes.
inline constexpr std::size_t kTraceColumns = 17;

/// Returns why a trace cannot be written into this file, in one line; empty: it can. The run opens
/// the file as it begins, and would wait for a reader of a pipe.
std::string WhyNoTrace(const std::filesystem::path& file);

/// Writes a peer's trace while it grows, on a thread of its own. After a long run little is left to
/// write, so the program ends in time.
class TraceFile {
 public:
  /// Returns the frames that are traced so far. This object's thread calls it, and Close().
  using Traced = std::function<std::span<const TraceSample>()>;

  TraceFile(std::filesystem::path file, Traced traced);
  /// Writes what is left.
  ~TraceFile();
  TraceFile(const TraceFile&) = delete;
  TraceFile& operator=(const TraceFile&) = delete;

  /// Writes what is left. Call it once. Error: some of the trace could not be written; the file is
  /// removed then, since a reader would take it for the whole.
  Result<bool> Close();
  /// Ends and removes the file, in place of Close().
  void Discard();

 private:
  void Run();
  void WriteNew();
  void EndThread();
  void Remove();

  const std::filesystem::path file_;
  const Traced traced_;
  std::ofstream stream_;
  std::size_t written_ = 0;  // frames
  std::mutex mutex_;
  std::condition_variable closed_;
  bool is_closed_ = false;
  std::thread thread_;
};

/// Reads a trace while TraceFile writes it.
class TraceTail {
 public:
  explicit TraceTail(std::filesystem::path file);
  /// Returns the frames that are whole in the file and were not returned yet. None if there is no
  /// file.
  std::vector<TraceSample> ReadNew();

 private:
  const std::filesystem::path file_;
  std::ifstream stream_;
  std::streamoff read_ = 0;  // bytes
};

/// Reads what TraceFile wrote. Errors: the file cannot be read, or ends within a frame.
Result<std::vector<TraceSample>> ReadTrace(const std::filesystem::path& file);

}  // namespace tandem
