#pragma once

#include <QElapsedTimer>
#include <QLabel>
#include <QMainWindow>
#include <QStackedWidget>
#include <QTableView>
#include <QTimer>
#include <optional>

#include "app/view/model/peer_table_model.h"
#include "app/view/model/picture_composer.h"
#include "app/view/model/proximity_model.h"
#include "app/view/model/scene_model.h"
#include "app/view/model/session_model.h"
#include "app/view/render/gl_check.h"
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
  /// `gl`: what CheckGl() found. The models must outlive the window.
  MainWindow(SessionModel& session, SceneModel& scene, const Result<GlInfo>& gl);

  SessionDock& session_dock() { return *session_dock_; }
  ViewWidget* view() { return view_; }  // null without OpenGL
  /// What stands in the place of the picture; null while the picture is shown.
  const MessagePage* page() const;

  /// The scene is in the picture, and poses have come.
  bool ShowsPoses() const;
  /// Switches what `Proximity` in the menu does.
  void ShowProximity(bool on);
  const ProximityModel& proximity() const { return proximity_; }
  /// The whole window with the picture in it, finely drawn.
  QImage Screenshot();

 private:
  void MakeDocks();
  void MakeActions();
  void MakeStatusBar();
  QLabel* AddStatus(const QString& name);
  void OnSessionChanged();
  void OnSceneChanged();
  void OnProximityChanged();
  void Refresh();         // 60 Hz while joined, or while somebody fades
  void RefreshNumbers();  // 1 Hz meanwhile
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
  QElapsedTimer clock_;
  QTimer refresh_;
  QTimer numbers_;
  int refreshes_ = 0;
  double still_until_s_ = 0;  // after leaving: until when names fade
  std::uint64_t samples_before_ = 0;
  quint64 frames_before_ = 0;
  qint64 numbers_at_ms_ = 0;
  QAction* proximity_action_ = nullptr;
  QLabel* status_session_ = nullptr;
  QLabel* status_proximity_ = nullptr;
  QLabel* status_scene_ = nullptr;
  QLabel* status_samples_ = nullptr;
  QLabel* status_fps_ = nullptr;
};

}  // namespace tandem
