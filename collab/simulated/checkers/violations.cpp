#include "collab/simulated/checkers/violations.h"

#include <cstdarg>
#include <cstdio>

#include "engine/base/units.h"

namespace tandem {

void Violations::Add(const std::string& sort, PeerId peer, const std::string& what) {
  if (sorts_[sort]++ > 0) return;
  all_.push_back(Text("at %.3f s: ", ToSeconds(now_ns_)) + sort + ": peer " + std::to_string(peer) +
                 (what.empty() ? "" : ", " + what));
}

std::string Text(const char* format, ...) {
  char text[200];
  std::va_list arguments;
  va_start(arguments, format);
  std::vsnprintf(text, sizeof text, format, arguments);
  va_end(arguments);
  return text;
}

}  // namespace tandem
