#pragma once

#include <string>
#include <vector>

#include "engine/base/result.h"

namespace tandem {

/// Keeps a controller's output in an unnamed file, which vanishes with the programs that have it
/// open. The controller appends to it.
class ControllerLog {
 public:
  static Result<ControllerLog> Open();
  ControllerLog(ControllerLog&& other) noexcept;
  ControllerLog& operator=(ControllerLog&&) = delete;
  ~ControllerLog();

  /// Returns the file's descriptor, which this object owns.
  int descriptor() const noexcept { return file_; }
  /// Empties a file of more than kMostBytes, and keeps its last line. Called now and then.
  void Bound();
  /// Returns the last line without the program's name; empty: none.
  std::string LastLine() const;
  /// Marks the file's present end. LinesSinceMark() returns the lines from there, without the
  /// program's name: the newest of them, where there are very many.
  void Mark();
  std::vector<std::string> LinesSinceMark() const;

  static constexpr long kMostBytes = 4L << 20U;

 private:
  explicit ControllerLog(int file) : file_(file) {}
  int file_ = -1;
  long mark_ = 0;     // bytes
  std::string last_;  // last line from before Bound() emptied the file
};

}  // namespace tandem
