#include "app/view/render/static_picture.h"

namespace tandem {

FramebufferFormat BoundFormat(QOpenGLFunctions_3_3_Core& gl) {
  FramebufferFormat format;
  GLint depth = 0;
  gl.glGetFramebufferAttachmentParameteriv(GL_DRAW_FRAMEBUFFER, GL_DEPTH_ATTACHMENT,
                                           GL_FRAMEBUFFER_ATTACHMENT_OBJECT_NAME, &depth);
  gl.glBindRenderbuffer(GL_RENDERBUFFER, static_cast<GLuint>(depth));
  gl.glGetRenderbufferParameteriv(GL_RENDERBUFFER, GL_RENDERBUFFER_INTERNAL_FORMAT, &format.depth);
  gl.glGetRenderbufferParameteriv(GL_RENDERBUFFER, GL_RENDERBUFFER_SAMPLES, &format.samples);
  gl.glBindRenderbuffer(GL_RENDERBUFFER, 0);
  return format;
}

void StaticPicture::Free(QOpenGLFunctions_3_3_Core& gl) {
  gl.glDeleteFramebuffers(1, &framebuffer_);
  gl.glDeleteRenderbuffers(1, &colour_);
  gl.glDeleteRenderbuffers(1, &depth_);
  *this = {};
}

void StaticPicture::Allocate(QOpenGLFunctions_3_3_Core& gl) {
  gl.glGenFramebuffers(1, &framebuffer_);
  gl.glBindFramebuffer(GL_FRAMEBUFFER, framebuffer_);
  const auto attach = [&](GLuint& buffer, GLenum format, GLenum attachment) {
    gl.glGenRenderbuffers(1, &buffer);
    gl.glBindRenderbuffer(GL_RENDERBUFFER, buffer);
    gl.glRenderbufferStorageMultisample(GL_RENDERBUFFER, key_.format.samples, format,
                                        key_.size.width(), key_.size.height());
    gl.glFramebufferRenderbuffer(GL_FRAMEBUFFER, attachment, GL_RENDERBUFFER, buffer);
  };
  attach(colour_, GL_RGBA8, GL_COLOR_ATTACHMENT0);
  const auto depth = static_cast<GLenum>(key_.format.depth);
  const bool stencil = depth == GL_DEPTH24_STENCIL8 || depth == GL_DEPTH_STENCIL;
  attach(depth_, depth, stencil ? GL_DEPTH_STENCIL_ATTACHMENT : GL_DEPTH_ATTACHMENT);
  gl.glBindRenderbuffer(GL_RENDERBUFFER, 0);
  // copies all planes, stencil too: only then does the driver copy a buffer as plain memory
  copied_ = GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT | (stencil ? GL_STENCIL_BUFFER_BIT : 0U);
}

void StaticPicture::Begin(QOpenGLFunctions_3_3_Core& gl, const StaticKey& key) {
  const bool fits = framebuffer_ != 0 && key.size == key_.size && key.format == key_.format;
  if (!fits) Free(gl);
  key_ = key;
  pieces_ = 0;
  if (!fits) Allocate(gl);
  Bind(gl);
  gl.glClearColor(1.0F, 1.0F, 1.0F, 1.0F);
  gl.glClear(copied_);
}

void StaticPicture::Bind(QOpenGLFunctions_3_3_Core& gl) const {
  gl.glBindFramebuffer(GL_FRAMEBUFFER, framebuffer_);
}

void StaticPicture::CopyTo(QOpenGLFunctions_3_3_Core& gl, GLuint target) const {
  const GLint width = key_.size.width();
  const GLint height = key_.size.height();
  gl.glBindFramebuffer(GL_READ_FRAMEBUFFER, framebuffer_);
  gl.glBindFramebuffer(GL_DRAW_FRAMEBUFFER, target);
  gl.glBlitFramebuffer(0, 0, width, height, 0, 0, width, height, copied_, GL_NEAREST);
  gl.glBindFramebuffer(GL_FRAMEBUFFER, target);
}

}  // namespace tandem
