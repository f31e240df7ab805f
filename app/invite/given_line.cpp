#include "app/invite/given_line.h"

#include <algorithm>
#include <cstdio>
#include <cstring>

#include <termios.h>
#include <unistd.h>

#include "app/invite/invitation.h"
#include "engine/base/files/regular_file.h"

namespace tandem {
namespace {

constexpr std::size_t kLongestInput = 4096;  // bytes; a terminal's line has no more

/// Switches the echo of a terminal off while it lives. Stdin may be something else.
class WithoutEcho {
 public:
  WithoutEcho() : is_terminal_(tcgetattr(STDIN_FILENO, &before_) == 0) {
    if (!is_terminal_) return;
    termios quiet = before_;
    quiet.c_lflag &= ~static_cast<tcflag_t>(ECHO);
    tcsetattr(STDIN_FILENO, TCSANOW, &quiet);
  }
  ~WithoutEcho() {
    if (is_terminal_) tcsetattr(STDIN_FILENO, TCSANOW, &before_);
  }
  WithoutEcho(const WithoutEcho&) = delete;
  WithoutEcho& operator=(const WithoutEcho&) = delete;

 private:
  termios before_{};
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
