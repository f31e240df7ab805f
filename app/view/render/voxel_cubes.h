#pragma once

#include <array>
#include <vector>

#include <QOpenGLFunctions_3_3_Core>

namespace tandem {

/// Many equal cubes, drawn at once: the corners of one as attribute 0, where each stands as
/// attribute 3. Every call needs the renderer's context.
class VoxelCubes {
 public:
  void Make(QOpenGLFunctions_3_3_Core& gl);
  void Free(QOpenGLFunctions_3_3_Core& gl);
  /// Where they stand from now on.
  void Place(QOpenGLFunctions_3_3_Core& gl, const std::vector<std::array<float, 3>>& centres);
  /// With whatever shader is bound.
  void Draw(QOpenGLFunctions_3_3_Core& gl) const;

  bool empty() const { return count_ == 0; }

 private:
  GLuint array_ = 0;
  GLuint corners_ = 0;
  GLuint triangles_ = 0;
  GLuint centres_ = 0;
  GLsizei count_ = 0;
};

}  // namespace tandem
