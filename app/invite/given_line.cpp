#include "app/invite/given_line.h"

#include <algorithm>
#include <array>
#include <csignal>
#include <cstdio>
#include <cstring>

#include <termios.h>
#include <unistd.h>

#include "app/invite/invitation.h"
#include "engine/base/files/regular_file.h"

namespace tandem {
namespace {

constexpr std::size_t kLongestInput = 4096;  // bytes; a terminal's line has no more

constexpr std::array kEndings{SIGINT, SIGQUIT, SIGTERM, SIGHUP};

// the terminal before its echo went off; a handler of a signal reaches nothing else
termios g_before{};

void HandBack(int signal) {
  tcsetattr(STDIN_FILENO, TCSANOW, &g_before);
  raise(signal);  // its default action comes when this handler returns
}

/// Switches the echo of a terminal off while it lives, and until a signal ends the program. Stdin
/// may be something else.
class WithoutEcho {
 public:
  WithoutEcho() : is_terminal_(tcgetattr(STDIN_FILENO, &g_before) == 0) {
    if (!is_terminal_) return;
    struct sigaction hands_back {};
    hands_back.sa_handler = HandBack;
    hands_back.sa_flags = static_cast<int>(SA_RESETHAND);
    for (std::size_t i = 0; i < kEndings.size(); ++i) {
      sigaction(kEndings[i], nullptr, &handlers_[i]);
      // a signal that the program handles or ignores does not end it
      if (handlers_[i].sa_handler == SIG_DFL) sigaction(kEndings[i], &hands_back, nullptr);
    }
    termios quiet = g_before;
    quiet.c_lflag &= ~static_cast<tcflag_t>(ECHO);
    tcsetattr(STDIN_FILENO, TCSANOW, &quiet);
  }
  ~WithoutEcho() {
    if (!is_terminal_) return;
    tcsetattr(STDIN_FILENO, TCSANOW, &g_before);
    for (std::size_t i = 0; i < kEndings.size(); ++i) {
      sigaction(kEndings[i], &handlers_[i], nullptr);
    }
  }
  WithoutEcho(const WithoutEcho&) = delete;
  WithoutEcho& operator=(const WithoutEcho&) = delete;

 private:
  std::array<struct sigaction, kEndings.size()> handlers_{};
  bool is_terminal_;
};

Result<std::string> LineOfStdin() {
  const bool asks = isatty(STDIN_FILENO) != 0;
  if (asks) std::fputs("Paste the invitation (it is not shown), then press Enter: ", stderr);
  std::string line;
  {
    const WithoutEcho quiet;
    char c = 0;
    while (line.size() <= kLongestInput && read(STDIN_FILENO, &c, 1) == 1 && c != '\n') line += c;
  }
  if (asks) std::fputs("\n", stderr);
  if (line.empty()) return Error{"no invitation came from stdin: give the line that you were sent"};
  return line;
}

}  // namespace

std::vector<std::string> TakeWords(int argc, char** argv) {
  std::vector<std::string> words(argv, argv + argc);
  for (int i = 1; i < argc; ++i) {
    char* const begin = std::strstr(argv[i], "tandem://");
    char* const secret = begin == nullptr ? nullptr : std::strchr(begin, '#');
    // a shell's word may stand behind "--invitation="
    if (secret != nullptr) std::fill(secret + 1, secret + std::strlen(secret), 'x');
  }
  return words;
}

Result<std::string> GivenLine(const std::string& word) {
  if (word == "-") return LineOfStdin();
  if (!word.starts_with('@')) return word;
  Result<std::string> text = ReadWholeFile(word.substr(1), kLongestInput);
  if (!text) return text.error();
  return text->substr(0, text->find('\n'));
}

}  // namespace tandem
