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
  const std::string head = "no peer answers in session " + TextOf({own.name, false});
  std::string others;
  for (const AnnouncedSession& session : nearby) {
    if (session.name != own.name) {
      others += (others.empty() ? "" : ", ") + TextOf(session);
    } else if (session.secured && !own.secured) {
      return head + ": it is secured, and needs a viewer's keys (--secure)";
    } else if (session.secured) {
      return head + ": others are in it, but their keys and yours are not of the same session";
    } else if (own.secured) {
      return head + ": it is plain, but you came with keys: leave --secure out";
    }
  }
  if (others.empty()) return head + ": is its name, network, domain or --secure another one?";
  return head + "; announced here: " + others;
}

}  // namespace tandem
