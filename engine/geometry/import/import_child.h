#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>

namespace tandem {

/// The limits of a reading process.
struct ImportLimits {
  double seconds = 0;            // wall time, and CPU time rounded up, s
  std::size_t memory_bytes = 0;  // address space, and as many bytes of answer
};

/// The result of a reading process. The process has been reaped, however it ended.
struct ImportChildRun {
  enum class End { kExited, kKilledBySignal, kTooLate, kTooMuchSaid, kNotStarted };
  End end = End::kNotStarted;
  int code = 0;        // exit code, signal or errno
  std::string answer;  // all that the process wrote into its pipe
};

/// Runs this program anew as a reading process of `file`, which recognizes itself by ImportJobOf().
/// Waits for its end or until the time is up. Several threads may call it at once. `part`: the
/// wanted part of the file, for the job.
ImportChildRun RunImportChild(const std::filesystem::path& file, const std::string& part,
                              const ImportLimits& limits);

/// The job of a reading process.
struct ImportJob {
  std::filesystem::path file;
  std::string part;
  ImportLimits limits;
  int answer_fd = -1;
};

/// Returns the job of this process if it is a reading process. main() must call it first.
std::optional<ImportJob> ImportJobOf(int argc, char** argv);

/// Sets the limits on this process, for good, and makes it end with its parent. Under a sanitizer,
/// which maps terabytes for itself, the memory limit comes on top of what is mapped at the call.
void ConfineTo(const ImportLimits& limits);

}  // namespace tandem
