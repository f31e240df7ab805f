#include "app/view/model/hand/hand_model.h"

#include <algorithm>
#include <utility>

#include "app/view/model/words/window_words.h"

namespace tandem {

namespace {
constexpr int kPollMs = 8;
constexpr qint64 kPatienceMs = 5000;  // for a controller that should be running
}  // namespace

HandModel::HandModel(AttachFunction attach, LaunchFunction launch, QObject* parent)
    : QObject(parent), attach_(std::move(attach)), launch_(std::move(launch)) {
  poll_.setInterval(kPollMs);
  poll_.setTimerType(Qt::PreciseTimer);
  connect(&poll_, &QTimer::timeout, this, &HandModel::Poll);
}

HandModel::~HandModel() {
  EndController();
  process_.reset();  // first, since an attachment in progress needs time to give up
  if (attaching_.joinable()) attaching_.join();
  attach_result_.reset();
  link_.reset();
}

void HandModel::Start(const HandRequest& request) {
  Leave();
  request_ = request;
  Result<std::unique_ptr<ControllerProcess>> started = launch_(request);
  if (!started) {
    SetState(State::kEnded, WordsForWindow(QString::fromStdString(started.error().what)));
    return;
  }
  process_ = *std::move(started);
  own_ = true;
  SetState(State::kStarting, tr("Starting\u2026"));
  poll_.start();
  TryToAttach();
}

void HandModel::TakeUp(const std::string& control, const std::string& name, bool own,
                       const std::string& secure) {
  Leave();
  request_ = {};
  request_.control = control;
  request_.name = name;
  request_.secure = secure;
  own_ = own;
  since_start_.start();
  SetState(State::kStarting,
           tr("Looking for controller \u201c%1\u201d").arg(QString::fromStdString(control)));
  poll_.start();
  TryToAttach();
}

void HandModel::StartAgain() {
  if (!can_start_again()) return;
  const ControllerSnapshot shown = last_;
  const HandRequest request = request_;
  Start(request);
  if (state_ == State::kStarting) last_ = shown;
  Q_EMIT StateChanged();
}

QStringList HandModel::EndController() {
  if (!link_ || !own_) return {};
  if (process_) process_->MarkOutput();
  link_->Quit();
  if (!process_) return {};
  process_->AwaitEnd();
  QStringList lines;
  for (const std::string& line : process_->LinesSinceMark()) {
    if (line.starts_with("the host ")) continue;  // this window asked it to end
    lines << WordsForWindow(QString::fromStdString(line));
  }
  return lines;
}

void HandModel::Leave() {
  poll_.stop();
  drop_attached_ = attaching_.joinable();
  const QStringList lines = EndController();
  link_.reset();
  process_.reset();
  last_ = {};
  asked_.reset();
  ForgetGoal();
  stop_asked_ = false;
  news_seen_ = 0;
  if (state_ != State::kNone) SetState(State::kNone);
  if (!lines.isEmpty()) Q_EMIT SessionEnded(lines);
}

void HandModel::TryToAttach() {
  if (attaching_.joinable()) return;
  drop_attached_ = false;
  attaching_ = std::thread([this, name = request_.control] {
    attach_result_.emplace(attach_(name));
    QMetaObject::invokeMethod(this, &HandModel::OnAttachEnded, Qt::QueuedConnection);
  });
}

void HandModel::OnAttachEnded() {
  attaching_.join();
  Result<std::unique_ptr<ControllerLink>> result = *std::exchange(attach_result_, std::nullopt);
  const bool dropped = std::exchange(drop_attached_, false);
  if (state_ != State::kStarting) return;
  if (dropped) {
    TryToAttach();  // another name is wanted
    return;
  }
  if (result) {
    link_ = *std::move(result);
    last_ = {};
    frame_seen_ = 0;
    SetState(State::kReady);
    if (std::exchange(stop_asked_, false)) Stop();
    return;
  }
  // a controller that was started here reports its own end
  if (process_ == nullptr && since_start_.elapsed() > kPatienceMs) {
    poll_.stop();
    SetState(State::kEnded, WordsForWindow(QString::fromStdString(result.error().what)));
    return;
  }
  TryToAttach();
}

void HandModel::Poll() {
  if (process_) {
    if (const std::optional<std::string> ended = process_->Ended()) {
      poll_.stop();
      drop_attached_ = attaching_.joinable();
      if (link_ && state_ == State::kReady) last_ = WithoutHand(link_->snapshot());
      // nothing of a dead hand is shown, and nothing is sent to it
      link_.reset();
      asked_.reset();
      ForgetGoal();
      process_.reset();
      SetState(State::kEnded, WordsForWindow(QString::fromStdString(*ended)));
      return;
    }
  }
  if (state_ == State::kStarting && process_) {
    const QString line = WordsForWindow(QString::fromStdString(process_->LastLine()));
    if (!line.isEmpty() && line != trouble_) SetState(State::kStarting, line);
  }
  if (!link_) return;
  link_->Poll();
  const bool attached = link_->attached();
  if (!attached && state_ == State::kReady) {
    last_ = WithoutHand(link_->snapshot());
    asked_.reset();
    ForgetGoal();
    SetState(State::kLost, tr("Your hand does not answer; waiting for it"));
  } else if (attached && state_ == State::kLost) {
    last_ = {};
    SetState(State::kReady);
  }
  TakeNotifications();
  const ControllerSnapshot& now = link_->snapshot();
  if (now.frame == frame_seen_) return;
  frame_seen_ = now.frame;
  if (grab_answered_ && now.hand.body >= 0) grab_pending_ = grab_answered_ = false;
  if (!grab_pending_ && (now.hand.body < 0 || retracing())) goal_.reset();
  if (asked_ && (!held() || *held() != asked_->body)) asked_.reset();
  Q_EMIT SnapshotCame();
}

void HandModel::TakeNotifications() {
  const ControllerSnapshot& now = link_->snapshot();
  if (now.news_count == news_seen_) return;
  news_seen_ = now.news_count;
  if (now.asked) {
    QString name = tr("somebody");
    for (const SnapshotPeer& peer : now.peers) {
      if (peer.id == now.asked->peer) name = QString::fromStdString(peer.name);
    }
    asked_ = {now.asked->peer, name, now.asked->body};
    Q_EMIT StateChanged();
    return;
  }
  // the state of the hand says that it is stopped
  const bool says_stop = now.hand.state == SnapshotHand::State::kStopped &&
                         QString::fromStdString(now.news).contains(QLatin1String("emergency stop"));
  if (!now.news.empty() && !says_stop) Tell(WordsForWindow(QString::fromStdString(now.news)));
}

const ControllerSnapshot& HandModel::snapshot() const {
  if (link_ == nullptr || state_ == State::kLost) return last_;
  return link_->snapshot();
}

void HandModel::HandOverAsked() {
  if (!asked_) return;
  const Asked asked = *std::exchange(asked_, std::nullopt);
  // an id, since names may be equal
  const QString id = QStringLiteral("%1").arg(qulonglong{asked.peer}, 16, 16, QLatin1Char('0'));
  Ask(tr("Hand over to %1").arg(asked.name), GiveRequest{id.toStdString()});
  Q_EMIT StateChanged();
}

void HandModel::KeepPart() {
  asked_.reset();
  Q_EMIT StateChanged();
}

std::optional<std::size_t> HandModel::held() const {
  const ControllerSnapshot& now = snapshot();
  if (now.hand.body < 0 || static_cast<std::size_t>(now.hand.body) >= now.bodies.size()) {
    return std::nullopt;
  }
  return static_cast<std::size_t>(now.hand.body);
}

bool HandModel::stopped() const {
  return snapshot().hand.state == SnapshotHand::State::kStopped;
}

bool HandModel::by_device() const {
  return ready() && snapshot().hand.input == SnapshotHand::Input::kDevice;
}

QString HandModel::DeviceTrouble() const {
  if (!by_device()) return {};
  using Safety = SnapshotSafety::State;
  switch (snapshot().safety.state) {
    case Safety::kOff:
    case Safety::kRamping:
    case Safety::kOn:
      return {};
    case Safety::kDamping:
    case Safety::kExpired:
    case Safety::kOverrun:
      return tr("Device: no force, because something was late; force returns by itself");
    case Safety::kSuspended:
      return tr("Device: no force, because this machine slept; force returns by itself");
    case Safety::kTooFast:
      return tr(
          "Device: no force, because the handle moved too fast; force returns when it is slow");
    case Safety::kFault:
      return tr("Device: no force after a fault; Resume (Ctrl+Space) brings it back");
    case Safety::kStopped:
      return tr("Device: emergency stop; Resume (Ctrl+Space) ends it");
    case Safety::kSilent:
      return tr("Device: its process does not answer; your hand stays in place");
  }
  return {};
}

bool HandModel::resumable() const {
  if (!ready()) return false;
  const SnapshotSafety::State state = snapshot().safety.state;
  const bool device = state == SnapshotSafety::State::kStopped ||
                      (by_device() && state == SnapshotSafety::State::kFault);
  return stopped() || device;
}

bool HandModel::retracing() const {
  return snapshot().hand.state == SnapshotHand::State::kRetracing;
}

Pose HandModel::goal() const {
  return goal_.value_or(ToPose(snapshot().hand.goal));
}

void HandModel::Grab(std::size_t body, const Vec3& p_W) {
  if (!ready() || body >= snapshot().bodies.size()) return;
  if (held()) link_->Send(ReleaseRequest{}, {});
  GrabRequest grab;
  grab.body = snapshot().bodies[body].name;
  grab.grasp_W = std::array<double, 3>{p_W.x(), p_W.y(), p_W.z()};
  goal_ = Pose{Quat::Identity(), p_W};
  grab_pending_ = true;
  grab_answered_ = false;
  const std::uint64_t number = ++grabs_asked_;
  link_->Send(grab, [this, number, name = grab.body](const Answer& answer) {
    if (number != grabs_asked_) return;  // a later grab replaced this one
    if (answer.ok) {
      grab_answered_ = true;  // the goal stays this hand's until a snapshot shows the grab
      if (!answer.reason.empty()) Tell(WordsForWindow(QString::fromStdString(answer.reason)));
      return;
    }
    grab_pending_ = false;
    goal_.reset();
    Tell(tr("Cannot grab %1: %2")
             .arg(QString::fromStdString(name),
                  WordsForWindow(QString::fromStdString(answer.reason))));
  });
}

void HandModel::SetGoal(const Pose& X_WG) {
  if (!ready() || (!held() && !grab_pending_)) return;
  goal_ = X_WG;
  link_->SetGoal(ToPlain(X_WG));
}

void HandModel::Ask(const QString& what, const ControlRequest& request) {
  if (!ready()) {
    Tell(tr("%1: you have no hand; open a scene, or take part in a session").arg(what));
    return;
  }
  link_->Send(request, [this, what](const Answer& answer) {
    if (!answer.reason.empty()) {
      Tell(what + QStringLiteral(": ") + WordsForWindow(QString::fromStdString(answer.reason)));
    } else if (!answer.ok) {
      Tell(tr("%1: refused").arg(what));
    }
  });
}

void HandModel::ForgetGoal() {
  ++grabs_asked_;
  grab_pending_ = false;
  grab_answered_ = false;
  goal_.reset();
}

void HandModel::Release() {
  ForgetGoal();
  Ask(tr("Let go"), ReleaseRequest{});
}

void HandModel::Give(const QString& peer) {
  Ask(tr("Hand over to %1").arg(peer), GiveRequest{peer.toStdString()});
}

void HandModel::AskFor(std::size_t body) {
  if (body >= snapshot().bodies.size()) return;
  const std::string& name = snapshot().bodies[body].name;
  Ask(tr("Ask for %1").arg(QString::fromStdString(name)), AskForRequest{name});
}

void HandModel::Retrace(RetraceRequest::To to) {
  ForgetGoal();
  const QString what = to == RetraceRequest::To::kGrasp  ? tr("Drive back")
                       : to == RetraceRequest::To::kUndo ? tr("Undo")
                                                         : tr("Reset");
  Ask(what, RetraceRequest{to});
}

void HandModel::Stop() {
  ForgetGoal();
  if (ready()) {
    Ask(tr("Emergency stop"), EmergencyStopRequest{});
  } else if (link_) {
    link_->Send(EmergencyStopRequest{}, {});
  } else {
    stop_asked_ = state_ == State::kStarting;
  }
}

void HandModel::Resume() {
  Ask(tr("Resume"), ResumeRequest{});
}

void HandModel::SetView(const Mat3& R_WV) {
  if (!by_device() || (view_told_ && view_told_->isApprox(R_WV, 1e-6))) return;
  view_told_ = R_WV;
  const Quat q(R_WV);
  link_->Send(SetViewRequest{{q.x(), q.y(), q.z(), q.w()}}, {});
}

void HandModel::Tell(const QString& word) {
  word_ = word;
  Q_EMIT Notified(word);
}

void HandModel::SetState(State state, const QString& trouble) {
  view_told_.reset();  // a new controller does not know the view
  state_ = state;
  trouble_ = trouble;
  Q_EMIT StateChanged();
}

std::optional<QString> HeldByOther(const ControllerSnapshot& snapshot, std::size_t body) {
  if (body >= snapshot.bodies.size() || snapshot.bodies[body].shared) return std::nullopt;
  for (const std::uint64_t holder : snapshot.bodies[body].holders) {
    if (holder == snapshot.self) continue;
    for (const SnapshotPeer& peer : snapshot.peers) {
      if (peer.id == holder) return QString::fromStdString(peer.name);
    }
    return QStringLiteral("?");
  }
  return std::nullopt;
}

}  // namespace tandem
