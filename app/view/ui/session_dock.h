#pragma once

#include <QComboBox>
#include <QDockWidget>
#include <QLabel>
#include <QLineEdit>
#include <QPushButton>
#include <QSpinBox>

#include "app/view/model/scene/scene_model.h"
#include "app/view/model/session/session_model.h"

namespace tandem {

/// The form to join and leave a session, and the facts about the session and its scene.
class SessionDock : public QDockWidget {
  Q_OBJECT

 public:
  SessionDock(SessionModel& session, SceneModel& scene, QWidget* parent = nullptr);

  void SetRequest(const JoinRequest& request);
  JoinRequest Request() const;
  /// Shows the hand's state instead of the viewer's while the user takes part, and disables joining
  /// as a viewer. Empty: the user looks on.
  void ShowHand(const QString& text);
  /// Makes the button that joins start a hand again that has ended.
  void OfferAgain(bool offered);

 Q_SIGNALS:
  void AgainAsked();

 private:
  void ShowSession();
  void ShowScene();
  void Join();

  QString hand_text_;
  bool again_ = false;  // true: the button starts the hand again
  JoinRequest given_;   // request as given, for what the form does not ask
  SessionModel& session_model_;
  SceneModel& scene_model_;
  QLineEdit* session_;
  QLineEdit* name_;
  QSpinBox* domain_;
  QComboBox* interface_;
  QPushButton* join_;
  QPushButton* leave_;
  QLabel* state_;
  QLabel* scene_name_;
  QLabel* scene_size_;
  QLabel* voxel_size_;
};

}  // namespace tandem
