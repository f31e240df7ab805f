#pragma once

#include <string>

#include "engine/base/result.h"

namespace tandem {

/// It keeps what a controller says in a file without a name: nothing is left of that however the
/// programs end that have it open. A controller adds to its end.
class ControllerLog {
 public:
  static Result<ControllerLog> Open();
  ControllerLog(ControllerLog&& other) noexcept;
  ControllerLog& operator=(ControllerLog&&) = delete;
  ~ControllerLog();

  /// The file's descriptor, which stays this object's.
  int descriptor() const noexcept { return file_; }
  /// Empties the file where it has more than kMostBytes, all but its last line. Call it now and
  /// then.
  void Bound();
  /// Returns the last line, without what the program calls itself; empty: none.
  std::string LastLine() const;

  static constexpr long kMostBytes = 4L << 20U;

 private:
  explicit ControllerLog(int file) : file_(file) {}
  int file_ = -1;
  std::string last_;  // line of what Bound() took away
};

}  // namespace tandem
