#include "app/view/model/session/session_model.h"

#include <random>
#include <utility>

#include "app/view/model/words/window_words.h"
#include "engine/base/check.h"

namespace tandem {

namespace {

constexpr int kBeatMs = 250;
constexpr qint64 kListenMs = 2000;  // peers that are here are heard sooner, even over a slow link

PeerId RandomPeerId() {
  std::random_device device;
  PeerId id = 0;
  while (id == 0) id = (static_cast<PeerId>(device()) << 32U) | device();
  return id;
}

}  // namespace

SessionModel::SessionModel(JoinFunction join, ListenFunction listen, QObject* parent)
    : QObject(parent), join_(std::move(join)), listen_(std::move(listen)) {
  beat_timer_.setInterval(kBeatMs);
  connect(&beat_timer_, &QTimer::timeout, this, &SessionModel::PublishPresence);
  connect(&beat_timer_, &QTimer::timeout, this, &SessionModel::ListenForPeers);
}

SessionModel::~SessionModel() {
  if (joiner_.joinable()) joiner_.join();
  if (join_result_ && *join_result_) (**join_result_)->Leave();
  join_result_.reset();
  if (transport_) transport_->Leave();
  transport_.reset();
}

void SessionModel::Join(const JoinRequest& request) {
  TANDEM_CHECK(state_ != State::kJoining && state_ != State::kJoined);
  request_ = request;
  peer_ = request.peer != 0 ? request.peer : RandomPeerId();
  viewer_ = std::make_unique<Viewer>();
  has_peers_ = listened_ = false;
  others_.clear();
  colour_ = 0;
  nobody_heard_ =
      tr("no peer answers yet in session %1").arg(QString::fromStdString(request.session));
  SetState(State::kJoining);
  joiner_ = std::thread([this, request, peer = peer_, viewer = viewer_.get()] {
    join_result_.emplace(join_(request, peer, *viewer));
    QMetaObject::invokeMethod(this, &SessionModel::OnJoinEnded, Qt::QueuedConnection);
  });
}

void SessionModel::OnJoinEnded() {
  joiner_.join();
  Result<std::unique_ptr<Transport>> result = *std::exchange(join_result_, std::nullopt);
  if (!result) {
    SetState(State::kFailed, WordsForWindow(QString::fromStdString(result.error().what)));
    return;
  }
  transport_ = *std::move(result);
  PublishPresence();
  if (transport_ == nullptr) return;  // the keys have ended
  beat_timer_.start();
  since_joined_.start();
  if (listen_) nearby_ = listen_(request_);
  SetState(State::kJoined);
}

void SessionModel::ListenForPeers() {
  if (has_peers_ || transport_ == nullptr) return;
  has_peers_ = !viewer_->Picture().peers.empty();
  if (has_peers_) {
    nearby_.reset();
    others_.clear();
    nobody_heard_.clear();
    Q_EMIT StateChanged();
    return;
  }
  std::vector<AnnouncedSession> others;
  if (nearby_ != nullptr) others = nearby_->Heard();
  if (others.empty() && since_joined_.elapsed() < kListenMs) return;
  const std::string name = request_.session + std::string(request_.from_relay ? kBehindRelay : "");
  const QString text =
      WordsForWindow(QString::fromStdString(NobodyHeard({name, request_.secured}, others)));
  if (text == nobody_heard_ && listened_) return;
  listened_ = true;
  others_ = std::move(others);
  nobody_heard_ = text;
  Q_EMIT StateChanged();
}

void SessionModel::PublishPresence() {
  if (const std::string ended = transport_->KeysEnd(); !ended.empty()) {
    LeaveBecause(QString::fromStdString(ended));
    return;
  }
  PeerInfo info;
  info.peer = peer_;
  info.beat = beat_++;
  info.role = Role::kViewer;
  info.name = request_.name;
  const ViewerPicture picture = viewer_->Picture();
  if (picture.scene) info.scene_hash = picture.scene->content_hash;
  info.colour = colour_ = viewer_->ColourFor(info, colour_);
  transport_->Publish(info);
}

void SessionModel::Leave() {
  if (state_ == State::kJoined) LeaveBecause({});
}

void SessionModel::LeaveBecause(const QString& reason) {
  beat_timer_.stop();
  nearby_.reset();
  transport_->Leave();
  transport_.reset();
  SetState(State::kLeft, reason);
}

ViewerPicture SessionModel::Picture() const {
  ViewerPicture picture;
  if (viewer_ == nullptr) return picture;
  picture = viewer_->Picture();
  if (state_ != State::kLeft) return picture;
  using Presence = ViewedPeer::Presence;
  for (ViewedPeer& peer : picture.peers) {
    if (peer.presence == Presence::kHere) peer.presence = Presence::kUnknown;
  }
  return picture;
}

void SessionModel::SetState(State state, const QString& error) {
  state_ = state;
  error_ = error;
  Q_EMIT StateChanged();
}

QString Describe(SessionModel::State state) {
  switch (state) {
    case SessionModel::State::kIdle:
      return SessionModel::tr("Not joined");
    case SessionModel::State::kJoining:
      return SessionModel::tr("Joining\u2026");
    case SessionModel::State::kJoined:
      return SessionModel::tr("Joined");
    case SessionModel::State::kLeft:
      return SessionModel::tr("You left");
    case SessionModel::State::kFailed:
      return SessionModel::tr("Could not join");
  }
  return {};
}

QString Describe(const SessionModel& session) {
  using State = SessionModel::State;
  const QString name = QString::fromStdString(session.request().session);
  if (session.state() == State::kJoined) {
    if (session.has_peers()) return SessionModel::tr("Joined \u201c%1\u201d").arg(name);
    if (!session.listened()) return SessionModel::tr("Looking for \u201c%1\u201d\u2026").arg(name);
    QString text = session.nobody_heard();  // a sentence here, part of a sentence elsewhere
    if (!text.isEmpty()) text[0] = text[0].toUpper();
    return text;
  }
  const QString text = Describe(session.state());
  return session.error().isEmpty() ? text : text + QStringLiteral(": ") + session.error();
}

}  // namespace tandem
