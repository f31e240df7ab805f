#pragma once

#include <QAction>
#include <QMainWindow>
#include <QMenu>
#include <QTimer>
#include <QToolBar>
#include <vector>

#include "app/view/model/hand_model.h"
#include "app/view/model/scene_model.h"
#include "app/view/model/session_model.h"
#include "app/view/ui/hand_mouse.h"
#include "app/view/ui/view_widget.h"

namespace tandem {

/// All that the window has for taking part: the toolbar and the menu "Hand" with their keys, the
/// mouse in the picture, and the way into a session with a hand of one's own. Each action that
/// cannot be done now is grey, and its tooltip says what it does; a refusal is told in words.
class HandDesk : public QObject {
  Q_OBJECT

 public:
  HandDesk(HandModel& hand, SessionModel& session, SceneModel& scene, QMainWindow& window,
           ViewWidget* view);

  /// Opens a scene with a controller of its own.
  void Open(const QString& file);
  /// Takes part in a session; where its scene's file is not given, it is looked for first.
  void TakePart(const HandRequest& request);
  /// What a request from the window goes by where it says nothing else.
  void SetDefaults(const HandRequest& request) { defaults_ = request; }
  const HandRequest& defaults() const { return defaults_; }
  /// Moves the hand by that device from now on, NAME[:OPTIONS]; empty: by the mouse. A controller
  /// of the window's own begins anew with it.
  void UseDevice(const QString& device);

  /// Leaves the emergency stop and its end to be pressed, and of forces no figures: for a window
  /// that shows the scene alone.
  void KeepStopAlone();

  /// What the picture shows instead of the session's, while a controller is there.
  bool shows() const { return hand_.shows(); }
  void DressPicture(const std::vector<BodyLook>& looks, DrawList& list);
  /// What is going on with the hand, for the status bar and the picture; empty: nothing.
  QString StateText() const;
  QString Words() const { return words_; }
  /// How many snapshots have come.
  std::uint64_t snapshots() const { return snapshots_; }
  HandMouse* mouse() { return mouse_; }
  HandModel& hand() { return hand_; }

 Q_SIGNALS:
  void Changed();

 private:
  void MakeActions();
  QAction* Add(const char* name, const QString& text, const QKeySequence& key, const QString& tip);
  void Refresh();
  void OnHandState();
  void OnSnapshot();
  void OnSession();
  void TakeUnderCursor();
  void AskUnderCursor();
  void FillGiveMenu();
  void TellOfContact();
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
  std::optional<HandRequest> waiting_;  // for the session's scene
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
  double scale_now_ = 1;  // of a device, as last asked for
  std::uint64_t snapshots_ = 0;
};

/// How a viewer joins where an active user would join by `request`.
JoinRequest ViewerRequest(const HandRequest& request);

}  // namespace tandem
