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
  /// The next line, without control characters and blanks at its ends; nothing: there is none any
  /// more.
  std::optional<std::string> Line();
  /// Whether a line came within that time; it is taken. False as well where there is none any more.
  bool LineWithin(std::chrono::milliseconds time);
  /// Forgets what was typed at a terminal before anybody was asked: an Enter too many answers
  /// nothing. Lines of a pipe stay: who writes them knows what comes.
  void ForgetTyped();
  /// Asks until one of these words stands there, in any case; nothing: there is no line any more.
  std::optional<std::string> AskForWord(const std::string& text,
                                        const std::vector<std::string>& words);
  /// Asks until the answer is of the question's kind.
  std::optional<std::string> Ask(const StudyQuestion& question);

 private:
  bool Fill(int timeout_ms);

  int input_;
  std::FILE* output_;
  std::string waiting_;
  bool ended_ = false;
};

/// The answer that a line gives to the question: a choice by its number or its words, a number of
/// the scale, a text. Nothing: it is none.
std::optional<std::string> AnswerOf(const StudyQuestion& question, const std::string& line);

}  // namespace tandem
