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

#include "app/view/model/hand_model.h"
#include "app/view/model/peer_table_model.h"
#include "app/view/model/picture_composer.h"
#include "app/view/model/proximity_model.h"
#include "app/view/model/scene_model.h"
#include "app/view/model/session_model.h"
#include "app/view/render/gl_check.h"
#include "app/view/ui/hand_desk.h"
#include "app/view/ui/message_page.h"
#include "app/view/ui/session_dock.h"
#include "app/view/ui/view_widget.h"

namespace tandem {

/// The window: the picture, or a page that says why there is none; the session's form and peers
/// beside it; a status bar. Asks the session 60 times a second what is new while joined, and does
/// nothing otherwise.
class MainWindow : public QMainWindow {
  Q_OBJECT

 public:
  /// `gl`: what CheckGl() found. The models must outlive the window. Without `hand` one can
  /// only look on.
  MainWindow(SessionModel& session, SceneModel& scene, const Result<GlInfo>& gl,
             HandModel* hand = nullptr);

  SessionDock& session_dock() { return *session_dock_; }
  HandDesk* desk() { return desk_; }    // null where one can only look on
  ViewWidget* view() { return view_; }  // null without OpenGL
  /// What stands in the place of the picture; null while the picture is shown.
  const MessagePage* page() const;

  /// The scene is in the picture, and poses have come.
  bool ShowsPoses() const;
  /// Switches what `Proximity` in the menu does.
  void ShowProximity(bool on);
  /// For whoever must not know of the network's condition: from here on neither docks nor menus nor
  /// figures are shown.
  void ShowSceneAlone();
  const ProximityModel& proximity() const { return proximity_; }
  const SceneModel& scene() const { return scene_; }
  /// Where a person is asked for a scene: first in the first of them.
  void SetSceneFolders(const std::vector<std::filesystem::path>& folders) {
    scene_folders_ = folders;
  }
  /// Opens the scene of a file, as its menu does.
  void OpenScene(const QString& file);
  /// Joins as the dialog does: to take part, or to look on.
  void Join(const HandRequest& request, bool active);
  /// What "Open recent" offers.
  void SetRecentScenes(const std::vector<std::filesystem::path>& files);
  /// The whole window with the picture in it, finely drawn.
  QImage Screenshot();

 Q_SIGNALS:
  /// A person has chosen it.
  void SceneChosen(const QString& file);

 protected:
  void dragEnterEvent(QDragEnterEvent* event) override;
  void dropEvent(QDropEvent* event) override;

 private:
  /// What a peer says of itself in figures, as shown: some times a second, so that they can be
  /// read.
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
  void Refresh();         // 60 Hz while joined, or while somebody fades
  void RefreshNumbers();  // 1 Hz meanwhile
  /// Puts the figures of one moment in place of the newest ones.
  void HoldFigures(ViewerPicture& picture, bool take_newest);
  /// Table and status bar tell what the picture shows: when it is drawn, or at once where it is.
  void ShowFigures();
  void ShowWarnings();
  void AskForScene();
  void AskToJoin();
  /// Gets keys and the way by `tandem join LINE --only-keys`, then joins.
  void JoinByInvitation(const QString& line, const HandRequest& request);
  /// Joins as that program's answer says.
  void JoinAsInvited(const QByteArray& answer, HandRequest request);
  void InviteSomebody();
  /// There is a session with a name to invite to.
  void EnableInvite();
  void ShowPicture(const QString& gl_error);
  void SaveScreenshot();
  void ShowKeys();

  SessionModel& session_;
  SceneModel& scene_;
  QString gl_error_;  // empty: there is OpenGL
  QStackedWidget* centre_;
  MessagePage* page_;
  ViewWidget* view_ = nullptr;
  SessionDock* session_dock_ = nullptr;
  QTableView* peers_view_ = nullptr;
  PeerTableModel peers_;
  PeerPalette palette_;
  PictureComposer composer_;
  ProximityModel proximity_;
  std::vector<BodyLook> looks_;
  ViewerPicture shown_;  // by the picture's draw list
  std::map<PeerId, Figures> figures_;
  bool scene_alone_ = false;
  QElapsedTimer clock_;
  QTimer refresh_;
  QTimer numbers_;
  int refreshes_ = 0;
  double still_until_s_ = 0;  // after leaving: until when names fade
  std::uint64_t samples_before_ = 0;
  quint64 frames_before_ = 0;
  qint64 numbers_at_ms_ = 0;
  QAction* proximity_action_ = nullptr;
  QMenu* recent_menu_ = nullptr;
  HandDesk* desk_ = nullptr;
  std::vector<std::filesystem::path> scene_folders_;
  QFileDialog* ask_ = nullptr;   // for a scene; made when first asked for
  QProcess* invited_ = nullptr;  // that asks an inviter; null: none does
  QAction* invite_action_ = nullptr;
  QLabel* status_session_ = nullptr;
  QLabel* status_proximity_ = nullptr;
  QLabel* status_scene_ = nullptr;
  QLabel* status_samples_ = nullptr;
  QLabel* status_fps_ = nullptr;
};

}  // namespace tandem
