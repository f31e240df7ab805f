#pragma once

#include <array>
#include <vector>

#include <QOpenGLFunctions_3_3_Core>

namespace tandem {

/// Draws many equal cubes at once. Attribute 0 has the corners of a cube, attribute 3 the centres.
/// Each call needs the renderer's context.
class VoxelCubes {
 public:
  void Make(QOpenGLFunctions_3_3_Core& gl);
  void Free(QOpenGLFunctions_3_3_Core& gl);
  /// Sets the cubes' centres.
  void Place(QOpenGLFunctions_3_3_Core& gl, const std::vector<std::array<float, 3>>& centres);
  /// Draws the cubes with the shader that is bound.
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
