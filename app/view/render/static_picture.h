#pragma once

#include <QSize>
#include <cstdint>
#include <vector>

#include <QOpenGLFunctions_3_3_Core>

#include "app/view/model/scene/camera_model.h"
#include "app/view/model/scene/picture_composer.h"

namespace tandem {

/// The formats of a framebuffer. A copy of its depth must have the same. Colour is 8-bit RGBA.
struct FramebufferFormat {
  GLint depth = 0;    // internal format of the depth renderbuffer
  GLint samples = 0;  // samples of a pixel; 0: one, not multisampled
  bool operator==(const FramebufferFormat&) const = default;
};

/// A fixed body, as the static picture shows it.
struct StaticInstance {
  BodyInstance instance;
  std::uint64_t colouring = 0;  // number of its vertex colours; 0: one colour for the body
  bool operator==(const StaticInstance&) const = default;
};

/// All that the static picture depends on. Pictures of equal keys are equal.
struct StaticKey {
  Mat4 X_CW = Mat4::Identity();
  Mat4 projection = Mat4::Identity();
  QSize size;
  FramebufferFormat format;
  std::uint64_t meshes = 0;  // number of the upload that the bodies come from
  std::vector<StaticInstance> bodies;
  bool operator==(const StaticKey&) const = default;
};

/// The picture of the fixed bodies, with colour and depth in a framebuffer of its own. Each call
/// needs the renderer's context.
class StaticPicture {
 public:
  void Free(QOpenGLFunctions_3_3_Core& gl);
  /// Prepares the framebuffer for the picture of `key`, without any piece, and binds it.
  void Begin(QOpenGLFunctions_3_3_Core& gl, const StaticKey& key);
  /// Binds the framebuffer, so that further pieces are drawn.
  void Bind(QOpenGLFunctions_3_3_Core& gl) const;
  /// Copies colour and depth into `target`, which has the key's size and format, and binds
  /// `target`.
  void CopyTo(QOpenGLFunctions_3_3_Core& gl, GLuint target) const;

  const StaticKey& key() const { return key_; }
  std::size_t pieces() const { return pieces_; }  // pieces drawn, counted from the first
  void set_pieces(std::size_t pieces) { pieces_ = pieces; }

 private:
  void Allocate(QOpenGLFunctions_3_3_Core& gl);

  StaticKey key_;
  std::size_t pieces_ = 0;
  GLuint framebuffer_ = 0;
  GLuint colour_ = 0;
  GLuint depth_ = 0;
  GLbitfield copied_ = 0;
};

/// Returns the format of the framebuffer that is bound, which must have a renderbuffer for depth.
FramebufferFormat BoundFormat(QOpenGLFunctions_3_3_Core& gl);

}  // namespace tandem
