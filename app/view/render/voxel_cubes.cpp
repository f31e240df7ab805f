#include "app/view/render/voxel_cubes.h"

namespace tandem {

void VoxelCubes::Make(QOpenGLFunctions_3_3_Core& gl) {
  std::array<std::array<float, 3>, 8> corners{};
  for (std::size_t i = 0; i < 8; ++i) {
    corners[i] = {(i & 1U) != 0 ? 0.5F : -0.5F, (i & 2U) != 0 ? 0.5F : -0.5F,
                  (i & 4U) != 0 ? 0.5F : -0.5F};
  }
  constexpr std::array<std::uint8_t, 36> kTriangles{0, 2, 3, 0, 3, 1, 4, 5, 7, 4, 7, 6,
                                                    0, 1, 5, 0, 5, 4, 2, 6, 7, 2, 7, 3,
                                                    0, 4, 6, 0, 6, 2, 1, 3, 7, 1, 7, 5};
  gl.glGenVertexArrays(1, &array_);
  for (GLuint* buffer : {&corners_, &triangles_, &centres_}) {
    gl.glGenBuffers(1, buffer);
  }
  gl.glBindVertexArray(array_);
  gl.glBindBuffer(GL_ELEMENT_ARRAY_BUFFER, triangles_);
  gl.glBufferData(GL_ELEMENT_ARRAY_BUFFER, sizeof kTriangles, kTriangles.data(), GL_STATIC_DRAW);
  gl.glBindBuffer(GL_ARRAY_BUFFER, corners_);
  gl.glBufferData(GL_ARRAY_BUFFER, sizeof corners, corners.data(), GL_STATIC_DRAW);
  gl.glEnableVertexAttribArray(0);
  gl.glVertexAttribPointer(0, 3, GL_FLOAT, GL_FALSE, 0, nullptr);
  gl.glBindBuffer(GL_ARRAY_BUFFER, centres_);
  gl.glEnableVertexAttribArray(3);
  gl.glVertexAttribPointer(3, 3, GL_FLOAT, GL_FALSE, 0, nullptr);
  gl.glVertexAttribDivisor(3, 1);
  gl.glBindVertexArray(0);
  gl.glBindBuffer(GL_ARRAY_BUFFER, 0);
}

void VoxelCubes::Free(QOpenGLFunctions_3_3_Core& gl) {
  gl.glDeleteVertexArrays(1, &array_);
  for (GLuint* buffer : {&corners_, &triangles_, &centres_}) gl.glDeleteBuffers(1, buffer);
}

void VoxelCubes::Place(QOpenGLFunctions_3_3_Core& gl,
                       const std::vector<std::array<float, 3>>& centres) {
  count_ = static_cast<GLsizei>(centres.size());
  gl.glBindBuffer(GL_ARRAY_BUFFER, centres_);
  gl.glBufferData(GL_ARRAY_BUFFER, static_cast<GLsizeiptr>(centres.size() * sizeof centres[0]),
                  centres.data(), GL_STREAM_DRAW);
  gl.glBindBuffer(GL_ARRAY_BUFFER, 0);
}

void VoxelCubes::Draw(QOpenGLFunctions_3_3_Core& gl) const {
  gl.glBindVertexArray(array_);
  gl.glEnable(GL_CULL_FACE);
  gl.glDrawElementsInstanced(GL_TRIANGLES, 36, GL_UNSIGNED_BYTE, nullptr, count_);
  gl.glDisable(GL_CULL_FACE);
}

}  // namespace tandem
