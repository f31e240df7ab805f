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

#include "collab/sessions_nearby.h"
#include "collab/transport.h"
#include "collab/viewer.h"
#include "engine/base/result.h"

namespace tandem {

/// Where and under what name a viewer joins.
struct JoinRequest {
  std::string session;
  std::string name;
  std::uint32_t domain = 42;
  std::string interface;                // empty: the middleware's choice
  bool from_relay = false;              // the session as its relay shows it
  bool secured = false;                 // by keys, which nobody else has
  PeerId peer = 0;                      // whom the keys belong to; 0: a new id each time
  std::vector<std::string> peers = {};  // HOST or HOST:PORT, beyond the local network
  std::string external_address = {};    // behind a router
  std::uint16_t port = 0;               // 0: automatic
  std::string secure = {};              // folder of keys; empty: those of the command line
  bool chosen_here = false;             // the last four count, not the command line's
};

/// Enters a session for a viewer of the given id; may take a while. Over DDS in the product.
using JoinFunction =
    std::function<Result<std::unique_ptr<Transport>>(const JoinRequest&, PeerId, Inbox&)>;

/// Listens for other sessions, for a viewer that has joined and may have the wrong name.
using ListenFunction = std::function<std::unique_ptr<SessionsNearby>(const JoinRequest&)>;

/// The window's part in a session: joins without blocking the GUI, tells others who looks on,
/// leaves with a goodbye. GUI thread only; the Viewer inside is fed by the transport's threads.
class SessionModel : public QObject {
  Q_OBJECT

 public:
  enum class State { kIdle, kJoining, kJoined, kLeft, kFailed };

  explicit SessionModel(JoinFunction join, ListenFunction listen = {}, QObject* parent = nullptr);
  ~SessionModel() override;  // leaves

  /// Only when neither joining nor joined.
  void Join(const JoinRequest& request);
  /// Does nothing when not joined.
  void Leave();

  State state() const { return state_; }
  const QString& error() const {
    return error_;
  }  // in state kFailed: what went wrong, for a person
  const JoinRequest& request() const { return request_; }
  /// Whether anybody was heard in this session.
  bool heard() const { return heard_; }
  /// In state kJoined while nobody was heard: what may be wrong, in a line for a person.
  const QString& nobody_heard() const { return nobody_heard_; }
  /// What the session looks like now; after Leave() what it looked like last, nobody known to be
  /// here any more.
  ViewerPicture Picture() const;
  /// The viewer of the current or last session; null before the first.
  const Viewer* viewer() const { return viewer_.get(); }

 Q_SIGNALS:
  /// Also when the first is heard, and when what is known of other sessions changes.
  void StateChanged();

 private:
  void SetState(State state, const QString& error = {});
  /// `reason`: why, if nobody asked for it.
  void LeaveBecause(const QString& reason);
  void OnJoinEnded();
  void PublishPresence();
  void ListenForCompany();

  JoinFunction join_;
  ListenFunction listen_;
  JoinRequest request_;
  PeerId peer_ = 0;
  std::uint32_t beat_ = 0;
  State state_ = State::kIdle;
  QString error_;
  std::thread joiner_;
  std::optional<Result<std::unique_ptr<Transport>>>
      join_result_;                       // by joiner_, read after it ended
  std::unique_ptr<Viewer> viewer_;        // outlives the transport
  std::unique_ptr<Transport> transport_;  // null unless joined
  QTimer beat_timer_;
  QElapsedTimer since_joined_;
  bool heard_ = false;
  QString nobody_heard_;
  std::unique_ptr<SessionsNearby> nearby_;  // while nobody is heard
};

/// "Joined", "Not joined" … for the status bar.
QString Describe(SessionModel::State state);

}  // namespace tandem
