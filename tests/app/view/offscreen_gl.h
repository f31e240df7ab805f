#pragma once

#include <QImage>
#include <QOffscreenSurface>
#include <QOpenGLContext>
#include <QOpenGLFramebufferObject>
#include <memory>

#include "app/view/render/gl_check.h"
#include "app/view/render/renderer.h"

namespace tandem {

/// A context with a framebuffer of its own: what the renderer draws, as an image.
class OffscreenGl {
 public:
  explicit OffscreenGl(const QSize& size) : size_(size) {
    context_.setFormat(RendererFormat());
    ready_ = context_.create();
    surface_.setFormat(context_.format());
    surface_.create();
    ready_ = ready_ && context_.makeCurrent(&surface_);
    if (ready_) {
      target_ = std::make_unique<QOpenGLFramebufferObject>(size, QOpenGLFramebufferObject::Depth);
    }
  }
  ~OffscreenGl() { target_.reset(); }
  OffscreenGl(const OffscreenGl&) = delete;
  OffscreenGl& operator=(const OffscreenGl&) = delete;

  bool ready() const { return ready_; }
  QImage Draw(Renderer& renderer, const CameraModel& camera, const DrawList& list) {
    target_->bind();
    renderer.Draw(camera, list, size_);
    return target_->toImage();
  }

 private:
  QSize size_;
  QOpenGLContext context_;
  QOffscreenSurface surface_;
  std::unique_ptr<QOpenGLFramebufferObject> target_;
  bool ready_ = false;
};

}  // namespace tandem
