#pragma once

#include <QImage>
#include <QOffscreenSurface>
#include <QOpenGLContext>
#include <QOpenGLFramebufferObject>
#include <memory>
#include <utility>

#include "app/view/render/gl_check.h"
#include "app/view/render/renderer.h"

namespace tandem {

/// A context with a framebuffer of its own, which gives the renderer's drawing as an image.
class OffscreenGl {
 public:
  explicit OffscreenGl(const QSize& size, int samples = 0) {
    context_.setFormat(RendererFormat());
    ready_ = context_.create();
    surface_.setFormat(context_.format());
    surface_.create();
    ready_ = ready_ && context_.makeCurrent(&surface_);
    if (ready_) SetTarget(size, samples);
  }
  ~OffscreenGl() { target_.reset(); }
  OffscreenGl(const OffscreenGl&) = delete;
  OffscreenGl& operator=(const OffscreenGl&) = delete;

  bool ready() const { return ready_; }
  /// Takes a new framebuffer in place of the one before, with `samples` for a pixel; 0: not
  /// multisampled.
  void SetTarget(const QSize& size, int samples,
                 QOpenGLFramebufferObject::Attachment depth = QOpenGLFramebufferObject::Depth) {
    QOpenGLFramebufferObjectFormat format;
    format.setSamples(samples);
    format.setAttachment(depth);
    target_ = std::make_unique<QOpenGLFramebufferObject>(size, format);
  }
  QImage Draw(Renderer& renderer, const CameraModel& camera, const DrawList& list) {
    return DrawInPart(renderer, camera, list, {}).first;
  }
  /// Returns the image, and what the renderer returns: whether the picture is whole.
  std::pair<QImage, bool> DrawInPart(Renderer& renderer, const CameraModel& camera,
                                     const DrawList& list, const Renderer::MayGoOn& may_go_on) {
    target_->bind();
    const bool whole = renderer.Draw(camera, list, target_->size(), may_go_on);
    return {target_->toImage(), whole};
  }

 private:
  QOpenGLContext context_;
  QOffscreenSurface surface_;
  std::unique_ptr<QOpenGLFramebufferObject> target_;
  bool ready_ = false;
};

}  // namespace tandem
