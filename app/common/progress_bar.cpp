#include "app/common/progress_bar.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include <unistd.h>

#include "engine/base/units.h"
#include "engine/realtime/clock.h"

namespace tandem {

namespace {

constexpr int kWidth = 30;
constexpr std::int64_t kLeastNs = 200'000'000;

// Returns a time in words, such as 41 s, 12 min or 3.4 h.
std::string ReasonText(double seconds) {
  char text[32];
  if (seconds < 100) {
    std::snprintf(text, sizeof text, "%.0f s", std::ceil(seconds));
  } else if (seconds < 6000) {
    std::snprintf(text, sizeof text, "%.0f min", std::ceil(seconds / 60));
  } else {
    std::snprintf(text, sizeof text, "%.1f h", seconds / 3600);
  }
  return text;
}

}  // namespace

std::string ProgressLine(std::size_t done, std::size_t of, double share, double elapsed_s) {
  share = std::clamp(share, 0.0, 1.0);
  const auto full = static_cast<std::size_t>(kWidth * share);
  std::string line = "[";
  line.append(full, '#').append(kWidth - full, ' ').append("] ");
  line.append(std::to_string(done)).append(" of ").append(std::to_string(of));
  // the first moments say nothing of the rest
  if (share > 0.01)
    line.append(", ").append(ReasonText(elapsed_s * (1 / share - 1))).append(" left");
  return line;
}

ProgressBar::ProgressBar(std::size_t of, bool always)
    : of_(of), shown_(always || isatty(STDERR_FILENO) != 0), began_ns_(MonotonicNowNs()) {}

ProgressBar::~ProgressBar() {
  if (shown_ && last_ns_ != 0) std::fprintf(stderr, "\r\x1b[K");
}

void ProgressBar::Show(std::size_t done, double share) {
  const std::int64_t now_ns = MonotonicNowNs();
  if (!shown_ || (now_ns - last_ns_ < kLeastNs && done < of_)) return;
  last_ns_ = now_ns;
  const double elapsed_s = ToSeconds(now_ns - began_ns_);
  std::fprintf(stderr, "\r\x1b[K%s", ProgressLine(done, of_, share, elapsed_s).c_str());
}

}  // namespace tandem
