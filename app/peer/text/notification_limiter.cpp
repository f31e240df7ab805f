#include "app/peer/text/notification_limiter.h"

#include <algorithm>
#include <utility>

#include "engine/base/units.h"

namespace tandem {

void NotificationLimiter::Add(const std::string& about, const std::string& line) {
  const auto same = [&about](const Line& one) {
    return one.about == about;
  };
  // newer lines say more than older ones
  if (!about.empty() &&
      static_cast<std::size_t>(std::ranges::count_if(waiting_, same)) >= kMostOfOne) {
    waiting_.erase(std::ranges::find_if(waiting_, same));
    ++left_out_;
  } else if (waiting_.size() >= kMostWaiting) {
    // this program's own lines stay longest
    const auto other = std::ranges::find_if(waiting_, [](const Line& one) {
      return !one.about.empty();
    });
    waiting_.erase(other != waiting_.end() ? other : waiting_.begin());
    ++left_out_;
  }
  waiting_.push_back({about, line});
}

std::vector<std::string> NotificationLimiter::Due(std::int64_t now_ns) {
  std::vector<std::string> output;
  for (auto line = waiting_.begin(); line != waiting_.end() && HasRoom(now_ns);) {
    const auto last = told_ns_.find(line->about);
    if (!line->about.empty() && last != told_ns_.end() && now_ns - last->second < kSecondNs) {
      ++line;
      continue;
    }
    if (!line->about.empty()) told_ns_[line->about] = now_ns;
    Say(now_ns, std::move(line->text), output);
    line = waiting_.erase(line);
  }
  if (left_out_ != left_out_told_ && waiting_.empty() && HasRoom(now_ns)) {
    Say(now_ns, "(" + std::to_string(left_out_ - left_out_told_) + " more lines left out)", output);
    left_out_told_ = left_out_;
  }
  ForgetNames(now_ns);
  return output;
}

std::vector<std::string> NotificationLimiter::Rest() {
  std::vector<std::string> rest;
  for (Line& line : waiting_) rest.push_back(std::move(line.text));
  waiting_.clear();
  if (left_out_ != left_out_told_) {
    rest.push_back("(" + std::to_string(left_out_ - left_out_told_) + " more lines left out)");
    left_out_told_ = left_out_;
  }
  return rest;
}

bool NotificationLimiter::HasRoom(std::int64_t now_ns) const {
  return said_ns_.size() < kMostPerSecond || now_ns - said_ns_.front() >= kSecondNs;
}

void NotificationLimiter::Say(std::int64_t now_ns, std::string line,
                              std::vector<std::string>& output) {
  if (said_ns_.size() >= kMostPerSecond) said_ns_.pop_front();
  said_ns_.push_back(now_ns);
  output.push_back(std::move(line));
}

void NotificationLimiter::ForgetNames(std::int64_t now_ns) {
  if (told_ns_.size() < kMostNames) return;
  std::erase_if(told_ns_, [now_ns](const auto& one) {
    return now_ns - one.second >= kSecondNs;
  });
}

std::string SubjectOf(const std::string& line, const std::vector<std::string>& names) {
  std::string whom;
  for (const std::string& name : names) {
    if (name.size() > whom.size() && line.starts_with(name + " ")) whom = name;
  }
  return whom;
}

}  // namespace tandem
