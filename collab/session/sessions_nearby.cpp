#include "collab/session/sessions_nearby.h"

namespace tandem {

namespace {

/// Names a session for a person.
std::string TextOf(const AnnouncedSession& session) {
  const std::string& name = session.name;
  const std::string secured = session.secured ? " (secured)" : "";
  if (!name.ends_with(kBehindRelay)) return name + secured;
  return "the relay of " + name.substr(0, name.size() - kBehindRelay.size()) + secured;
}

}  // namespace

std::string NobodyHeard(const AnnouncedSession& own, const std::vector<AnnouncedSession>& nearby) {
  const std::string head = "nobody heard in session " + TextOf({own.name, false});
  std::string others;
  for (const AnnouncedSession& session : nearby) {
    if (session.name != own.name) {
      others += (others.empty() ? "" : ", ") + TextOf(session);
    } else if (session.secured && !own.secured) {
      return head + ": it is secured, and needs a viewer's keys (--secure)";
    } else if (session.secured) {
      return head + ": others are in it by keys that do not fit yours";
    } else if (own.secured) {
      return head + ": it is plain, and you came with keys (--secure)";
    }
  }
  if (others.empty()) return head + ": another name, network, domain or keys?";
  return head + "; announced here: " + others;
}

}  // namespace tandem
