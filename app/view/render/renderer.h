#pragma once

#include <QOpenGLShaderProgram>
#include <QSize>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <vector>

#include <QOpenGLFunctions_3_3_Core>

#include "app/view/model/proximity/proximity_picture.h"
#include "app/view/model/scene/camera_model.h"
#include "app/view/model/scene/draw_pieces.h"
#include "app/view/model/scene/drawn_scene.h"
#include "app/view/model/scene/picture_composer.h"
#include "app/view/render/static_picture.h"
#include "app/view/render/surface_shader.h"
#include "app/view/render/voxel_cubes.h"

namespace tandem {

/// ms that a frame spends on fixed bodies while their picture is incomplete; short enough for a
/// window to follow the mouse
inline constexpr int kStaticPictureMs = 30;

/// Draws scenes with OpenGL 3.3 core into the framebuffer that is bound. Each call, the destructor
/// too, needs the same current context. State is left as QPainter needs it: no program, no vertex
/// array, no depth test, alpha at 1.
///
/// The fixed bodies are drawn once for each view, into a StaticPicture. A frame copies its colour
/// and depth, and draws moving bodies over it. The framebuffer has 8-bit RGBA and a renderbuffer
/// for depth. Paper section 7.
class Renderer {
 public:
  /// Returns whether there is time for a further piece of the static picture.
  using MayGoOn = std::function<bool()>;

  ~Renderer();

  /// Called once, before all else. An error says what OpenGL lacks.
  std::optional<Error> Initialize();
  /// Replaces the meshes by those of a scene.
  void Upload(const std::vector<DrawnBody>& bodies);
  /// Shows the vertex colours of proximity and the near static voxels; null: neither.
  void ShowProximity(const ProximityPicture* proximity);
  /// Draws background, fixed bodies with their edges, solid moving bodies with theirs, and ghosts
  /// from back to front. `size` is in pixels of the framebuffer. After each piece's worth of the
  /// static picture it asks `may_go_on`, and a later call continues there. Null: it draws the whole
  /// static picture. Returns whether the picture has every fixed body whole.
  bool Draw(const CameraModel& camera, const DrawList& list, const QSize& size,
            const MayGoOn& may_go_on = {});
  /// Returns the number of static pictures begun, one for each change of key.
  std::uint64_t static_pictures() const { return static_pictures_; }

 private:
  struct BodyBuffers {
    GLuint vertex_array = 0;
    GLuint vertices = 0;
    GLuint triangles = 0;
    GLuint uncut_array = 0;
    GLuint uncut_triangles = 0;
    GLuint edges_array = 0;
    GLuint edges = 0;
    GLuint colours = 0;           // vertex colours' buffer; 0: none yet
    std::uint64_t colouring = 0;  // number of the colours shown; 0: none
    bool fixed = false;
    std::size_t vertex_count = 0;
    GLsizei triangle_indices = 0;
    GLsizei uncut_indices = 0;  // 0: no triangle was cut for vertex colours
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
  StaticKey KeyOf(const CameraModel& camera, const DrawList& list, const QSize& size);
  bool DrawStatic(StaticPicture& picture, const MayGoOn& may_go_on);
  void DrawMoving(const CameraModel& camera, const DrawList& list);
  void DrawGhosts(const CameraModel& camera, const DrawList& list);
  void SetSolid(const BodyInstance& solid, const Mat4& X_CW);
  void SetEdge(const BodyInstance& solid, const Mat4& X_CW);
  void DrawTriangles(const BodyBuffers& body);
  void DrawEdges(const BodyBuffers& body);
  void DrawNearVoxels(const Mat4& X_CW);
  void DrawGhost(const BodyBuffers& body, const BodyInstance& ghost);

  QOpenGLFunctions_3_3_Core* gl_ = nullptr;  // functions of the context
  std::unique_ptr<QOpenGLShaderProgram> shader_;
  Uniforms at_;
  GLuint empty_array_ = 0;
  std::vector<BodyBuffers> bodies_;
  std::vector<DrawPiece> pieces_;           // pieces of the fixed bodies
  std::map<GLint, StaticPicture> statics_;  // static picture for each number of samples a pixel
  std::uint64_t static_pictures_ = 0;
  std::uint64_t uploads_ = 0;
  std::uint64_t colourings_ = 0;
  VoxelCubes near_voxels_;
  float cube_side_ = 0;  // m
};

}  // namespace tandem
