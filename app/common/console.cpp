#include "app/common/console.h"

#include <cstdarg>
#include <cstdio>

#include "engine/base/text/clean_text.h"

namespace tandem {

void PrintLine(const char* format, ...) {
  va_list arguments;
  va_list again;
  va_start(arguments, format);
  va_copy(again, arguments);
  const int size = std::vsnprintf(nullptr, 0, format, arguments);
  va_end(arguments);
  std::string line(size > 0 ? static_cast<std::size_t>(size) : 0, '\0');
  std::vsnprintf(line.data(), line.size() + 1, format, again);
  va_end(again);
  line = CleanText(line) + '\n';
  std::fwrite(line.data(), 1, line.size(), stdout);
}

void PrintText(std::string_view text) {
  std::string lines = CleanLines(text);
  if (lines.empty() || lines.back() != '\n') lines += '\n';
  std::fwrite(lines.data(), 1, lines.size(), stdout);
}

void SayAs(const char* program, std::string_view line) {
  const std::string whole = std::string(program) + ": " + CleanText(line) + '\n';
  std::fwrite(whole.data(), 1, whole.size(), stderr);
}

}  // namespace tandem
