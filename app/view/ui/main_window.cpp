#include "app/view/ui/main_window.h"

#include <QDateTime>
#include <QDir>
#include <QMenuBar>
#include <QMessageBox>
#include <QStandardPaths>
#include <QStatusBar>
#include <QUrl>
#include <cmath>

#include "app/view/ui/keys_page.h"

namespace tandem {

namespace {
constexpr int kRefreshMs = 16;
constexpr int kRefreshesPerFigures = 12;  // five times a second, so that digits can be read
constexpr QSize kFirstSize(1280, 800);
constexpr int kDockWidth = 350;

}  // namespace

MainWindow::MainWindow(SessionModel& session, SceneModel& scene, const Result<GlInfo>& gl,
                       HandModel* hand)
    : session_(session),
      scene_(scene),
      centre_(new QStackedWidget),
      page_(new MessagePage),
      notices_(nullptr) {
  setWindowTitle(tr("Tandem"));
  setCentralWidget(centre_);
  centre_->addWidget(page_);
  if (gl) {
    view_ = new ViewWidget(*gl);
    centre_->addWidget(view_);
    connect(view_, &ViewWidget::Failed, this, [this](const QString& why) {
      ShowPicture(why);
    });
    connect(view_, &ViewWidget::FrameDrawn, this, &MainWindow::OnFrameDrawn);
  } else {
    gl_error_ = QString::fromStdString(gl.error().what);
  }
  notices_ = new NoticeBar(centre_);
  connect(page_, &MessagePage::OpenAsked, this, &MainWindow::AskForScene);
  connect(page_, &MessagePage::NamedAsked, &scene_, &SceneModel::OpenOffered);
  connect(page_, &MessagePage::FetchingAsked, &scene_, &SceneModel::Fetch);
  MakeDocks();
  MakeActions(hand != nullptr);
  if (hand != nullptr) {
    panel_ = new HandPanel(*hand, session_, scene_, *this, view_);
    connect(panel_, &HandPanel::Changed, this, &MainWindow::OnHandChanged);
    connect(hand, &HandModel::SessionEnded, this, &MainWindow::ShowVerdicts);
    connect(session_dock_, &SessionDock::AgainAsked, hand, &HandModel::StartAgain);
  }
  setAcceptDrops(true);
  MakeStatusBar();
  resize(kFirstSize);
  resizeDocks({session_dock_}, {kDockWidth}, Qt::Horizontal);

  clock_.start();
  refresh_.setInterval(kRefreshMs);
  refresh_.setTimerType(Qt::PreciseTimer);
  numbers_.setInterval(1000);
  connect(&refresh_, &QTimer::timeout, this, &MainWindow::Refresh);
  connect(&numbers_, &QTimer::timeout, this, &MainWindow::RefreshNumbers);
  connect(&session_, &SessionModel::StateChanged, this, &MainWindow::OnSessionChanged);
  connect(&scene_, &SceneModel::Changed, this, &MainWindow::OnSceneChanged);
  connect(&proximity_, &ProximityModel::Changed, this, &MainWindow::OnProximityChanged);
  OnSessionChanged();
  OnSceneChanged();
}

const MessagePage* MainWindow::page() const {
  return centre_->currentWidget() == page_ ? page_ : nullptr;
}

bool MainWindow::ShowsPoses() const {
  if (view_ == nullptr || centre_->currentWidget() != view_) return false;
  if (panel_ != nullptr && panel_->shows()) return panel_->hand().snapshot().frame > 0;
  return session_.Picture().samples > 0;
}

void MainWindow::AskForScene() {
  if (ask_ == nullptr) {
    ask_ = new QFileDialog(this, tr("Open scene"));
    ask_->setObjectName("ask_for_scene");
    ask_->setFileMode(QFileDialog::ExistingFile);
    QList<QUrl> urls;
    for (const std::filesystem::path& folder : scene_folders_) {
      urls << QUrl::fromLocalFile(QString::fromStdString(folder.string()));
    }
    if (!urls.empty()) {
      ask_->setSidebarUrls(urls);
      ask_->setDirectoryUrl(urls.front());
    }
    ask_->setNameFilters({tr("Scenes (*.json)"), tr("All files (*)")});
    connect(ask_, &QFileDialog::fileSelected, this, &MainWindow::OpenScene);
  }
  ask_->open();  // in the folder used last
}

void MainWindow::OpenScene(const QString& file) {
  // a viewer of a session keeps looking on
  if (panel_ != nullptr && session_.state() != SessionModel::State::kJoined) {
    panel_->Open(file);
  } else {
    scene_.OpenNamed(file.toStdString());
  }
  Q_EMIT SceneChosen(file);
}

void MainWindow::ShowPicture(const QString& gl_error) {
  gl_error_ = gl_error;
  page_->OfferOpening(gl_error_.isEmpty() && (scene_.state() == SceneModel::State::kMissing ||
                                              scene_.state() == SceneModel::State::kWaiting));
  page_->OfferNamed(gl_error_.isEmpty() && scene_.state() == SceneModel::State::kMissing &&
                    !scene_.offered().empty());
  page_->OfferFetching(gl_error_.isEmpty() && scene_.can_fetch() &&
                       session_.state() == SessionModel::State::kJoined &&
                       !session_.request().from_relay);
  if (!gl_error_.isEmpty()) {
    page_->Show(tr("No OpenGL: the scene cannot be drawn"), gl_error_);
    centre_->setCurrentWidget(page_);
    return;
  }
  switch (scene_.state()) {
    case SceneModel::State::kReady:
      centre_->setCurrentWidget(view_);
      return;
    case SceneModel::State::kLoading:
      page_->Show(tr("Loading the scene"), scene_.message(), scene_.percent());
      break;
    case SceneModel::State::kMissing:
      page_->Show(tr("The scene is missing"), scene_.message());
      break;
    case SceneModel::State::kWaiting:
      if (session_.state() == SessionModel::State::kJoined && !session_.has_peers()) {
        page_->Show(session_.listened() ? tr("Nobody answers") : tr("Looking for others"),
                    Describe(session_));
      } else if (session_.state() == SessionModel::State::kJoined) {
        page_->Show(tr("Waiting for a peer"),
                    tr("Nobody in session \u201c%1\u201d has offered a scene yet.")
                        .arg(QString::fromStdString(session_.request().session)));
      } else if (session_.state() == SessionModel::State::kFailed) {
        page_->Show(tr("Could not join"), session_.error());
      } else {
        page_->Show(tr("No scene yet"), scene_.message());
      }
      break;
  }
  centre_->setCurrentWidget(page_);
}

void MainWindow::OnSessionChanged() {
  EnableInvite();
  const SessionModel::State state = session_.state();
  status_session_->setText(Describe(session_));
  setWindowTitle(
      state == SessionModel::State::kJoined && session_.has_peers()
          ? tr("%1 \u2013 Tandem").arg(QString::fromStdString(session_.request().session))
          : tr("Tandem"));
  if (state == SessionModel::State::kJoined) {
    if (!refresh_.isActive() || still_until_s_ > 0) {
      samples_before_ = 0;
      figures_.clear();
      scene_.LookAgain();
    }
    still_until_s_ = 0;
    if (!refresh_.isActive()) refresh_.start();
    if (!numbers_.isActive()) numbers_.start();
  } else if (state == SessionModel::State::kLeft) {
    still_until_s_ = 1e-3 * static_cast<double>(clock_.elapsed()) + PictureComposer::kFadeSeconds;
    refresh_.start();
    RefreshNumbers();
  }
  ShowPicture(gl_error_);
  UpdateNotices();
}

void MainWindow::OnSceneChanged() {
  const DrawnScene* scene = scene_.scene();
  looks_ = scene != nullptr ? scene->Looks() : std::vector<BodyLook>{};
  status_scene_->setText(scene != nullptr ? QString::fromStdString(scene->name) : tr("no scene"));
  if (view_ != nullptr) {
    view_->SetScene(scene);
  }
  ShowWarnings();
  proximity_.SetScene(scene_.shared_scene());
  ShowPicture(gl_error_);
  Refresh();
}

void MainWindow::ShowProximity(bool on) {
  if (proximity_action_ != nullptr) proximity_action_->setChecked(on);
}

void MainWindow::OnProximityChanged() {
  if (view_ != nullptr) view_->SetProximity(proximity_.picture());
  const bool drawn_later =
      proximity_.picture() != nullptr && page() == nullptr && isVisible() && view_->frame_due();
  if (!drawn_later) status_proximity_->setText(proximity_.message());
}

void MainWindow::OnFrameDrawn() {
  ShowFigures();
}

void MainWindow::ShowFigures() {
  peers_.Update(shown_.peers);
  status_proximity_->setText(proximity_.message());
}

void MainWindow::ShowSceneAlone() {
  scene_alone_ = true;
  setContextMenuPolicy(Qt::NoContextMenu);  // its menu lists the docks
  menuBar()->hide();
  statusBar()->hide();
  for (QDockWidget* dock : findChildren<QDockWidget*>()) dock->hide();
  if (panel_ != nullptr) panel_->KeepStopAlone();
}

void MainWindow::ShowWarnings() {
  QStringList warnings;
  if (!scene_.warning().isEmpty()) warnings << scene_.warning();
  for (const ViewedPeer& peer : shown_.peers) {
    const std::string other = OtherProtocol(peer.info);
    if (other.empty() || peer.presence != ViewedPeer::Presence::kHere) continue;
    warnings << tr("%1 %2. What this window shows of it may be wrong.")
                    .arg(QString::fromStdString(DisplayName(peer)), QString::fromStdString(other));
  }
  if (panel_ != nullptr) {
    const HandModel& hand = panel_->hand();
    const bool calm = hand.ready() && !hand.stopped() && hand.DeviceTrouble().isEmpty();
    if (!calm && !panel_->StateText().isEmpty()) warnings << panel_->StateText();
    if (!panel_->Words().isEmpty()) warnings << panel_->Words();
  }
  if (view_ != nullptr) view_->SetWarning(warnings.join(QLatin1Char('\n')));
}

void MainWindow::HoldFigures(ViewerPicture& picture, bool take_newest) {
  std::map<PeerId, Figures> held;
  for (ViewedPeer& peer : picture.peers) {
    Figures figures{peer.delay_ms, peer.mirror_lag_mm, peer.link_force};
    const auto before = figures_.find(peer.info.peer);
    if (!take_newest && before != figures_.end()) figures = before->second;
    if (scene_alone_) figures = {};
    held[peer.info.peer] = figures;
    peer.delay_ms = figures.delay_ms;
    peer.mirror_lag_mm = figures.mirror_lag_mm;
    peer.link_force = figures.link_force;
  }
  figures_ = std::move(held);
}

void MainWindow::Refresh() {
  const double now_s = 1e-3 * static_cast<double>(clock_.elapsed());
  const bool own = panel_ != nullptr && panel_->shows();
  ViewerPicture picture = own ? PictureOf(panel_->hand().snapshot(), panel_->hand().request().name,
                                          panel_->hand().alive())
                              : session_.Picture();
  if (session_.state() == SessionModel::State::kJoined) scene_.SetSessionScene(picture.scene);
  HoldFigures(picture, refreshes_++ % kRefreshesPerFigures == 0);
  DrawList list = composer_.Compose(picture, looks_, now_s);
  if (own) {
    panel_->DecoratePicture(looks_, list);
  } else if (view_ != nullptr) {
    view_->SetHand({});
  }
  shown_ = std::move(picture);
  if (view_ != nullptr) view_->SetDrawList(list);
  ShowWarnings();
  proximity_.SetPoses(list.reported, list.held);  // measured at the received poses, not at the
                                                  // drawn ones
  // names, delays and distances in the picture and beside it are from the same moment
  const bool drawn_later = page() == nullptr && isVisible() && view_->frame_due();
  if (!drawn_later) ShowFigures();
  if (session_.state() != SessionModel::State::kJoined && now_s > still_until_s_) {
    refresh_.stop();
    if (own) return;
    numbers_.stop();
    RefreshNumbers();
  }
}

void MainWindow::RefreshNumbers() {
  const bool own = panel_ != nullptr && panel_->shows();
  const std::uint64_t samples = own ? panel_->snapshots() : session_.Picture().samples;
  const quint64 frames = view_ != nullptr ? view_->frames_drawn() : 0;
  const qint64 now_ms = clock_.isValid() ? clock_.elapsed() : 0;
  const double seconds = 1e-3 * static_cast<double>(now_ms - numbers_at_ms_);
  const auto rate = [&](std::uint64_t now, std::uint64_t before) {
    return seconds > 0 && now > before
               ? QString::number(std::lround(static_cast<double>(now - before) / seconds))
               : QStringLiteral("0");
  };
  status_samples_->setText(tr("%1 samples/s").arg(rate(samples, samples_before_)));
  status_fps_->setText(tr("%1 frames/s").arg(rate(frames, frames_before_)));
  // after leaving, no samples come, whatever came in the last second
  if (!own && session_.state() != SessionModel::State::kJoined) {
    status_samples_->setText(tr("%1 samples/s").arg(0));
  }
  samples_before_ = samples;
  frames_before_ = frames;
  numbers_at_ms_ = now_ms;
}

QImage MainWindow::Screenshot() {
  ShowFigures();
  if (page() == nullptr) view_->DrawToKeep();
  return grab().toImage().convertToFormat(QImage::Format_RGB32);
}

void MainWindow::SaveScreenshot() {
  const QString folder = QStandardPaths::writableLocation(QStandardPaths::PicturesLocation);
  const QString stamp = QDateTime::currentDateTime().toString("yyyyMMdd-HHmmss");
  const QString file = QDir(folder).filePath("tandem-" + stamp + ".png");
  QDir().mkpath(folder);
  statusBar()->showMessage(
      Screenshot().save(file) ? tr("Saved %1").arg(file) : tr("Could not write %1").arg(file),
      5000);
}

void MainWindow::ShowKeys() {
  QMessageBox::information(this, tr("Mouse and keys"), KeysPage(panel_ != nullptr));
}

}  // namespace tandem
