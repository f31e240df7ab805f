#pragma once

#include <QElapsedTimer>
#include <QObject>
#include <QString>
#include <QTimer>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "collab/session/person_colour.h"
#include "collab/session/sessions_nearby.h"
#include "collab/session/transport.h"
#include "collab/session/viewer.h"
#include "engine/base/result.h"

namespace tandem {

/// The session that a viewer joins, and how.
struct JoinRequest {
  std::string session;
  std::string name;
  std::uint32_t domain = 42;
  std::string interface;                // network interface; empty: the middleware's choice
  bool from_relay = false;              // true: look at the session through its relay
  bool secured = false;                 // true: the session has keys
  PeerId peer = 0;                      // owner of the keys; 0: a new id each time
  std::vector<std::string> peers = {};  // HOST or HOST:PORT, beyond the local network
  std::string external_address = {};    // address outside, behind a router
  std::uint16_t port = 0;               // 0: automatic
  std::string secure = {};              // folder of keys; empty: the command line's
  bool chosen_here = false;             // true: the last four count, not the command line's
};

/// Enters a session for a viewer of the given id; may take a while. Uses DDS in the product.
using JoinFunction =
    std::function<Result<std::unique_ptr<Transport>>(const JoinRequest&, PeerId, Inbox&)>;

/// Listens for other sessions on behalf of a joined viewer, whose session name may be wrong.
using ListenFunction = std::function<std::unique_ptr<SessionsNearby>(const JoinRequest&)>;

/// The window's part in a session. Joins without blocking the GUI, publishes the viewer's presence,
/// and leaves with a goodbye. GUI thread only; the transport's threads feed the Viewer inside.
class SessionModel : public QObject {
  Q_OBJECT

 public:
  enum class State { kIdle, kJoining, kJoined, kLeft, kFailed };

  explicit SessionModel(JoinFunction join, ListenFunction listen = {}, QObject* parent = nullptr);
  ~SessionModel() override;  // leaves

  /// Joins. Allowed only when neither joining nor joined.
  void Join(const JoinRequest& request);
  /// Leaves; does nothing when not joined.
  void Leave();

  State state() const { return state_; }
  const QString& error() const { return error_; }  // description for a person, in state kFailed
  const JoinRequest& request() const { return request_; }
  /// Returns whether a peer was heard in this session.
  bool has_peers() const { return has_peers_; }
  /// Says in a line for a person what may be wrong, in state kJoined while no peer is heard.
  const QString& nobody_heard() const { return nobody_heard_; }
  /// Returns the other sessions that are announced, while no peer is heard.
  const std::vector<AnnouncedSession>& others() const { return others_; }
  /// Returns whether it has listened so long that peers who are here would have been heard.
  bool listened() const { return listened_; }
  /// Returns the session's state. After Leave() it is the last state, with no peer known to be
  /// here.
  ViewerPicture Picture() const;
  /// The viewer of the current or last session; null before the first.
  const Viewer* viewer() const { return viewer_.get(); }

 Q_SIGNALS:
  /// Also emitted when the first peer is heard, and when the list of other sessions changes.
  void StateChanged();

 private:
  void SetState(State state, const QString& error = {});
  /// Leaves. `reason`: set if the user did not ask for it.
  void LeaveBecause(const QString& reason);
  void OnJoinEnded();
  void PublishPresence();
  void ListenForPeers();

  JoinFunction join_;
  ListenFunction listen_;
  JoinRequest request_;
  PeerId peer_ = 0;
  std::uint32_t beat_ = 0;
  State state_ = State::kIdle;
  QString error_;
  std::thread joiner_;
  std::optional<Result<std::unique_ptr<Transport>>>
      join_result_;                       // set by joiner_, read after it has ended
  std::unique_ptr<Viewer> viewer_;        // outlives the transport
  std::unique_ptr<Transport> transport_;  // null unless joined
  QTimer beat_timer_;
  QElapsedTimer since_joined_;
  bool has_peers_ = false;
  bool listened_ = false;
  std::vector<AnnouncedSession> others_;
  PersonColour colour_ = 0;
  QString nobody_heard_;
  std::unique_ptr<SessionsNearby> nearby_;  // set while no peer is heard
};

/// Returns "Joined", "Not joined" and so on for the status bar.
QString Describe(SessionModel::State state);

/// Returns the same in a line with the session's name. A session is joined when a peer answers;
/// else the line says that none does, and which sessions are announced.
QString Describe(const SessionModel& session);

}  // namespace tandem
