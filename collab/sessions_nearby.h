#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace tandem {

/// What a relay adds to a session's name for the name of what it shows (GoToRelay).
inline constexpr std::string_view kBehindRelay = "/view";

/// A session as its programs announce it to a whole domain.
struct AnnouncedSession {
  std::string name;
  bool secured = false;

  friend auto operator<=>(const AnnouncedSession&, const AnnouncedSession&) = default;
};

/// Listens for the announcements of all sessions of a domain; says nothing itself. For one thread.
class SessionsNearby {
 public:
  virtual ~SessionsNearby() = default;
  /// What was announced so far by other programs, by name.
  virtual std::vector<AnnouncedSession> Heard() = 0;
};

/// What to tell a person who joined `own` and hears nobody: which sessions there are instead, or
/// what may be wrong. One line.
std::string NobodyHeard(const AnnouncedSession& own, const std::vector<AnnouncedSession>& nearby);

}  // namespace tandem
