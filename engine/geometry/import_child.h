#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>

namespace tandem {

/// What a reading process may use.
struct ImportLimits {
  double seconds = 0;            // wall time, and CPU time rounded up
  std::size_t memory_bytes = 0;  // address space; and as many bytes of answer
};

/// What came of a reading process. By now it is gone and reaped, however it ended.
struct ImportChildRun {
  enum class End { kExited, kKilledBySignal, kTooLate, kTooMuchSaid, kNotStarted };
  End end = End::kNotStarted;
  int code = 0;        // exit code, signal or errno
  std::string answer;  // all that it wrote into its pipe
};

/// Runs this program anew as a reading process of `file`, which knows itself by ImportJobOf(), and
/// waits for its end or for the time to be up. May be called by several threads at once.
/// `part`: what of the file is wanted, for the job.
ImportChildRun RunImportChild(const std::filesystem::path& file, const std::string& part,
                              const ImportLimits& limits);

/// What a reading process is to do.
struct ImportJob {
  std::filesystem::path file;
  std::string part;
  ImportLimits limits;
  int answer_fd = -1;
};

/// The job of this process if it is a reading process. Must be asked first thing in main().
std::optional<ImportJob> ImportJobOf(int argc, char** argv);

/// Lays the limits on this process, for good, and ends it with its parent. Under a sanitizer, which
/// maps terabytes for itself, memory is counted from what is mapped now.
void ConfineTo(const ImportLimits& limits);

}  // namespace tandem
