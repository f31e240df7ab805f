#pragma once

#include <QElapsedTimer>
#include <QOpenGLFramebufferObject>
#include <QOpenGLWidget>
#include <QTimer>
#include <memory>

#include "app/view/model/hand/hand_picture.h"
#include "app/view/model/proximity/proximity_picture.h"
#include "app/view/model/scene/camera_model.h"
#include "app/view/model/scene/drawn_scene.h"
#include "app/view/model/scene/picture_composer.h"
#include "app/view/render/gl_check.h"
#include "app/view/render/renderer.h"

namespace tandem {

/// The picture, and its mouse: left orbits, middle or Shift+left pans, the wheel zooms at the
/// cursor. While the camera follows, it steps back when a body leaves the picture. Panning and
/// zooming end that, fitting starts it.
///
/// The widget draws only after a change. With a software renderer it draws at most half of the
/// time, and without antialiasing while bodies move, then once finely. A frame spends a limited
/// time on fixed bodies: while the eye moves over a large scene, the largest parts are drawn, and
/// frames at rest add the others.
class ViewWidget : public QOpenGLWidget {
  Q_OBJECT

 public:
  explicit ViewWidget(const GlInfo& gl, QWidget* parent = nullptr);
  ~ViewWidget() override;

  /// Shows a scene, which must outlive that, and fits it into the picture; null: none.
  void SetScene(const DrawnScene* scene);
  void SetDrawList(const DrawList& list);
  void SetWarning(const QString& warning);
  /// Sets the picture of proximity; null: it is not shown.
  void SetProximity(std::shared_ptr<const ProximityPicture> proximity);
  /// Sets what is drawn of the user's own hand.
  void SetHand(const HandPicture& hand);
  void FitScene();
  void SetFollow(bool follow);
  bool follow() const { return follow_; }
  void LookFrom(StandardView view);
  /// Makes the next frame fine and whole, however long it takes, for a picture that is kept.
  void DrawToKeep();

  const CameraModel& camera() const { return camera_; }
  quint64 frames_drawn() const { return frames_drawn_; }
  /// Returns whether the last change is not drawn yet.
  bool frame_due() const { return frame_due_; }
  const DrawList& draw_list() const { return list_; }
  const HandPicture& hand() const { return hand_; }
  const DrawnScene* scene() const { return scene_; }
  const QString& warning() const { return warning_; }
  const std::shared_ptr<const ProximityPicture>& proximity() const { return proximity_; }

 Q_SIGNALS:
  void Failed(const QString& why);
  void FollowChanged(bool follow);
  /// The last change is drawn.
  void FrameDrawn();

 protected:
  void initializeGL() override;
  void resizeGL(int width, int height) override;
  void paintGL() override;
  void mousePressEvent(QMouseEvent* event) override;
  void mouseMoveEvent(QMouseEvent* event) override;
  void wheelEvent(QWheelEvent* event) override;

 private:
  void FitCamera();
  void FollowBodies();
  void RequestFrame();
  void DrawAtRest();
  /// The work that a frame leaves to later frames.
  enum class Left { kNothing, kParts, kFineFrame, kPartsOfFineFrame };
  Left DrawScene();
  void GoOn(Left left);
  bool DrawCoarsely(const Renderer::MayGoOn& may_go_on);
  bool DrawFinely(const Renderer::MayGoOn& may_go_on);
  int PauseMs() const;

  GlInfo gl_;
  CameraModel camera_;
  std::unique_ptr<Renderer> renderer_;
  std::unique_ptr<QOpenGLFramebufferObject> fine_;  // framebuffer with four samples a pixel
  const DrawnScene* scene_ = nullptr;
  bool uploaded_ = true;
  bool fitted_ = false;  // true: the camera was fitted to a picture of real size
  bool follow_ = true;
  bool frame_due_ = false;
  DrawList list_;
  HandPicture hand_;
  std::shared_ptr<const ProximityPicture> proximity_;
  bool proximity_uploaded_ = true;
  QString warning_;
  QPoint mouse_at_;
  QElapsedTimer since_frame_;
  QTimer next_frame_;
  QTimer refine_;
  qint64 frame_ms_ = 0;
  bool at_rest_ = false;  // true: the next frame may be fine
  bool to_keep_ = false;  // true: the next frame must be fine and whole
  quint64 frames_drawn_ = 0;
};

}  // namespace tandem
