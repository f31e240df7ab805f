#include "app/view/ui/view_widget.h"

#include <QMouseEvent>
#include <QOpenGLContext>
#include <QOpenGLExtraFunctions>
#include <QOpenGLPaintDevice>
#include <QPainter>
#include <QWheelEvent>
#include <array>

#include "app/view/ui/overlays/hand_overlay.h"
#include "app/view/ui/overlays/picture_overlay.h"
#include "app/view/ui/overlays/proximity_overlay.h"

namespace tandem {

namespace {
constexpr int kSoftwareFrameMs = 33;  // at most 30 frames/s with a software renderer
constexpr int kRestMs = 250;          // rest before the fine frame
constexpr int kSamples = 4;
constexpr double kFarthestFollowed = 20;  // multiple of the scene's size; a body farther away is
                                          // not followed

std::array<Vec3, 8> CornersOf(const Bounds& box, const Pose& X_W) {
  std::array<Vec3, 8> corners;
  for (std::size_t i = 0; i < corners.size(); ++i) {
    corners[i] = X_W * Vec3((i & 1U) != 0 ? box.max.x() : box.min.x(),
                            (i & 2U) != 0 ? box.max.y() : box.min.y(),
                            (i & 4U) != 0 ? box.max.z() : box.min.z());
  }
  return corners;
}

/// Calls use(body, corners) for each instance and ghost that is not too far away.
template <typename Use>
void ForEachInstance(const DrawnScene& scene, const DrawList& list, Use use) {
  const Bounds all = scene.BoundsOfAll();
  for (const std::vector<BodyInstance>* some : {&list.solids, &list.ghosts}) {
    for (const BodyInstance& one : *some) {
      if (one.body >= scene.bodies.size() || scene.bodies[one.body].bounds_W.empty()) continue;
      const Bounds& box = scene.bodies[one.body].bounds_W;
      const double away = (one.X_W * box.centre() - all.centre()).norm();
      if (away < kFarthestFollowed * all.size().norm()) {
        use(scene.bodies[one.body], CornersOf(box, one.X_W));
      }
    }
  }
}

}  // namespace

ViewWidget::ViewWidget(const GlInfo& gl, QWidget* parent) : QOpenGLWidget(parent), gl_(gl) {
  setFocusPolicy(Qt::StrongFocus);
  setMinimumSize(320, 240);
  setAccessibleName(tr("Three-dimensional view of the scene"));
  camera_.LookFrom(StandardView::kIso);
  next_frame_.setSingleShot(true);
  next_frame_.setTimerType(Qt::PreciseTimer);
  connect(&next_frame_, &QTimer::timeout, this, qOverload<>(&QWidget::update));
  refine_.setSingleShot(true);
  connect(&refine_, &QTimer::timeout, this, &ViewWidget::DrawAtRest);
}

ViewWidget::~ViewWidget() {
  makeCurrent();
  fine_.reset();
  renderer_.reset();
  doneCurrent();
}

void ViewWidget::SetScene(const DrawnScene* scene) {
  if (scene == scene_) return;
  scene_ = scene;
  uploaded_ = false;
  fitted_ = false;
  RequestFrame();
}

void ViewWidget::SetDrawList(const DrawList& list) {
  if (list == list_) return;
  list_ = list;
  if (follow_) FollowBodies();
  RequestFrame();
}

void ViewWidget::SetFollow(bool follow) {
  if (follow == follow_) return;
  follow_ = follow;
  if (follow_) {
    FollowBodies();
    RequestFrame();
  }
  Q_EMIT FollowChanged(follow_);
}

void ViewWidget::FollowBodies() {
  if (scene_ == nullptr || !fitted_) return;
  bool all_in = true;
  ForEachInstance(*scene_, list_, [&](const DrawnBody& body, const std::array<Vec3, 8>& corners) {
    if (body.look.fixed) return;
    for (const Vec3& corner : corners) {
      const auto px = camera_.Project(corner);
      all_in =
          all_in && px && px->x() >= 0 && px->x() <= width() && px->y() >= 0 && px->y() <= height();
    }
  });
  if (!all_in) FitCamera();
}

void ViewWidget::SetWarning(const QString& warning) {
  if (warning == warning_) return;
  warning_ = warning;
  RequestFrame();
}

void ViewWidget::SetHand(const HandPicture& hand) {
  if (hand == hand_) return;
  hand_ = hand;
  RequestFrame();
}

void ViewWidget::SetProximity(std::shared_ptr<const ProximityPicture> proximity) {
  if (proximity == proximity_) return;
  proximity_ = std::move(proximity);
  proximity_uploaded_ = false;
  RequestFrame();
}

void ViewWidget::FitScene() {
  SetFollow(true);
  FitCamera();
  RequestFrame();
}

void ViewWidget::FitCamera() {
  if (scene_ == nullptr) return;
  Bounds all = scene_->BoundsOfAll();
  ForEachInstance(*scene_, list_, [&](const DrawnBody&, const std::array<Vec3, 8>& corners) {
    for (const Vec3& corner : corners) all.Add(corner);
  });
  camera_.Fit(all);
}

void ViewWidget::LookFrom(StandardView view) {
  camera_.LookFrom(view);
  FitScene();
}

void ViewWidget::RequestFrame() {
  frame_due_ = true;
  if (!gl_.software || !since_frame_.isValid()) {
    update();
    return;
  }
  if (next_frame_.isActive()) return;
  next_frame_.start(PauseMs());
}

int ViewWidget::PauseMs() const {
  const qint64 pause = std::max<qint64>(kSoftwareFrameMs, 2 * frame_ms_) - since_frame_.elapsed();
  return static_cast<int>(std::max<qint64>(pause, 0));
}

void ViewWidget::DrawAtRest() {
  at_rest_ = true;
  update();
}

void ViewWidget::DrawToKeep() {
  to_keep_ = true;
  update();
}

void ViewWidget::initializeGL() {
  // also called when the widget moves to another window
  fine_.reset();
  renderer_ = std::make_unique<Renderer>();
  uploaded_ = false;
  if (const auto error = renderer_->Initialize()) {
    renderer_.reset();
    Q_EMIT Failed(QString::fromStdString(error->what));
  }
}

void ViewWidget::resizeGL(int width, int height) {
  camera_.SetViewport(width, height);
}

bool ViewWidget::DrawCoarsely(const Renderer::MayGoOn& may_go_on) {
  return renderer_->Draw(camera_, list_, size() * devicePixelRatioF(), may_go_on);
}

bool ViewWidget::DrawFinely(const Renderer::MayGoOn& may_go_on) {
  const QSize pixels = size() * devicePixelRatioF();
  if (!fine_ || fine_->size() != pixels) {
    QOpenGLFramebufferObjectFormat format;
    format.setSamples(kSamples);
    format.setAttachment(QOpenGLFramebufferObject::Depth);
    fine_ = std::make_unique<QOpenGLFramebufferObject>(pixels, format);
  }
  fine_->bind();
  const bool whole = renderer_->Draw(camera_, list_, pixels, may_go_on);
  QOpenGLExtraFunctions* gl = context()->extraFunctions();
  gl->glBindFramebuffer(GL_READ_FRAMEBUFFER, fine_->handle());
  gl->glBindFramebuffer(GL_DRAW_FRAMEBUFFER, defaultFramebufferObject());
  gl->glBlitFramebuffer(0, 0, pixels.width(), pixels.height(), 0, 0, pixels.width(),
                        pixels.height(), GL_COLOR_BUFFER_BIT, GL_NEAREST);
  gl->glBindFramebuffer(GL_FRAMEBUFFER, defaultFramebufferObject());
  return whole;
}

ViewWidget::Left ViewWidget::DrawScene() {
  QElapsedTimer clock;
  clock.start();
  Renderer::MayGoOn may_go_on;
  if (!to_keep_) {
    may_go_on = [&clock] {
      return clock.elapsed() < kStaticPictureMs;
    };
  }
  if (!gl_.software) return DrawFinely(may_go_on) ? Left::kNothing : Left::kParts;
  Left left = Left::kNothing;
  const bool fine = to_keep_ || at_rest_;
  if (!fine || !DrawFinely(may_go_on)) {
    // shows the coarse picture while the fine one has gaps
    left = fine ? Left::kPartsOfFineFrame : Left::kFineFrame;
    if (!DrawCoarsely(may_go_on)) left = Left::kParts;
  }
  context()->functions()->glFinish();  // makes the frame's time visible here
  return left;
}

void ViewWidget::GoOn(Left left) {
  refine_.stop();
  if (left == Left::kParts) RequestFrame();
  if (left == Left::kFineFrame) refine_.start(kRestMs);
  if (left == Left::kPartsOfFineFrame) refine_.start(PauseMs());
}

void ViewWidget::paintGL() {
  frame_due_ = false;
  if (!renderer_ || scene_ == nullptr) {
    context()->functions()->glClearColor(1.0F, 1.0F, 1.0F, 1.0F);
    context()->functions()->glClear(GL_COLOR_BUFFER_BIT);
    return;
  }
  QElapsedTimer clock;
  clock.start();
  if (!uploaded_) {
    renderer_->Upload(scene_->bodies);
    uploaded_ = true;
    proximity_uploaded_ = false;
  }
  if (!proximity_uploaded_) {
    renderer_->ShowProximity(proximity_.get());
    proximity_uploaded_ = true;
  }
  if (!fitted_) {
    FitCamera();
    fitted_ = true;
  }
  const Left left = DrawScene();
  at_rest_ = false;
  to_keep_ = false;
  {
    // not on `this`, where a grab of the window would redirect the painter
    QOpenGLPaintDevice picture(size() * devicePixelRatioF());
    picture.setDevicePixelRatio(devicePixelRatioF());
    QPainter painter(&picture);
    painter.setFont(font());
    if (proximity_) PaintProximity(painter, size(), camera_, *proximity_);
    PaintOverlay(painter, size(), camera_, *scene_, list_, warning_);
    PaintHand(painter, camera_, hand_);
  }
  frame_ms_ = clock.elapsed();
  since_frame_.start();
  GoOn(left);
  ++frames_drawn_;
  Q_EMIT FrameDrawn();
}

void ViewWidget::mousePressEvent(QMouseEvent* event) {
  mouse_at_ = event->pos();
}

void ViewWidget::mouseMoveEvent(QMouseEvent* event) {
  const QPoint moved = event->pos() - mouse_at_;
  mouse_at_ = event->pos();
  const bool left = event->buttons().testFlag(Qt::LeftButton);
  const bool shift = event->modifiers().testFlag(Qt::ShiftModifier);
  if (event->buttons().testFlag(Qt::MiddleButton) || (left && shift)) {
    camera_.Pan(moved.x(), moved.y());
    SetFollow(false);
  } else if (left) {
    camera_.Orbit(moved.x(), moved.y());
  } else {
    return;
  }
  RequestFrame();
}

void ViewWidget::wheelEvent(QWheelEvent* event) {
  SetFollow(false);
  constexpr double kUnitsPerNotch = 120.0;
  camera_.ZoomAt({event->position().x(), event->position().y()},
                 event->angleDelta().y() / kUnitsPerNotch);
  RequestFrame();
}

}  // namespace tandem
