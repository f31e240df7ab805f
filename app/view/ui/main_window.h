#pragma once

#include <QElapsedTimer>
#include <QFileDialog>
#include <QLabel>
#include <QMainWindow>
#include <QProcess>
#include <QStackedWidget>
#include <QTableView>
#include <QTimer>
#include <map>
#include <optional>

#include "app/view/model/hand/hand_model.h"
#include "app/view/model/proximity/proximity_model.h"
#include "app/view/model/scene/picture_composer.h"
#include "app/view/model/scene/scene_model.h"
#include "app/view/model/session/peer_table_model.h"
#include "app/view/model/session/session_model.h"
#include "app/view/model/words/window_words.h"
#include "app/view/render/gl_check.h"
#include "app/view/ui/hand_panel.h"
#include "app/view/ui/message_page.h"
#include "app/view/ui/notice_bar.h"
#include "app/view/ui/session_dock.h"
#include "app/view/ui/view_widget.h"

namespace tandem {

/// The window: the picture, or a page that says why there is none; beside it the session's form and
/// the peers; a status bar. While joined it reads the session 60 times a second.
class MainWindow : public QMainWindow {
  Q_OBJECT

 public:
  /// `gl`: the result of CheckGl(). The models must outlive the window. Without `hand` the user can
  /// only look on.
  MainWindow(SessionModel& session, SceneModel& scene, const Result<GlInfo>& gl,
             HandModel* hand = nullptr);

  SessionDock& session_dock() { return *session_dock_; }
  HandPanel* panel() { return panel_; }  // null where the user can only look on
  ViewWidget* view() { return view_; }   // null without OpenGL
  /// Returns the page in place of the picture; null while the picture is shown.
  const MessagePage* page() const;

  /// Returns whether the picture shows the scene and poses have come.
  bool ShowsPoses() const;
  /// Switches the menu's `Proximity`.
  void ShowProximity(bool on);
  /// Hides docks, menus and figures, for a user who must not know the network's condition.
  void ShowSceneAlone();
  const ProximityModel& proximity() const { return proximity_; }
  const SceneModel& scene() const { return scene_; }
  /// Sets the folders where the file dialog looks for a scene. It starts in the first of them.
  void SetSceneFolders(const std::vector<std::filesystem::path>& folders) {
    scene_folders_ = folders;
  }
  /// Opens the scene of a file, as its menu does.
  void OpenScene(const QString& file);
  /// Joins a session as the dialog does, to take part or to look on.
  void Join(const HandRequest& request, bool active);
  /// Sets the files of "Open recent".
  void SetRecentScenes(const std::vector<std::filesystem::path>& files);
  /// Returns the whole window with a finely drawn picture.
  QImage Screenshot();

 Q_SIGNALS:
  /// A person has chosen this scene file.
  void SceneChosen(const QString& file);

 protected:
  void dragEnterEvent(QDragEnterEvent* event) override;
  void dropEvent(QDropEvent* event) override;

 private:
  /// The figures of a peer, as shown. They change some times a second, so that they can be read.
  struct Figures {
    double delay_ms = 0;
    double mirror_lag_mm = 0;
    double link_force = 0;
  };
  void MakeDocks();
  void MakeActions(bool with_hand);
  void MakeStatusBar();
  QLabel* AddStatus(const QString& name);
  void OnSessionChanged();
  void OnHandChanged();
  void OnFrameDrawn();
  void OnSceneChanged();
  void OnProximityChanged();
  void Refresh();         // at 60 Hz while joined, or while an instance fades
  void RefreshNumbers();  // at 1 Hz meanwhile
  /// Replaces the newest figures by those held, or holds the newest ones.
  void HoldFigures(ViewerPicture& picture, bool take_newest);
  /// Updates table and status bar to the picture's state. Called when the picture is drawn, or at
  /// once where it is drawn already.
  void ShowFigures();
  void ShowWarnings();
  void UpdateNotices();
  /// Offers sessions that are announced, where nobody answers in the session that was asked for.
  void OfferOtherSessions();
  /// Goes to another session, to take part or to look on as the user wanted in the present one.
  void GoTo(const std::string& session);
  void OfferHandOver();
  void WarnOfScene();
  void ShowVerdicts(const QStringList& lines);
  void AskForScene();
  void AskToJoin();
  /// Returns the session to propose for joining; empty: none that is known to be there.
  std::string SessionInMind() const;
  /// Gets keys and addresses by `tandem join LINE --only-keys`, then joins.
  void JoinByInvitation(const QString& line, const HandRequest& request);
  /// Joins as that program's answer says.
  void JoinAsInvited(const QByteArray& answer, HandRequest request);
  void InviteSomebody();
  /// Enables the invitation if there is a session with a name.
  void EnableInvite();
  void ShowPicture(const QString& gl_error);
  void SaveScreenshot();
  void ShowKeys();

  SessionModel& session_;
  SceneModel& scene_;
  QString gl_error_;  // reason for no OpenGL; empty: there is OpenGL
  QStackedWidget* centre_;
  MessagePage* page_;
  NoticeBar* notices_;
  QString warned_;  // warnings of the scene that were shown
  ViewWidget* view_ = nullptr;
  SessionDock* session_dock_ = nullptr;
  QTableView* peers_view_ = nullptr;
  PeerTableModel peers_;
  PictureComposer composer_;
  ProximityModel proximity_;
  std::vector<BodyLook> looks_;
  ViewerPicture shown_;  // state of the picture's draw list
  std::map<PeerId, Figures> figures_;
  bool scene_alone_ = false;
  QElapsedTimer clock_;
  QTimer refresh_;
  QTimer numbers_;
  int refreshes_ = 0;
  double still_until_s_ = 0;  // time after leaving until which names fade
  std::uint64_t samples_before_ = 0;
  quint64 frames_before_ = 0;
  qint64 numbers_at_ms_ = 0;
  QAction* proximity_action_ = nullptr;
  QMenu* recent_menu_ = nullptr;
  HandPanel* panel_ = nullptr;
  std::vector<std::filesystem::path> scene_folders_;
  QFileDialog* ask_ = nullptr;   // dialog for a scene; made when first asked for
  QProcess* invited_ = nullptr;  // process that asks an inviter; null: none
  QAction* invite_action_ = nullptr;
  QLabel* status_session_ = nullptr;
  QLabel* status_proximity_ = nullptr;
  QLabel* status_scene_ = nullptr;
  QLabel* status_samples_ = nullptr;
  QLabel* status_fps_ = nullptr;
};

}  // namespace tandem
