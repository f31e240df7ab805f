#pragma once

#include <algorithm>
#include <cstddef>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace tandem {

/// Returns why a part is not there, with the names of those that are.
inline std::string NoPartWords(std::string_view part, const std::vector<std::string>& names) {
  constexpr std::size_t kMostNames = 12;
  std::string words = "it has no part '" + std::string(part) + "', but ";
  if (names.empty()) return words + "parts without names only";
  for (std::size_t i = 0; i < names.size() && i < kMostNames; ++i) {
    words += (i == 0 ? "" : ", ") + names[i];
  }
  const std::size_t more = names.size() - std::min(names.size(), kMostNames);
  return more > 0 ? words + " and " + std::to_string(more) + " more" : words;
}

/// Counts what a reader leaves out, and returns a line for each kind. A file may have any number of
/// kinds: of those beyond the first, only the number is kept.
class RemarkList {
 public:
  /// Notes one more of a kind, which `many` names. `one` and `many` follow the number: "line",
  /// "lines". The first `why` of a kind stays.
  void Count(std::string_view one, std::string_view many, std::string_view why) {
    for (Kind& kind : kinds_) {
      if (kind.many == many) {
        ++kind.count;
        return;
      }
    }
    if (kinds_.size() < kMost) {
      kinds_.push_back({std::string(one), std::string(many), std::string(why), 1});
    } else {
      ++more_;
    }
  }
  /// Notes a line as it is, once.
  void Say(std::string line) {
    for (const std::string& said : lines_) {
      if (said == line) return;
    }
    if (lines_.size() < kMost) {
      lines_.push_back(std::move(line));
    } else {
      ++more_;
    }
  }

  std::vector<std::string> Lines() const {
    std::vector<std::string> lines = lines_;
    for (const Kind& kind : kinds_) {
      lines.push_back(std::to_string(kind.count) + " " + (kind.count == 1 ? kind.one : kind.many) +
                      " " + kind.why);
    }
    if (more_ > 0)
      lines.push_back("and " + std::to_string(more_) +
                      (more_ == 1 ? " more remark" : " more remarks"));
    return lines;
  }

 private:
  struct Kind {
    std::string one, many, why;
    std::size_t count;
  };
  static constexpr std::size_t kMost = 16;  // lines, and kinds
  std::vector<std::string> lines_;
  std::vector<Kind> kinds_;
  std::size_t more_ = 0;
};

}  // namespace tandem
