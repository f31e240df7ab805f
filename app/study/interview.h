#pragma once

#include <chrono>
#include <cstdio>
#include <map>
#include <optional>
#include <string>

#include "app/study/study.h"

namespace tandem {

/// Talks with the participant in a terminal: lines out, lines in.
class Interview {
 public:
  /// `input`: a file descriptor.
  Interview(int input, std::FILE* output) : input_(input), output_(output) {}

  void Tell(const std::string& text);
  /// Returns the next line without control characters and surrounding blanks; nothing: the input
  /// has ended.
  std::optional<std::string> Line();
  /// Waits up to `time` for a line and consumes it. Returns whether a line came; false at the end
  /// of the input.
  bool LineWithin(std::chrono::milliseconds time);
  /// Discards what was typed at a terminal before the question, so that a surplus Enter answers
  /// nothing. Lines of a pipe stay, since their writer knows the questions.
  void ForgetTyped();
  /// Asks until the line is one of these words, in any case; nothing: the input has ended.
  std::optional<std::string> AskForWord(const std::string& text,
                                        const std::vector<std::string>& words);
  /// Asks until the answer is of the question's kind; nothing: the input has ended.
  std::optional<std::string> Ask(const StudyQuestion& question);

 private:
  bool Fill(int timeout_ms);

  int input_;
  std::FILE* output_;
  std::string waiting_;
  bool ended_ = false;
};

/// Returns the answer that a line gives to the question: a choice by its number or its words, a
/// number on the scale, or a text. Nothing: the line is no answer.
std::optional<std::string> AnswerOf(const StudyQuestion& question, const std::string& line);

}  // namespace tandem
