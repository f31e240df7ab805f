#include "tests/soak/program_log.h"

#include <algorithm>
#include <cctype>
#include <sstream>
#include <utility>
#include <vector>

namespace tandem::testing {

namespace {

constexpr const char* kBeforeEachLine = "tandem: ";
constexpr std::size_t kNewest = 20;

std::vector<std::string> CommandLineOf(const std::string& line) {
  std::vector<std::string> words;
  std::istringstream stream(line);
  for (std::string word; stream >> word;) words.push_back(word);
  return words;
}

/// A cell of a peer's table is "-" or a number and its unit.
struct Cell {
  bool known = false;
  double value = 0;
};

/// Reads the cell that begins at words[at], and moves `at` behind it; false: there is no cell.
bool ReadCell(const std::vector<std::string>& words, std::size_t& at, Cell& cell) {
  if (at >= words.size()) return false;
  cell = {};
  if (words[at] == "-") {
    ++at;
    return true;
  }
  std::istringstream number(words[at]);
  if (at + 1 >= words.size() || !(number >> cell.value)) return false;
  cell.known = true;
  at += 2;
  return true;
}

bool IsNoNumber(std::string word) {
  std::erase_if(word, [](char c) {
    return std::isalpha(static_cast<unsigned char>(c)) == 0;
  });
  return word == "nan" || word == "inf";
}

}  // namespace

void ProgramLog::Read(double now_s) {
  std::ifstream stream(file_, std::ios::binary);
  stream.seekg(read_);
  std::ostringstream fresh;
  fresh << stream.rdbuf();
  const std::string text = fresh.str();
  read_ += static_cast<std::streamoff>(text.size());
  for (const char c : text) {
    if (c != '\n') {
      begun_ += c;
      continue;
    }
    Take(std::exchange(begun_, {}), now_s);
  }
}

void ProgramLog::Forget() {
  rows_.clear();
  seen_.clear();
}

void ProgramLog::Take(const std::string& line, double now_s) {
  const std::vector<std::string> words = CommandLineOf(line);
  if (not_finite_.empty() && std::ranges::any_of(words, IsNoNumber)) not_finite_ = line;
  if (line.starts_with(kBeforeEachLine)) {
    const std::string output = line.substr(std::string(kBeforeEachLine).size());
    if (TakeAnswer(output)) return;
    TakeStatus(output);
    if (output.ends_with(" is lost")) ++losses_;
  }
  ++lines_;
  newest_.push_back(line);
  if (newest_.size() > kNewest) newest_.pop_front();
  times_.push_back(now_s);
  while (times_.front() < now_s - kWindow) times_.pop_front();
  most_lines_ = std::max(most_lines_, times_.size());
}

bool ProgramLog::TakeAnswer(const std::string& line) {
  const std::vector<std::string> words = CommandLineOf(line);
  if (words.size() < 2) return false;
  if (words[0] == "peer" && words[1] == "delay") {
    rows_.clear();
    return true;
  }
  // the peer's own limits, and the force terms of each other peer
  if (line.starts_with("in the last second, ")) return true;
  if (words[0].ends_with(':') && rows_.contains(words[0].substr(0, words[0].size() - 1))) {
    return true;
  }
  std::size_t at = 1;
  Cell delay;
  Cell stiffness;
  if (!ReadCell(words, at, delay) || !ReadCell(words, at, stiffness)) return false;
  rows_[words[0]] = {.delay_ms = delay.known ? delay.value : -1, .coupled = stiffness.known};
  return true;
}

// "5999 samples/s; anna-1 52 ms, peg moved 12 mm (contact); ben-1 51 ms, …"
void ProgramLog::TakeStatus(const std::string& line) {
  if (line.find(" samples/s") == std::string::npos) return;
  seen_.clear();
  for (std::size_t at = line.find("; "); at != std::string::npos; at = line.find("; ", at + 2)) {
    seen_.insert(line.substr(at + 2, line.find(' ', at + 2) - at - 2));
  }
}

}  // namespace tandem::testing
