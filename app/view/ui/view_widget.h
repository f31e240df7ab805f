#pragma once

#include <QElapsedTimer>
#include <QOpenGLFramebufferObject>
#include <QOpenGLWidget>
#include <QTimer>
#include <memory>

#include "app/view/model/camera_model.h"
#include "app/view/model/drawn_scene.h"
#include "app/view/model/hand_picture.h"
#include "app/view/model/picture_composer.h"
#include "app/view/model/proximity_picture.h"
#include "app/view/render/gl_check.h"
#include "app/view/render/renderer.h"

namespace tandem {

/// The picture, and the mouse in it: left orbits, middle or Shift+left pans, the wheel zooms at the
/// cursor. While it follows, a body that goes out of the picture has the camera step back; to pan
/// or zoom ends that, to fit begins it. Draws only when something is different. Where the processor
/// draws, it does so at most half of the time and without smooth rims while things move, then once
/// more finely. A frame spends a limited time on the bodies that are fixed: while the eye moves
/// over a large scene, their largest parts are seen, and the frames at rest add the others.
class ViewWidget : public QOpenGLWidget {
  Q_OBJECT

 public:
  explicit ViewWidget(const GlInfo& gl, QWidget* parent = nullptr);
  ~ViewWidget() override;

  /// `scene` must outlive its being shown; null: none. Fits it into the picture.
  void SetScene(const DrawnScene* scene);
  void SetDrawList(const DrawList& list);
  void SetWarning(const QString& warning);
  /// Null: proximity is not shown.
  void SetProximity(std::shared_ptr<const ProximityPicture> proximity);
  /// What is drawn of the user's own hand.
  void SetHand(const HandPicture& hand);
  void FitScene();
  void SetFollow(bool follow);
  bool follow() const { return follow_; }
  void LookFrom(StandardView view);
  /// The next frame is fine and whole, however long it takes: for a picture that is kept.
  void DrawToKeep();

  const CameraModel& camera() const { return camera_; }
  quint64 frames_drawn() const { return frames_drawn_; }
  /// Whether what was set last is still to be drawn.
  bool frame_due() const { return frame_due_; }
  const DrawList& draw_list() const { return list_; }
  const HandPicture& hand() const { return hand_; }
  const DrawnScene* scene() const { return scene_; }
  const QString& warning() const { return warning_; }
  const std::shared_ptr<const ProximityPicture>& proximity() const { return proximity_; }

 Q_SIGNALS:
  void Failed(const QString& why);
  void FollowChanged(bool follow);
  /// What was set last is drawn.
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
  /// Says which work a frame leaves to the frames after it.
  enum class Left { kNothing, kParts, kFineFrame, kPartsOfFineFrame };
  Left DrawScene();
  void GoOn(Left left);
  bool DrawCoarsely(const Renderer::MayGoOn& may_go_on);
  bool DrawFinely(const Renderer::MayGoOn& may_go_on);
  int PauseMs() const;

  GlInfo gl_;
  CameraModel camera_;
  std::unique_ptr<Renderer> renderer_;
  std::unique_ptr<QOpenGLFramebufferObject> fine_;  // four samples a pixel
  const DrawnScene* scene_ = nullptr;
  bool uploaded_ = true;
  bool fitted_ = false;  // to a picture of real size
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
  bool at_rest_ = false;  // the next frame may be fine
  bool to_keep_ = false;  // the next frame is fine and whole
  quint64 frames_drawn_ = 0;
};

}  // namespace tandem
