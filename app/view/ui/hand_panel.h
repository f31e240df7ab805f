#pragma once

#include <QAction>
#include <QMainWindow>
#include <QMenu>
#include <QTimer>
#include <QToolBar>
#include <vector>

#include "app/view/model/hand/hand_model.h"
#include "app/view/model/scene/scene_model.h"
#include "app/view/model/session/session_model.h"
#include "app/view/ui/hand_mouse.h"
#include "app/view/ui/view_widget.h"

namespace tandem {

/// The controls for taking part: the toolbar and the menu "Hand" with their keys, the mouse in the
/// picture, and the way into a session with a hand. An action that is impossible at the moment is
/// grey; its tooltip says what it does. A refusal is told in words.
class HandPanel : public QObject {
  Q_OBJECT

 public:
  HandPanel(HandModel& hand, SessionModel& session, SceneModel& scene, QMainWindow& window,
            ViewWidget* view);

  /// Opens a scene with a controller of the window's own.
  void Open(const QString& file);
  /// Takes part in a session. Without a scene file, first looks for the session's scene.
  void TakePart(const HandRequest& request);
  /// Sets what a request from the window uses where it says nothing else.
  void SetDefaults(const HandRequest& request) { defaults_ = request; }
  const HandRequest& defaults() const { return defaults_; }
  /// Returns whether the user is to take part once the session's scene is known.
  bool waits() const { return waiting_.has_value(); }
  /// Chooses the device that moves the hand, NAME[:OPTIONS]; empty: the mouse. A running controller
  /// starts again with it.
  void UseDevice(const QString& device);

  /// Hides all actions but the emergency stop and its end, and all figures of forces, for a window
  /// that shows the scene alone.
  void KeepStopAlone();

  /// Returns whether the picture shows the controller's state instead of the session's.
  bool shows() const { return hand_.shows(); }
  void DecoratePicture(const std::vector<BodyLook>& looks, DrawList& list);
  /// Returns the hand's state for the status bar and the picture; empty: nothing to show.
  QString StateText() const;
  QString Words() const { return words_; }
  /// Returns the number of snapshots received.
  std::uint64_t snapshots() const { return snapshots_; }
  HandMouse* mouse() { return mouse_; }
  HandModel& hand() { return hand_; }

 Q_SIGNALS:
  void Changed();

 private:
  void MakeActions();
  /// Puts the actions into the tool bar and the menu bar.
  void FillBar();
  void ConnectActions();
  QAction* Add(const char* name, const QString& text, const QKeySequence& key, const QString& tip);
  void Refresh();
  void OnHandState();
  void OnSnapshot();
  void OnSession();
  void TakeUnderCursor();
  void AskUnderCursor();
  void FillGiveMenu();
  void ReportContact();
  void AskScale();
  void AskDevice();
  void Say(const QString& words);

  HandModel& hand_;
  SessionModel& session_;
  SceneModel& scene_;
  QMainWindow& window_;
  ViewWidget* view_;
  HandMouse* mouse_ = nullptr;  // null without a picture
  HandRequest defaults_;
  std::optional<HandRequest> waiting_;  // request that waits for the session's scene
  QToolBar* bar_ = nullptr;
  QMenu* menu_ = nullptr;
  QMenu* give_menu_ = nullptr;
  QAction* grab_ = nullptr;
  QAction* release_ = nullptr;
  QAction* give_ = nullptr;
  QAction* ask_ = nullptr;
  QAction* back_ = nullptr;
  QAction* undo_ = nullptr;
  QAction* reset_ = nullptr;
  QAction* triad_ = nullptr;
  QAction* clutch_ = nullptr;
  QAction* device_ = nullptr;
  QAction* scale_ = nullptr;
  QAction* sound_ = nullptr;
  QAction* stop_ = nullptr;
  QAction* resume_ = nullptr;
  QString words_;
  QTimer words_end_;
  bool in_contact_ = false;
  bool stop_alone_ = false;
  double scale_now_ = 1;  // scale of a device, as last asked for
  std::uint64_t snapshots_ = 0;
};

/// Returns the request by which a viewer joins where an active user would join by `request`.
JoinRequest ViewerRequest(const HandRequest& request);

}  // namespace tandem
