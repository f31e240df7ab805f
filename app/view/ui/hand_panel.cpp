#include "app/view/ui/hand_panel.h"

#include <QApplication>
#include <QCoreApplication>
#include <QInputDialog>
#include <QMenuBar>
#include <QToolButton>
#include <utility>

#include "app/view/ui/dialogs/device_dialog.h"

namespace tandem {

namespace {
constexpr int kWordsMs = 8000;
}  // namespace

HandPanel::HandPanel(HandModel& hand, SessionModel& session, SceneModel& scene, QMainWindow& window,
                     ViewWidget* view)
    : QObject(&window),
      hand_(hand),
      session_(session),
      scene_(scene),
      window_(window),
      view_(view) {
  if (view_ != nullptr) {
    mouse_ = new HandMouse(hand_, *view_, this);
    connect(mouse_, &HandMouse::Changed, this, &HandPanel::Changed);
  }
  MakeActions();
  FillBar();
  ConnectActions();
  words_end_.setSingleShot(true);
  words_end_.setInterval(kWordsMs);
  connect(&words_end_, &QTimer::timeout, this, [this] {
    Say({});
  });
  connect(&hand_, &HandModel::StateChanged, this, &HandPanel::OnHandState);
  connect(&hand_, &HandModel::SnapshotCame, this, &HandPanel::OnSnapshot);
  connect(&hand_, &HandModel::Notified, this, &HandPanel::Say);
  connect(&scene_, &SceneModel::Changed, this, &HandPanel::OnSession);
  connect(&session_, &SessionModel::StateChanged, this, &HandPanel::OnSession);
  Refresh();
}

QAction* HandPanel::Add(const char* name, const QString& text, const QKeySequence& key,
                        const QString& tip) {
  QAction* action = menu_->addAction(text);
  action->setObjectName(QString::fromLatin1(name));
  action->setShortcut(key);
  const QString keys = key.isEmpty() ? QString() : QStringLiteral(" (%1)").arg(key.toString());
  action->setToolTip(tip + keys);
  return action;
}

void HandPanel::MakeActions() {
  menu_ = new QMenu(HandPanel::tr("&Hand"), &window_);
  menu_->setToolTipsVisible(true);
  bar_ = window_.addToolBar(HandPanel::tr("Hand"));
  bar_->setObjectName("hand_bar");
  bar_->setMovable(false);
  grab_ = Add("hand_grab", tr("&Grab"), Qt::Key_G, tr("Take the body under the cursor in hand"));
  release_ =
      Add("hand_release", tr("&Let go"), Qt::Key_L, tr("Let go of the part; it stays where it is"));
  give_ = Add("hand_give", tr("&Hand over"), Qt::Key_H, tr("Hand the part to another user"));
  give_menu_ = new QMenu(&window_);
  connect(give_menu_, &QMenu::aboutToShow, this, &HandPanel::FillGiveMenu);
  ask_ = Add("hand_ask", tr("&Ask for"), Qt::Key_A,
             tr("Ask the user who holds the body under the cursor to hand it over"));
  menu_->addSeparator();
  back_ = Add("hand_back", tr("Drive &back"), Qt::Key_Escape,
              tr("Move the part back along its path to where you took it"));
  undo_ = Add("hand_undo", tr("&Undo"), QKeySequence::Undo,
              tr("Move the part you let go of last back to where you took it"));
  reset_ = Add("hand_reset", tr("&Reset"), QKeySequence(Qt::CTRL | Qt::SHIFT | Qt::Key_R),
               tr("Move all parts that were moved here back to their first places"));
  menu_->addSeparator();
  triad_ = Add("hand_triad", tr("&Triad"), Qt::Key_T,
               tr("Show handles at the part: arrows and squares move it, rings rotate it"));
  triad_->setCheckable(true);
  clutch_ = Add("hand_clutch", tr("&Clutch"), Qt::Key_C,
                tr("Move the device\u2019s handle alone; click again to move the part with it"));
  clutch_->setCheckable(true);
  device_ = Add("hand_device", tr("&Device\u2026"), {},
                tr("Choose the device that moves the hand; lists the devices and what is missing"));
  scale_ = Add("hand_scale", tr("Device s&cale\u2026"), {},
               tr("Set how far the part moves when the device\u2019s handle moves a metre"));
  sound_ =
      Add("hand_sound", tr("&Sound on contact"), {}, tr("Beep when the part touches something"));
  sound_->setCheckable(true);
  menu_->addSeparator();
  stop_ = Add("hand_stop", tr("&Emergency stop"), Qt::Key_Space,
              tr("Stop: the hand lets go, and the device gets no force until you resume"));
  resume_ = Add("hand_resume", tr("Resu&me"), QKeySequence(Qt::CTRL | Qt::Key_Space),
                tr("End the emergency stop"));
}

void HandPanel::FillBar() {
  for (QAction* action :
       {grab_, release_, give_, ask_, back_, undo_, reset_, triad_, stop_, resume_}) {
    bar_->addAction(action);
    // Space and the arrow keys move the part, whichever button was clicked
    bar_->widgetForAction(action)->setFocusPolicy(Qt::NoFocus);
  }
  auto* give_button = qobject_cast<QToolButton*>(bar_->widgetForAction(give_));
  give_button->setMenu(give_menu_);
  give_button->setPopupMode(QToolButton::MenuButtonPopup);
  bar_->widgetForAction(stop_)->setStyleSheet(
      QStringLiteral("QToolButton:enabled { background: #c62828; color: white; font-weight: bold; "
                     "padding: 4px; }"));
  // inserted before Help
  const QList<QAction*> menus = window_.menuBar()->actions();
  window_.menuBar()->insertMenu(menus.isEmpty() ? nullptr : menus.back(), menu_);
}

void HandPanel::ConnectActions() {
  connect(grab_, &QAction::triggered, this, &HandPanel::TakeUnderCursor);
  connect(release_, &QAction::triggered, this, [this] {
    if (mouse_ != nullptr) mouse_->EndDrag();
    hand_.Release();
  });
  connect(give_, &QAction::triggered, this, [this] {
    FillGiveMenu();
    give_menu_->popup(QCursor::pos());
  });
  connect(ask_, &QAction::triggered, this, &HandPanel::AskUnderCursor);
  const auto retrace = [this](QAction* action, RetraceRequest::To to) {
    connect(action, &QAction::triggered, this, [this, to] {
      if (mouse_ != nullptr) mouse_->EndDrag();
      hand_.Retrace(to);
    });
  };
  retrace(back_, RetraceRequest::To::kGrasp);
  retrace(undo_, RetraceRequest::To::kUndo);
  retrace(reset_, RetraceRequest::To::kReset);
  connect(triad_, &QAction::toggled, this, [this](bool shown) {
    if (mouse_ != nullptr) mouse_->ShowTriad(shown);
  });
  connect(clutch_, &QAction::toggled, this, [this](bool pressed) {
    if (hand_.by_device()) {
      hand_.Ask(tr("Clutch"), SetParameterRequest{"device_clutch", pressed ? 1.0 : 0.0});
    }
  });
  connect(device_, &QAction::triggered, this, &HandPanel::AskDevice);
  connect(scale_, &QAction::triggered, this, &HandPanel::AskScale);
  connect(stop_, &QAction::triggered, this, [this] {
    if (mouse_ != nullptr) mouse_->EndDrag();
    hand_.Stop();
  });
  connect(resume_, &QAction::triggered, &hand_, &HandModel::Resume);
}

void HandPanel::KeepStopAlone() {
  stop_alone_ = true;
  // hidden actions have no key either
  for (QAction* action : {grab_, release_, give_, ask_, back_, undo_, reset_, triad_, clutch_,
                          device_, scale_, sound_}) {
    action->setVisible(false);
  }
}

void HandPanel::Refresh() {
  const bool ready = hand_.ready();
  const bool holds = ready && hand_.held().has_value();
  const bool stopped = ready && hand_.stopped();
  grab_->setEnabled(ready && !stopped);
  ask_->setEnabled(ready && !stopped);
  for (QAction* action : {release_, give_, back_}) action->setEnabled(holds);
  for (QAction* action : {undo_, reset_}) action->setEnabled(ready && !stopped);
  const bool there =
      hand_.state() != HandModel::State::kNone && hand_.state() != HandModel::State::kEnded;
  stop_->setEnabled(there && !stopped);
  resume_->setEnabled(hand_.resumable());
  triad_->setEnabled(view_ != nullptr && !hand_.by_device());
  for (QAction* action : {clutch_, scale_}) action->setEnabled(hand_.by_device());
  bar_->setVisible(hand_.state() != HandModel::State::kNone);
}

void HandPanel::Open(const QString& file) {
  HandRequest request = defaults_;
  request.scene = file.toStdString();
  session_.Leave();
  waiting_.reset();
  scene_.OpenNamed(request.scene);
  hand_.Start(request);
  if (view_ != nullptr) view_->setFocus();
}

void HandPanel::TakePart(const HandRequest& request) {
  defaults_ = request;
  defaults_.scene.clear();
  if (!request.scene.empty()) {
    session_.Leave();
    scene_.OpenNamed(request.scene);
    hand_.Start(request);
    return;
  }
  // looks on until the session's scene is known and found on this machine
  hand_.Leave();
  waiting_ = request;
  if (session_.state() == SessionModel::State::kJoined) session_.Leave();
  if (session_.state() == SessionModel::State::kJoining) return;
  session_.Join(ViewerRequest(request));
}

JoinRequest ViewerRequest(const HandRequest& request) {
  JoinRequest join;
  join.session = request.session;
  join.name = request.name;
  join.domain = request.domain;
  join.interface = request.interface;
  join.peers = request.peers;
  join.external_address = request.external_address;
  join.secure = request.secure;
  join.secured = !request.secure.empty();
  join.port = request.port;
  join.chosen_here = true;
  return join;
}

void HandPanel::OnSession() {
  if (waiting_ && scene_.state() == SceneModel::State::kReady) {
    HandRequest request = *std::exchange(waiting_, std::nullopt);
    request.scene = scene_.scene()->file.string();
    // the controller is a peer itself; the hand's state is shown from the start, not the goodbye
    const QSignalBlocker quiet(session_);
    session_.Leave();
    hand_.Start(request);
  } else if (waiting_ && session_.state() == SessionModel::State::kFailed) {
    waiting_.reset();
    Say(tr("Could not join: %1").arg(session_.error()));
  }
  Q_EMIT Changed();
}

void HandPanel::OnHandState() {
  if (hand_.state() != HandModel::State::kReady && mouse_ != nullptr) mouse_->EndDrag();
  Refresh();
  Q_EMIT Changed();
}

void HandPanel::OnSnapshot() {
  const ControllerSnapshot& now = hand_.snapshot();
  const DrawnScene* shown = scene_.scene();
  const bool settled =
      scene_.state() == SceneModel::State::kReady || scene_.state() == SceneModel::State::kWaiting;
  // compares the numbers of bodies too: the same file may have been loaded with one more mesh
  if (settled && !now.scene.empty() && (shown == nullptr || shown->file.string() != now.scene) &&
      (shown == nullptr || shown->bodies.size() != now.bodies.size() ||
       shown->file.filename() != std::filesystem::path(now.scene).filename())) {
    scene_.OpenNamed(now.scene);
  }
  if (hand_.retracing() && mouse_ != nullptr && mouse_->dragging()) mouse_->EndDrag();
  ++snapshots_;
  ReportContact();
  if (view_ != nullptr) hand_.SetView(view_->camera().R_WV());
  Refresh();
  Q_EMIT Changed();
}

void HandPanel::ReportContact() {
  const bool contact = hand_.held().has_value() && hand_.snapshot().contact_points > 0;
  if (contact && !in_contact_ && sound_->isChecked()) QApplication::beep();
  in_contact_ = contact;
}

void HandPanel::AskScale() {
  auto* dialog = new QInputDialog(&window_);
  dialog->setAttribute(Qt::WA_DeleteOnClose);
  dialog->setWindowTitle(tr("Device scale"));
  dialog->setLabelText(tr("Metres in the scene for each metre of the device\u2019s handle:"));
  dialog->setInputMode(QInputDialog::DoubleInput);
  dialog->setDoubleRange(0.01, 100);
  dialog->setDoubleDecimals(2);
  dialog->setDoubleValue(scale_now_);
  dialog->setModal(false);  // keeps the window's keys active; one of them stops
  connect(dialog, &QInputDialog::doubleValueSelected, this, [this](double scale) {
    scale_now_ = scale;
    hand_.Ask(tr("Device scale"), SetParameterRequest{"device_scale", scale});
  });
  dialog->show();
}

void HandPanel::AskDevice() {
  const HandRequest& request = hand_.request().scene.empty() ? defaults_ : hand_.request();
  auto* dialog = new DeviceDialog(QString::fromStdString(request.device), &window_);
  dialog->setAttribute(Qt::WA_DeleteOnClose);
  dialog->setModal(false);  // keeps the window's keys active; one of them stops
  connect(dialog, &QDialog::accepted, this, [this, dialog] {
    UseDevice(dialog->device());
  });
  dialog->show();
  dialog->Look(QCoreApplication::applicationDirPath() + QStringLiteral("/tandem"));
}

void HandPanel::UseDevice(const QString& device) {
  defaults_.device = device.toStdString();
  HandRequest request = hand_.request();
  if (request.scene.empty() || request.device == defaults_.device) return;
  request.device = defaults_.device;
  hand_.Start(request);
}

void HandPanel::DecoratePicture(const std::vector<BodyLook>& looks, DrawList& list) {
  AddGoal(hand_.snapshot(), hand_.goal(), looks, list);
  if (view_ == nullptr) return;
  HandPicture picture = mouse_->Dressed(HandPictureOf(hand_.snapshot(), hand_.goal()));
  picture.figures = !stop_alone_;
  view_->SetHand(picture);
}

QString HandPanel::StateText() const {
  switch (hand_.state()) {
    case HandModel::State::kNone:
      return waiting_ ? tr("Looking for the session\u2019s scene") : QString();
    case HandModel::State::kStarting:
      return tr("Your hand: %1").arg(hand_.trouble());
    case HandModel::State::kEnded:
      if (hand_.can_start_again()) return tr("You have no hand: press Start again");
      return hand_.trouble();
    case HandModel::State::kLost:
      return hand_.trouble();
    case HandModel::State::kReady:
      break;
  }
  const ControllerSnapshot& now = hand_.snapshot();
  if (hand_.stopped()) return tr("Emergency stop: press Resume (Ctrl+Space) to go on");
  if (const QString trouble = hand_.DeviceTrouble(); !trouble.isEmpty()) return trouble;
  const auto held = hand_.held();
  if (!held) return tr("Your hand is empty");
  const QString name = QString::fromStdString(now.bodies[*held].name);
  QString text = hand_.retracing() ? tr("%1 goes back").arg(name) : tr("You hold %1").arg(name);
  if (now.contact_points > 0) text += tr(", in contact");
  if (mouse_ != nullptr && mouse_->lock()) {
    const AxisLock& lock = *mouse_->lock();
    text += tr("; %1 %2 %3")
                .arg(lock.of_part ? tr("its") : tr("the world\u2019s"),
                     QStringLiteral("XYZ").at(lock.axis), lock.plane ? tr("stays") : tr("alone"));
  }
  return text;
}

void HandPanel::TakeUnderCursor() {
  const auto hit = mouse_ != nullptr ? mouse_->UnderCursor() : std::nullopt;
  if (!hit) {
    Say(tr("Grab: put the cursor on a body first"));
    return;
  }
  hand_.Grab(hit->body, hit->p_W);
}

void HandPanel::AskUnderCursor() {
  const auto hit = mouse_ != nullptr ? mouse_->UnderCursor() : std::nullopt;
  if (!hit) {
    Say(tr("Ask for: put the cursor on a body first"));
    return;
  }
  hand_.AskFor(hit->body);
}

void HandPanel::FillGiveMenu() {
  give_menu_->clear();
  for (const SnapshotPeer& peer : hand_.snapshot().peers) {
    if (!peer.active || !peer.here || peer.id == hand_.snapshot().self) continue;
    const QString name = QString::fromStdString(peer.name);
    QString shown = name;  // an ampersand marks a key in a menu
    give_menu_->addAction(shown.replace(QLatin1Char('&'), QStringLiteral("&&")), this,
                          [this, name] {
                            hand_.Give(name);
                          });
  }
  if (give_menu_->isEmpty()) {
    give_menu_->addAction(tr("nobody else takes part"))->setEnabled(false);
  }
}

void HandPanel::Say(const QString& words) {
  words_ = words;
  if (!words.isEmpty()) words_end_.start();
  Q_EMIT Changed();
}

}  // namespace tandem
