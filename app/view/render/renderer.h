#pragma once

#include <QOpenGLShaderProgram>
#include <QSize>
#include <memory>
#include <optional>
#include <vector>

#include <QOpenGLFunctions_3_3_Core>

#include "app/view/model/camera_model.h"
#include "app/view/model/drawn_scene.h"
#include "app/view/model/picture_composer.h"
#include "app/view/model/proximity_picture.h"
#include "app/view/render/surface_shader.h"
#include "app/view/render/voxel_cubes.h"

namespace tandem {

/// Draws scenes with OpenGL 3.3 core into whatever framebuffer is bound. Every call, the destructor
/// too, needs the same current context; state is left as QPainter wants it (no program, no vertex
/// array, no depth test), alpha at 1.
class Renderer {
 public:
  ~Renderer();

  /// Once, before anything else. An error says what OpenGL lacks.
  std::optional<Error> Initialize();
  /// Takes over the meshes of a scene in place of those before.
  void Upload(const std::vector<DrawnBody>& bodies);
  /// From now on solid bodies have these colours, and near static voxels stand out; null: neither.
  void ShowProximity(const ProximityPicture* proximity);
  /// Background, solid bodies with their edges, ghosts from back to front. `size` in pixels of the
  /// framebuffer.
  void Draw(const CameraModel& camera, const DrawList& list, const QSize& size);

 private:
  struct BodyBuffers {
    GLuint vertex_array = 0;
    GLuint vertices = 0;
    GLuint triangles = 0;
    GLuint edges_array = 0;
    GLuint edges = 0;
    GLuint colours = 0;  // of the vertices; 0: none yet
    bool coloured = false;
    std::size_t vertex_count = 0;
    GLsizei triangle_indices = 0;
    GLsizei edge_indices = 0;
    Vec3 centre_W = Vec3::Zero();
  };
  struct Uniforms {
    int mode = -1, colour = -1, colour_above = -1, up = -1, camera_from_model = -1, projection = -1,
        cube = -1;
  };

  void Free();
  GLuint VertexArrayOver(GLuint vertices, GLuint indices);
  void SetPose(const Mat4& X_CW, const Pose& X_W);
  void SetColour(const Colour& colour, float alpha);
  void SetMode(ShaderMode mode);
  void DrawBackground();
  void DrawTriangles(const BodyBuffers& body, ShaderMode mode);
  void DrawEdges(const BodyBuffers& body);
  void DrawNearVoxels(const Mat4& X_CW);
  void DrawGhost(const BodyBuffers& body, const BodyInstance& ghost);

  QOpenGLFunctions_3_3_Core* gl_ = nullptr;  // the context's
  std::unique_ptr<QOpenGLShaderProgram> shader_;
  Uniforms at_;
  GLuint empty_array_ = 0;
  std::vector<BodyBuffers> bodies_;
  VoxelCubes near_voxels_;
  float cube_side_ = 0;  // m
};

}  // namespace tandem
