#include "app/peer/scene_consent.h"

#include <cstdio>
#include <memory>
#include <string>

#include <unistd.h>

#include "app/common/console.h"
#include "app/common/progress_bar.h"
#include "engine/base/text/clean_text.h"
#include "engine/base/units.h"
#include "engine/realtime/clock.h"

namespace tandem {

namespace {

/// Asks the person. Returns why not, in a line; empty: yes.
std::string AskPerson(const OfferedScene& offered) {
  if (isatty(STDIN_FILENO) == 0 || isatty(STDERR_FILENO) == 0) {
    return "it can be fetched (" + offered.Words() +
           "), but there is no terminal to ask at: give --accept-scene to fetch it";
  }
  std::fprintf(stderr, "Fetch %s? [y/N] ", CleanText(offered.Words()).c_str());
  std::string answer;
  for (int c = std::getchar(); c != EOF && c != '\n'; c = std::getchar()) {
    if (answer.size() < 16) answer += static_cast<char>(c);
  }
  const bool yes = answer == "y" || answer == "Y" || answer == "yes";
  return yes ? "" : "the scene is not fetched, as you chose";
}

/// Shows a bar, or says a line every few seconds where nobody sees a bar.
class Progress {
 public:
  void Show(std::uint64_t bytes, std::uint64_t of) {
    if (of == 0) return;
    const double share = static_cast<double>(bytes) / static_cast<double>(of);
    if (isatty(STDERR_FILENO) != 0) {
      if (!bar_) bar_ = std::make_unique<ProgressBar>(of / 1'000'000 + 1, false);
      bar_->Show(bytes / 1'000'000, share);
      if (bytes == of) bar_.reset();
      return;
    }
    const std::int64_t now_ns = MonotonicNowNs();
    if (last_ns_ == 0) last_ns_ = now_ns;
    if (now_ns - last_ns_ < kLineNs) return;
    last_ns_ = now_ns;
    Say("fetched " + std::to_string(bytes / 1'000'000) + " of " + std::to_string(of / 1'000'000) +
        " MB");
  }

 private:
  static constexpr std::int64_t kLineNs = 5000 * kMs;
  std::unique_ptr<ProgressBar> bar_;
  std::int64_t last_ns_ = 0;
};

}  // namespace

SessionSceneOptions SceneSearchOptions(const std::string& session, PeerId id, Role role,
                                       const ConnectionOptions& connection,
                                       const SceneFetchOptions& fetch) {
  SessionSceneOptions options;
  options.session = session;
  options.id = id;
  options.role = role;
  options.connection = connection;
  options.most_bytes = fetch.limit_mb * 1'000'000;
  options.say = Say;
  options.refuses = [accept = fetch.accept](const OfferedScene& offered) {
    return accept ? std::string() : AskPerson(offered);
  };
  options.progress = [progress = std::make_shared<Progress>()](std::uint64_t bytes,
                                                               std::uint64_t of) {
    progress->Show(bytes, of);
  };
  return options;
}

}  // namespace tandem
