#include <QCoreApplication>
#include <QDragEnterEvent>
#include <QJsonArray>
#include <QJsonDocument>
#include <QJsonObject>
#include <QMenu>
#include <QMessageBox>
#include <QMimeData>
#include <QUrl>

#include "app/view/ui/dialogs/invite_dialog.h"
#include "app/view/ui/dialogs/join_dialog.h"
#include "app/view/ui/main_window.h"
#include "engine/realtime/private_process.h"

// How the window takes part in sessions. main_window.cpp shows them.

namespace tandem {

namespace {

/// Returns the path of `tandem`, which lies beside this program.
QString TandemProgram() {
  return QCoreApplication::applicationDirPath() + QStringLiteral("/tandem");
}

/// Returns the scene file that is dragged; empty: none, or several.
QString SceneIn(const QMimeData& data) {
  const QList<QUrl> urls = data.urls();
  if (urls.size() != 1 || !urls.front().isLocalFile()) return {};
  const QString file = urls.front().toLocalFile();
  return file.endsWith(QStringLiteral(".json"), Qt::CaseInsensitive) ? file : QString();
}
}  // namespace

void MainWindow::OnHandChanged() {
  EnableInvite();
  const HandModel& hand = panel_->hand();
  QString dock_text;
  if (hand.ready()) {
    const std::string& session = hand.request().session;
    dock_text = session.empty() ? tr("You take part alone: the session exists on this machine only")
                                : tr("You take part in \u201c%1\u201d as %2")
                                      .arg(QString::fromStdString(session),
                                           QString::fromStdString(hand.request().name));
  }
  if (hand.state() == HandModel::State::kStarting && !hand.request().session.empty()) {
    dock_text = tr("Joining \u201c%1\u201d with a hand\u2026")
                    .arg(QString::fromStdString(hand.request().session));
  }
  session_dock_->ShowHand(dock_text);
  UpdateNotices();
  if (hand.ready() && !numbers_.isActive()) numbers_.start();
  if (hand.state() != HandModel::State::kNone || !panel_->StateText().isEmpty()) {
    QString text = panel_->StateText();
    if (hand.ready()) {
      const std::string& session = hand.request().session;
      text = (session.empty() ? tr("Alone")
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
  HandRequest request = panel_->defaults();
  request.session = SessionInMind();
  dialog->SetRequest(request, true);
  dialog->Look(TandemProgram());
  connect(dialog, &QDialog::accepted, this, [this, dialog] {
    if (dialog->invitation().isEmpty()) {
      Join(dialog->Request(), dialog->active());
    } else {
      JoinByInvitation(dialog->invitation(), dialog->Request());
    }
  });
  dialog->open();
}

std::string MainWindow::SessionInMind() const {
  const HandModel& hand = panel_->hand();
  if (hand.ready()) return hand.request().session;
  using State = SessionModel::State;
  if (session_.state() == State::kJoined) {
    return session_.has_peers() ? session_.request().session : std::string();
  }
  // a name that was typed or given and not tried yet
  return session_.state() == State::kIdle ? session_dock_->Request().session : std::string();
}

void MainWindow::JoinByInvitation(const QString& line, const HandRequest& request) {
  if (invited_ != nullptr) return;  // one invitation at a time
  // the line goes through stdin: other users of the machine read the words of a command
  QStringList words{QStringLiteral("join"), QStringLiteral("-"), QStringLiteral("--only-keys"),
                    QStringLiteral("--json")};
  if (!request.scene.empty()) {
    words << QStringLiteral("--scene") << QString::fromStdString(request.scene);
  }
  if (!request.interface.empty()) {
    words << QStringLiteral("--interface") << QString::fromStdString(request.interface);
  }
  invited_ = new QProcess(this);
  invited_->setChildProcessModifier(&CloseOthersOnExec);
  status_session_->setText(tr("Asking the inviter\u2026"));
  const auto end = [this, request](int exit_code) {
    const QByteArray answer = invited_->readAllStandardOutput();
    const QStringList output = QString::fromUtf8(invited_->readAllStandardError())
                                   .split(QLatin1Char('\n'), Qt::SkipEmptyParts);
    const QString fault = output.isEmpty() ? invited_->errorString()
                                           : output.last().section(QStringLiteral("tandem: "), 1);
    invited_->deleteLater();
    invited_ = nullptr;
    OnSessionChanged();
    if (exit_code != 0) {
      auto* box =
          new QMessageBox(QMessageBox::Warning, tr("The invitation"), fault, QMessageBox::Ok, this);
      box->setObjectName("invitation_fault");
      box->setTextFormat(Qt::PlainText);
      box->setAttribute(Qt::WA_DeleteOnClose);
      box->open();
      return;
    }
    JoinAsInvited(answer, request);
  };
  connect(invited_, &QProcess::finished, this, [end](int exit_code, QProcess::ExitStatus) {
    end(exit_code);
  });
  connect(invited_, &QProcess::errorOccurred, this, [end](QProcess::ProcessError error) {
    if (error == QProcess::FailedToStart) end(1);
  });
  invited_->start(TandemProgram(), words);
  invited_->write(line.toUtf8() + '\n');
  invited_->closeWriteChannel();
}

void MainWindow::JoinAsInvited(const QByteArray& answer, HandRequest request) {
  const QJsonObject way = QJsonDocument::fromJson(answer).object();
  const auto text = [&way](const char* key) {
    return way.value(QLatin1String(key)).toString().toStdString();
  };
  request.session = text("session");
  request.domain = static_cast<std::uint32_t>(way.value(QStringLiteral("domain")).toInt());
  request.interface = text("interface");
  request.secure = text("keys");
  if (const std::string scene = text("scene"); !scene.empty()) request.scene = scene;
  request.peers.clear();
  for (const QJsonValue& peer : way.value(QStringLiteral("peers")).toArray()) {
    request.peers.push_back(peer.toString().toStdString());
  }
  Join(request, text("role") != "viewer");
}

void MainWindow::EnableInvite() {
  if (invite_action_ == nullptr || panel_ == nullptr) return;
  const HandModel& hand = panel_->hand();
  const bool takes_part = hand.ready() && !hand.request().session.empty();
  invite_action_->setEnabled(takes_part || session_.state() == SessionModel::State::kJoined);
}

void MainWindow::InviteSomebody() {
  EnableInvite();
  if (!invite_action_->isEnabled()) return;
  HandRequest request = panel_->hand().request();
  if (!panel_->hand().ready() || request.session.empty()) {
    const JoinRequest& joined = session_.request();
    request = {};
    request.session = joined.session;
    request.domain = joined.domain;
    request.interface = joined.interface;
    request.peers = joined.peers;
    request.secure = joined.secure;
  }
  auto* dialog = new InviteDialog(request, TandemProgram(), this);
  dialog->setAttribute(Qt::WA_DeleteOnClose);
  dialog->show();
}

void MainWindow::Join(const HandRequest& request, bool active) {
  if (active) {
    panel_->TakePart(request);
    return;
  }
  panel_->hand().Leave();
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
