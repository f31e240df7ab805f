#pragma once

#include <cstddef>
#include <deque>
#include <filesystem>
#include <fstream>
#include <map>
#include <set>
#include <string>

namespace tandem::testing {

/// Follows what a peer or a viewer of the product says into a file: the programs that it hears, how
/// many lines it says of its own accord, and numbers that are none.
class ProgramLog {
 public:
  /// A row of the table by which a peer answers the order `peers`.
  struct Row {
    double delay_ms = -1;  // below 0: not known
    bool coupled = false;
  };
  static constexpr double kWindow = 10;  // s

  explicit ProgramLog(std::filesystem::path file) : file_(std::move(file)) {}

  /// Reads the lines that are new at that time.
  void Read(double now_s);
  /// Forgets the programs that this one has heard, so that what is known afterwards is new.
  void Forget();

  /// Returns the rows of a peer's newest table by name.
  const std::map<std::string, Row>& rows() const { return rows_; }
  /// Returns the names in a viewer's newest status line.
  const std::set<std::string>& seen() const { return seen_; }
  /// Returns the newest lines, without answers to orders.
  const std::deque<std::string>& newest() const { return newest_; }
  /// Returns the most lines in any `kWindow` seconds, without answers to orders.
  std::size_t most_lines() const { return most_lines_; }
  std::size_t lines() const { return lines_; }
  /// Returns how often the program has lost another one.
  std::size_t losses() const { return losses_; }
  /// Returns the first line with a number that is none; empty: there is none.
  const std::string& not_finite() const { return not_finite_; }

 private:
  void Take(const std::string& line, double now_s);
  /// Returns whether the line is part of an answer to `peers`.
  bool TakeAnswer(const std::string& line);
  void TakeStatus(const std::string& line);

  std::filesystem::path file_;
  std::streamoff read_ = 0;  // bytes
  std::string begun_;        // line without its end
  std::map<std::string, Row> rows_;
  std::set<std::string> seen_;
  std::deque<std::string> newest_;
  std::deque<double> times_;  // s; times of the lines of a window
  std::size_t most_lines_ = 0;
  std::size_t lines_ = 0;
  std::size_t losses_ = 0;
  std::string not_finite_;
};

}  // namespace tandem::testing
