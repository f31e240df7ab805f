#include "app/cli/replay_viewers.h"

#include <utility>

#include "app/common/console.h"
#include "app/common/exit_codes.h"
#include "collab/dds/transport/dds_transport.h"
#include "collab/session/viewer.h"
#include "engine/realtime/clock.h"

namespace tandem {

namespace {

constexpr std::int64_t kReplaySettleNs = 1'000'000'000;  // to discover peers in the session

/// Sends nothing, for a replay without viewers.
class Nowhere final : public Transport {
 public:
  void Publish(const ObjectState&) override {}
  void Publish(const ObjectState&, const CouplingLinks&) override {}
  void Publish(const ViewFrame&) override {}
  void Publish(const PeerInfo&) override {}
  void Publish(const Event&) override {}
  void Publish(const SceneManifest&) override {}
  void Leave() override {}
};

/// Sends only what viewers need of a peer, under an id of the replay's own. A replay is seen, and
/// does not take part.
class ViewersOnly final : public Transport {
 public:
  ViewersOnly(std::unique_ptr<Transport> to, PeerId as) : to_(std::move(to)), as_(as) {}
  void Publish(const ObjectState&) override {}
  void Publish(const ObjectState&, const CouplingLinks&) override {}
  void Publish(const ViewFrame& frame) override {
    ViewFrame ours = frame;
    ours.peer = as_;
    to_->Publish(ours);
  }
  void Publish(const PeerInfo& info) override {
    PeerInfo ours = info;
    ours.peer = as_;
    ours.name = ReplayName(info.name);
    ours.claims.clear();  // the replay answers for nothing
    to_->Publish(ours);
  }
  void Publish(const Event&) override {}
  void Publish(const SceneManifest& manifest) override {
    SceneManifest ours = manifest;
    ours.offered_by = as_;
    to_->Publish(ours);
  }
  void Leave() override { to_->Leave(); }

 private:
  std::unique_ptr<Transport> to_;
  PeerId as_;
};

}  // namespace

std::string NotBeside(const std::string& name, const std::string& session) {
  return name + " takes part in session " + session + ": a replay is shown in a session of its own";
}

Result<std::unique_ptr<Transport>> JoinForViewers(const std::string& session,
                                                  const ConnectionOptions& connection,
                                                  ActivePeerInbox& active_peers, int& exit_code) {
  if (session.empty()) return std::unique_ptr<Transport>(std::make_unique<Nowhere>());
  exit_code = kExitSecurity;
  std::string name;
  const Result<PeerId> id = Identify(connection, Role::kActive, name);
  if (!id) return id.error();
  if (connection.secure.empty()) exit_code = kExitNetwork;
  DdsOptions dds;
  dds.session = session;
  dds.peer = *id;
  ApplyConnection(connection, dds);
  Result<std::unique_ptr<Transport>> joined = JoinOverDds(dds, active_peers);
  if (!joined) return joined.error();
  exit_code = kExitNetwork;
  for (const std::int64_t begin_ns = MonotonicNowNs();
       MonotonicNowNs() - begin_ns < kReplaySettleNs;) {
    if (const auto other = active_peers.Active()) return Error{NotBeside(*other, session)};
    MachineClock().SleepUntil(MonotonicNowNs() + 10'000'000);
  }
  Say(SecurityOf(connection, session));
  return std::unique_ptr<Transport>(std::make_unique<ViewersOnly>(*std::move(joined), *id));
}

}  // namespace tandem
