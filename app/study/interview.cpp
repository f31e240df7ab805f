#include "app/study/interview.h"

#include <algorithm>
#include <array>
#include <cctype>

#include <poll.h>
#include <termios.h>
#include <unistd.h>

#include "engine/base/files/regular_file.h"
#include "engine/base/text/clean_text.h"

namespace tandem {

namespace {

constexpr std::size_t kLongestLine = 4096;

std::string Lower(std::string text) {
  std::ranges::transform(text, text.begin(), [](unsigned char c) {
    return static_cast<char>(std::tolower(c));
  });
  return text;
}

std::string Trimmed(std::string text) {
  std::erase_if(text, [](char c) {
    return static_cast<unsigned char>(c) < 0x20 || c == 0x7f;
  });
  const auto first = text.find_first_not_of(' ');
  if (first == std::string::npos) return {};
  return text.substr(first, text.find_last_not_of(' ') - first + 1);
}

/// Returns 0 if the line is not a whole number from 1 to `most`.
std::size_t NumberIn(const std::string& line, std::size_t most) {
  const bool digits =
      !line.empty() && line.size() < 4 && line.find_first_not_of("0123456789") == std::string::npos;
  const std::size_t number = digits ? std::stoul(line) : 0;
  return number <= most ? number : 0;
}

}  // namespace

std::optional<std::string> AnswerOf(const StudyQuestion& question, const std::string& line) {
  switch (question.kind) {
    case QuestionKind::kChoice: {
      for (const std::string& choice : question.choices) {
        if (Lower(choice) == Lower(line)) return choice;
      }
      const std::size_t number = NumberIn(line, question.choices.size());
      if (number == 0) return std::nullopt;
      return question.choices[number - 1];
    }
    case QuestionKind::kScale: {
      const std::size_t number = NumberIn(line, kScaleMost);
      if (number == 0) return std::nullopt;
      return std::to_string(number);
    }
    case QuestionKind::kText:
      break;
  }
  if (line.size() > kLongestAnswer) return std::nullopt;
  return line;
}

void Interview::Tell(const std::string& text) {
  std::fprintf(output_, "%s\n", CleanLines(text).c_str());
  std::fflush(output_);
}

bool Interview::Fill(int timeout_ms) {
  pollfd poll_for{input_, POLLIN, 0};
  if (ended_ || poll(&poll_for, 1, timeout_ms) <= 0) return false;
  std::array<char, 1024> buffer{};
  const ssize_t got = read(input_, buffer.data(), buffer.size());
  if (got <= 0) {
    ended_ = true;
    return false;
  }
  waiting_.append(buffer.data(), static_cast<std::size_t>(got));
  return true;
}

std::optional<std::string> Interview::Line() {
  while (waiting_.find('\n') == std::string::npos) {
    if (waiting_.size() > kLongestLine) waiting_.resize(kLongestLine);
    if (!Fill(-1) && ended_) return std::nullopt;
  }
  const std::size_t end = waiting_.find('\n');
  const std::string line = waiting_.substr(0, end);
  waiting_.erase(0, end + 1);
  return Trimmed(line);
}

bool Interview::LineWithin(std::chrono::milliseconds time) {
  if (waiting_.find('\n') == std::string::npos && !Fill(static_cast<int>(time.count()))) {
    // at the end of the input, waits for the time alone
    if (ended_) poll(nullptr, 0, static_cast<int>(time.count()));
    return false;
  }
  if (waiting_.find('\n') == std::string::npos) return false;
  return Line().has_value();
}

void Interview::ForgetTyped() {
  if (isatty(input_) == 0) return;
  tcflush(input_, TCIFLUSH);
  waiting_.clear();
}

std::optional<std::string> Interview::AskForWord(const std::string& text,
                                                 const std::vector<std::string>& words) {
  std::string known;
  for (const std::string& word : words) known += (known.empty() ? "" : " or ") + word;
  for (;;) {
    Tell(text + " (" + known + ")");
    const std::optional<std::string> line = Line();
    if (!line) return std::nullopt;
    const auto found = std::ranges::find(words, Lower(*line));
    if (found != words.end()) return *found;
  }
}

std::optional<std::string> Interview::Ask(const StudyQuestion& question) {
  for (;;) {
    Tell(question.text);
    if (question.kind == QuestionKind::kChoice) {
      for (std::size_t i = 0; i < question.choices.size(); ++i) {
        Tell("  " + std::to_string(i + 1) + "  " + question.choices[i]);
      }
    } else if (question.kind == QuestionKind::kScale) {
      Tell("  a number from 1" + (question.low.empty() ? "" : " (" + question.low + ")") + " to 7" +
           (question.high.empty() ? "" : " (" + question.high + ")"));
    } else {
      Tell("  in your own words, without names; an empty line is an answer too");
    }
    const std::optional<std::string> line = Line();
    if (!line) return std::nullopt;
    if (const auto answer = AnswerOf(question, *line)) return answer;
    Tell("'" + PlainLine(line->substr(0, 40)) + "' is not an answer to this question:");
  }
}

}  // namespace tandem
