#include "tests/architecture/source_comments.h"

#include <algorithm>
#include <cctype>
#include <utility>

namespace tandem::testing {
namespace {

/// Reads the comments of one source.
class CommentReader {
 public:
  explicit CommentReader(std::string_view source) : source_(source) {}

  std::vector<SourceComment> Read() {
    while (at_ < source_.size()) {
      if (Begins("//")) {
        TakeComment();
      } else if (Begins("/*")) {
        SkipPast("*/", 2);
      } else if (Begins("R\"")) {
        const std::size_t open = source_.find('(', at_);
        if (open == std::string_view::npos) break;
        SkipPast(")" + std::string(source_.substr(at_ + 2, open - at_ - 2)) + "\"", open + 1 - at_);
      } else if (source_[at_] == '"' || (source_[at_] == '\'' && !IsSeparator())) {
        SkipLiteral();
      } else {
        Step();
      }
    }
    return std::move(comments_);
  }

 private:
  bool Begins(std::string_view with) const { return source_.substr(at_).starts_with(with); }
  /// Returns whether the quote here stands between digits, as in 1'000.
  bool IsSeparator() const {
    return at_ > 0 && std::isalnum(static_cast<unsigned char>(source_[at_ - 1])) != 0;
  }
  void Step() {
    if (source_[at_] == '\n') {
      ++line_;
      line_begin_ = at_ + 1;
    }
    ++at_;
  }
  void SkipPast(std::string_view end, std::size_t from) {
    const std::size_t found = source_.find(end, at_ + from);
    const std::size_t past = found == std::string_view::npos ? source_.size() : found + end.size();
    while (at_ < past) Step();
  }
  void SkipLiteral() {
    const char quote = source_[at_];
    for (Step(); at_ < source_.size() && source_[at_] != quote; Step()) {
      if (source_[at_] == '\\' && at_ + 1 < source_.size()) Step();
    }
    if (at_ < source_.size()) Step();
  }
  void TakeComment() {
    const std::size_t column = at_ - line_begin_;
    const bool is_alone = source_.find_first_not_of(' ', line_begin_) == at_;
    const std::size_t text = std::min(source_.find_first_not_of('/', at_), source_.size());
    const std::size_t end = std::min(source_.find('\n', at_), source_.size());
    std::string_view words = source_.substr(text, end - text);
    words.remove_prefix(std::min(words.find_first_not_of(' '), words.size()));
    if (is_alone && !comments_.empty() && last_line_ + 1 == line_ &&
        (last_is_alone_ || last_column_ == column)) {
      comments_.back().text += "\n" + std::string(words);
    } else {
      comments_.push_back({line_, std::string(words)});
      last_is_alone_ = is_alone;
    }
    last_line_ = line_;
    last_column_ = column;
    at_ = end;
  }

  std::string_view source_;
  std::size_t at_ = 0;
  std::size_t line_ = 1;
  std::size_t line_begin_ = 0;
  std::vector<SourceComment> comments_;
  std::size_t last_line_ = 0;    // last line of the newest comment
  std::size_t last_column_ = 0;  // column in which that line begins
  bool last_is_alone_ = false;   // no code stands before the newest comment
};

}  // namespace

std::vector<SourceComment> CommentsOf(std::string_view source) {
  return CommentReader(source).Read();
}

}  // namespace tandem::testing
