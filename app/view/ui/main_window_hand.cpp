#include <QDragEnterEvent>
#include <QMenu>
#include <QMimeData>
#include <QUrl>

#include "app/view/ui/join_dialog.h"
#include "app/view/ui/main_window.h"

// How the window takes part in sessions; main_window.cpp shows them.

namespace tandem {

namespace {

/// The scene file that is dragged; empty: none, or several.
QString SceneIn(const QMimeData& data) {
  const QList<QUrl> urls = data.urls();
  if (urls.size() != 1 || !urls.front().isLocalFile()) return {};
  const QString file = urls.front().toLocalFile();
  return file.endsWith(QStringLiteral(".json"), Qt::CaseInsensitive) ? file : QString();
}
}  // namespace

void MainWindow::OnHandChanged() {
  const HandModel& hand = desk_->hand();
  QString dock_text;
  if (hand.ready()) {
    const std::string& session = hand.request().session;
    dock_text = session.empty() ? tr("You take part alone: the session is of this machine")
                                : tr("You take part in \u201c%1\u201d as %2")
                                      .arg(QString::fromStdString(session),
                                           QString::fromStdString(hand.request().name));
  }
  session_dock_->ShowHand(dock_text);
  if (hand.ready() && !numbers_.isActive()) numbers_.start();
  if (hand.state() != HandModel::State::kNone || !desk_->StateText().isEmpty()) {
    QString text = desk_->StateText();
    if (hand.ready()) {
      const std::string& session = hand.request().session;
      text = (session.empty() ? tr("On your own")
                              : tr("In \u201c%1\u201d as %2")
                                    .arg(QString::fromStdString(session),
                                         QString::fromStdString(hand.request().name))) +
             QStringLiteral(" \u00b7 ") + text;
    }
    status_session_->setText(text);
    const DrawnScene* scene = scene_.scene();
    const QString what = !hand.request().session.empty()
                             ? QString::fromStdString(hand.request().session)
                         : scene != nullptr ? QString::fromStdString(scene->name)
                                            : tr("your hand");
    setWindowTitle(tr("%1 \u2013 Tandem").arg(what));
  } else {
    OnSessionChanged();
  }
  Refresh();
}

void MainWindow::AskToJoin() {
  auto* dialog = new JoinDialog(this);
  dialog->setAttribute(Qt::WA_DeleteOnClose);
  HandRequest request = desk_->defaults();
  if (request.session.empty()) request.session = session_dock_->Request().session;
  dialog->SetRequest(request, true);
  connect(dialog, &QDialog::accepted, this, [this, dialog] {
    Join(dialog->Request(), dialog->active());
  });
  dialog->open();
}

void MainWindow::Join(const HandRequest& request, bool active) {
  if (active) {
    desk_->TakePart(request);
    return;
  }
  desk_->hand().Leave();
  session_.Leave();
  if (session_.state() == SessionModel::State::kJoining) return;
  if (!request.scene.empty()) scene_.OpenNamed(request.scene);
  const JoinRequest join = ViewerRequest(request);
  session_dock_->SetRequest(join);
  session_.Join(join);
}

void MainWindow::SetRecentScenes(const std::vector<std::filesystem::path>& files) {
  recent_menu_->clear();
  for (const std::filesystem::path& file : files) {
    const QString path = QString::fromStdString(file.string());
    recent_menu_->addAction(path, this, [this, path] {
      OpenScene(path);
    });
  }
  recent_menu_->setEnabled(!files.empty());
}

void MainWindow::dragEnterEvent(QDragEnterEvent* event) {
  if (!SceneIn(*event->mimeData()).isEmpty()) event->acceptProposedAction();
}

void MainWindow::dropEvent(QDropEvent* event) {
  const QString file = SceneIn(*event->mimeData());
  if (file.isEmpty()) return;
  event->acceptProposedAction();
  OpenScene(file);
}

}  // namespace tandem
