#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace tandem {

/// Suffix that a relay adds to a session's name for the session that it shows (GoToRelay).
inline constexpr std::string_view kBehindRelay = "/view";

/// A session as its programs announce it to a whole domain.
struct AnnouncedSession {
  std::string name;
  bool secured = false;

  friend auto operator<=>(const AnnouncedSession&, const AnnouncedSession&) = default;
};

/// Listens to the announcements of all sessions of a domain; sends nothing. For one thread.
class SessionsNearby {
 public:
  virtual ~SessionsNearby() = default;
  /// Returns the announcements of other programs so far, by name.
  virtual std::vector<AnnouncedSession> Heard() = 0;
};

/// Returns a line for a person who joined `own` and hears nobody: other sessions nearby, or the
/// possible fault.
std::string NobodyHeard(const AnnouncedSession& own, const std::vector<AnnouncedSession>& nearby);

}  // namespace tandem
