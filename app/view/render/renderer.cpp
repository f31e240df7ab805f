#include "app/view/render/renderer.h"

#include <QOpenGLContext>
#include <QOpenGLVersionFunctionsFactory>
#include <algorithm>
#include <cstddef>

namespace tandem {

namespace {

constexpr Colour kBackgroundBelow{0.86F, 0.88F, 0.90F};
constexpr Colour kBackgroundAbove{0.97F, 0.975F, 0.98F};
constexpr float kEdgeShade = 0.30F;  // factor on the body's colour
constexpr float kEdgeOpacity = 0.75F;
constexpr float kCubeShare = 0.86F;  // share of a voxel's side, so that neighbours stay distinct

Mat4 MatrixOf(const Pose& X) {
  Mat4 m = Mat4::Identity();
  m.topLeftCorner<3, 3>() = X.q.toRotationMatrix();
  m.topRightCorner<3, 1>() = X.p;
  return m;
}

}  // namespace

Renderer::~Renderer() {
  if (gl_ == nullptr) return;
  Free();
  gl_->glDeleteVertexArrays(1, &empty_array_);
  near_voxels_.Free(*gl_);
  for (auto& [samples, picture] : statics_) picture.Free(*gl_);
}

std::optional<Error> Renderer::Initialize() {
  QOpenGLContext* context = QOpenGLContext::currentContext();
  if (context == nullptr) return Error{"There is no current OpenGL context."};
  gl_ = QOpenGLVersionFunctionsFactory::get<QOpenGLFunctions_3_3_Core>(context);
  if (gl_ == nullptr) return Error{"The OpenGL context has no 3.3 core functions."};
  shader_ = std::make_unique<QOpenGLShaderProgram>();
  if (!shader_->addShaderFromSourceCode(QOpenGLShader::Vertex, kVertexShader) ||
      !shader_->addShaderFromSourceCode(QOpenGLShader::Fragment, kFragmentShader) ||
      !shader_->link()) {
    return Error{"The OpenGL driver did not take the shader: " + shader_->log().toStdString()};
  }
  at_ = {shader_->uniformLocation("mode"),
         shader_->uniformLocation("colour"),
         shader_->uniformLocation("colour_above"),
         shader_->uniformLocation("up_C"),
         shader_->uniformLocation("camera_from_model"),
         shader_->uniformLocation("projection"),
         shader_->uniformLocation("cube")};
  gl_->glGenVertexArrays(1, &empty_array_);
  near_voxels_.Make(*gl_);
  return std::nullopt;
}

void Renderer::Free() {
  for (const BodyBuffers& body : bodies_) {
    gl_->glDeleteVertexArrays(1, &body.vertex_array);
    gl_->glDeleteVertexArrays(1, &body.edges_array);
    gl_->glDeleteBuffers(1, &body.vertices);
    gl_->glDeleteBuffers(1, &body.triangles);
    gl_->glDeleteVertexArrays(1, &body.uncut_array);
    gl_->glDeleteBuffers(1, &body.uncut_triangles);
    gl_->glDeleteBuffers(1, &body.edges);
    gl_->glDeleteBuffers(1, &body.colours);
  }
  bodies_.clear();
}

GLuint Renderer::VertexArrayOver(GLuint vertices, GLuint indices) {
  GLuint array = 0;
  gl_->glGenVertexArrays(1, &array);
  gl_->glBindVertexArray(array);
  gl_->glBindBuffer(GL_ARRAY_BUFFER, vertices);
  gl_->glBindBuffer(GL_ELEMENT_ARRAY_BUFFER, indices);
  constexpr GLsizei kStride = sizeof(ShadedMesh::Vertex);
  gl_->glEnableVertexAttribArray(0);
  gl_->glVertexAttribPointer(0, 3, GL_FLOAT, GL_FALSE, kStride, nullptr);
  gl_->glEnableVertexAttribArray(1);
  gl_->glVertexAttribPointer(1, 3, GL_FLOAT, GL_FALSE, kStride,
                             reinterpret_cast<const void*>(offsetof(ShadedMesh::Vertex, n)));
  gl_->glBindVertexArray(0);
  return array;
}

void Renderer::Upload(const std::vector<DrawnBody>& bodies) {
  Free();
  ++uploads_;
  pieces_ = PiecesOfFixedBodies(bodies);
  const auto fill = [&](GLenum target, const auto& values) {
    GLuint buffer = 0;
    gl_->glGenBuffers(1, &buffer);
    gl_->glBindBuffer(target, buffer);
    gl_->glBufferData(target, static_cast<GLsizeiptr>(values.size() * sizeof(values[0])),
                      values.data(), GL_STATIC_DRAW);
    return buffer;
  };
  gl_->glBindVertexArray(empty_array_);  // index buffers need an array that is bound
  for (const DrawnBody& body : bodies) {
    BodyBuffers buffers;
    gl_->glBindVertexArray(empty_array_);
    buffers.vertices = fill(GL_ARRAY_BUFFER, body.mesh.vertices);
    buffers.triangles = fill(GL_ELEMENT_ARRAY_BUFFER, TrianglesInDrawingOrder(body.mesh));
    buffers.uncut_triangles = fill(GL_ELEMENT_ARRAY_BUFFER, body.mesh.uncut_triangles);
    buffers.edges = fill(GL_ELEMENT_ARRAY_BUFFER, body.mesh.edges);
    buffers.vertex_array = VertexArrayOver(buffers.vertices, buffers.triangles);
    buffers.uncut_array = VertexArrayOver(buffers.vertices, buffers.uncut_triangles);
    buffers.uncut_indices = static_cast<GLsizei>(body.mesh.uncut_triangles.size());
    buffers.edges_array = VertexArrayOver(buffers.vertices, buffers.edges);
    buffers.triangle_indices = static_cast<GLsizei>(body.mesh.triangles.size());
    buffers.edge_indices = static_cast<GLsizei>(body.mesh.edges.size());
    buffers.fixed = body.look.fixed;
    buffers.vertex_count = body.mesh.vertices.size();
    if (!body.bounds_W.empty()) buffers.centre_W = body.bounds_W.centre();
    bodies_.push_back(buffers);
  }
  gl_->glBindVertexArray(0);
  gl_->glBindBuffer(GL_ARRAY_BUFFER, 0);
}

void Renderer::ShowProximity(const ProximityPicture* proximity) {
  for (BodyBuffers& body : bodies_) body.colouring = 0;
  if (proximity == nullptr) {
    near_voxels_.Place(*gl_, {});
    return;
  }
  for (const VertexColours& colours : proximity->bodies) {
    if (colours.body >= bodies_.size()) continue;
    BodyBuffers& body = bodies_[colours.body];
    if (colours.rgba.size() != body.vertex_count) continue;  // colours of the previous scene
    const bool first = body.colours == 0;
    if (first) gl_->glGenBuffers(1, &body.colours);
    gl_->glBindBuffer(GL_ARRAY_BUFFER, body.colours);
    gl_->glBufferData(GL_ARRAY_BUFFER, static_cast<GLsizeiptr>(4 * colours.rgba.size()),
                      colours.rgba.data(), GL_STREAM_DRAW);
    if (first) {
      gl_->glBindVertexArray(body.vertex_array);
      gl_->glEnableVertexAttribArray(2);
      gl_->glVertexAttribPointer(2, 4, GL_UNSIGNED_BYTE, GL_TRUE, 0, nullptr);
      gl_->glBindVertexArray(0);
    }
    body.colouring = ++colourings_;
  }
  near_voxels_.Place(*gl_, proximity->shadow_W);
  cube_side_ = kCubeShare * proximity->voxel_size;
}

void Renderer::SetMode(ShaderMode mode) {
  gl_->glUniform1i(at_.mode, static_cast<int>(mode));
}

void Renderer::SetColour(const Colour& colour, float alpha) {
  gl_->glUniform4f(at_.colour, colour[0], colour[1], colour[2], alpha);
}

void Renderer::SetPose(const Mat4& X_CW, const Pose& X_W) {
  const Eigen::Matrix4f m = (X_CW * MatrixOf(X_W)).cast<float>();
  gl_->glUniformMatrix4fv(at_.camera_from_model, 1, GL_FALSE, m.data());
}

void Renderer::DrawBackground() {
  gl_->glDepthMask(GL_FALSE);
  gl_->glDisable(GL_DEPTH_TEST);
  SetMode(ShaderMode::kBackground);
  SetColour(kBackgroundBelow, 1.0F);
  gl_->glUniform3f(at_.colour_above, kBackgroundAbove[0], kBackgroundAbove[1], kBackgroundAbove[2]);
  gl_->glBindVertexArray(empty_array_);
  gl_->glDrawArrays(GL_TRIANGLES, 0, 3);
  gl_->glEnable(GL_DEPTH_TEST);
  gl_->glDepthMask(GL_TRUE);
}

void Renderer::DrawTriangles(const BodyBuffers& body) {
  const bool uncut = body.colouring == 0 && body.uncut_indices > 0;
  gl_->glBindVertexArray(uncut ? body.uncut_array : body.vertex_array);
  gl_->glDrawElements(GL_TRIANGLES, uncut ? body.uncut_indices : body.triangle_indices,
                      GL_UNSIGNED_INT, nullptr);
}

void Renderer::DrawEdges(const BodyBuffers& body) {
  gl_->glBindVertexArray(body.edges_array);
  gl_->glDrawElements(GL_LINES, body.edge_indices, GL_UNSIGNED_INT, nullptr);
}

void Renderer::DrawNearVoxels(const Mat4& X_CW) {
  if (near_voxels_.empty()) return;
  SetPose(X_CW, Pose{});
  SetColour(kNearVoxelColour, 1.0F);
  SetMode(ShaderMode::kCubes);
  gl_->glUniform1f(at_.cube, cube_side_);
  near_voxels_.Draw(*gl_);
}

void Renderer::DrawGhost(const BodyBuffers& body, const BodyInstance& ghost) {
  // depth first, then only the nearest faces: no inner face shows through, however concave the body
  gl_->glPolygonOffset(
      2.0F, 2.0F);  // behind a solid instance at the same place, which then hides the ghost whole
  gl_->glColorMask(GL_FALSE, GL_FALSE, GL_FALSE, GL_FALSE);
  SetMode(ShaderMode::kLit);
  DrawTriangles(body);
  gl_->glColorMask(GL_TRUE, GL_TRUE, GL_TRUE, GL_TRUE);
  gl_->glDepthMask(GL_FALSE);
  SetColour(ghost.colour, ghost.opacity);
  DrawTriangles(body);
  SetMode(ShaderMode::kPlain);
  DrawEdges(body);
  gl_->glDepthMask(GL_TRUE);
}

void Renderer::SetSolid(const BodyInstance& solid, const Mat4& X_CW) {
  SetPose(X_CW, solid.X_W);
  SetColour(solid.colour, 1.0F);
  SetMode(bodies_[solid.body].colouring != 0 ? ShaderMode::kLitByVertex : ShaderMode::kLit);
}

void Renderer::SetEdge(const BodyInstance& solid, const Mat4& X_CW) {
  SetPose(X_CW, solid.X_W);
  const Colour& c = solid.colour;
  SetColour({kEdgeShade * c[0], kEdgeShade * c[1], kEdgeShade * c[2]}, kEdgeOpacity);
  SetMode(ShaderMode::kPlain);
}

StaticKey Renderer::KeyOf(const CameraModel& camera, const DrawList& list, const QSize& size) {
  StaticKey key{camera.ViewFromWorld(), camera.Projection(), size, BoundFormat(*gl_), uploads_, {}};
  for (const BodyInstance& solid : list.solids) {
    if (solid.body >= bodies_.size() || !bodies_[solid.body].fixed) continue;
    key.bodies.push_back({solid, bodies_[solid.body].colouring});
  }
  return key;
}

bool Renderer::DrawStatic(StaticPicture& picture, const MayGoOn& may_go_on) {
  const StaticKey& key = picture.key();
  std::vector<const BodyInstance*> solids(bodies_.size(), nullptr);
  for (const StaticInstance& one : key.bodies) solids[one.instance.body] = &one.instance;
  std::size_t drawn = picture.pieces();
  std::size_t indices = 0;  // indices drawn in this call
  for (; drawn < pieces_.size(); ++drawn) {
    const DrawPiece& piece = pieces_[drawn];
    const BodyInstance* solid = solids[piece.body];
    if (solid == nullptr) continue;
    if (may_go_on && indices >= 3 * kPieceTriangles) {
      indices = 0;
      gl_->glFinish();  // makes the time of the drawing visible to may_go_on()
      if (!may_go_on()) break;
    }
    indices += piece.count;
    const BodyBuffers& body = bodies_[piece.body];
    gl_->glBindVertexArray(piece.edges ? body.edges_array : body.vertex_array);
    if (piece.edges) {
      SetEdge(*solid, key.X_CW);
      gl_->glEnable(GL_BLEND);
    } else {
      SetSolid(*solid, key.X_CW);
    }
    gl_->glDrawElements(piece.edges ? GL_LINES : GL_TRIANGLES, static_cast<GLsizei>(piece.count),
                        GL_UNSIGNED_INT,
                        reinterpret_cast<const void*>(piece.first * sizeof(std::uint32_t)));
  }
  gl_->glDisable(GL_BLEND);
  picture.set_pieces(drawn);
  return drawn == pieces_.size();
}

void Renderer::DrawMoving(const CameraModel& camera, const DrawList& list) {
  const Mat4 X_CW = camera.ViewFromWorld();
  std::vector<BodyInstance> solids;
  for (const BodyInstance& solid : list.solids) {
    if (solid.body < bodies_.size() && !bodies_[solid.body].fixed) solids.push_back(solid);
  }
  for (const BodyInstance& solid : solids) {
    SetSolid(solid, X_CW);
    DrawTriangles(bodies_[solid.body]);
  }
  DrawNearVoxels(X_CW);
  gl_->glEnable(GL_BLEND);
  for (const BodyInstance& solid : solids) {
    SetEdge(solid, X_CW);
    DrawEdges(bodies_[solid.body]);
  }
}

void Renderer::DrawGhosts(const CameraModel& camera, const DrawList& list) {
  std::vector<BodyInstance> ghosts;
  for (const BodyInstance& ghost : list.ghosts) {
    if (ghost.body < bodies_.size()) ghosts.push_back(ghost);
  }
  const Vec3 eye_W = camera.eye_W();
  const auto from_eye = [&](const BodyInstance& ghost) {
    return (ghost.X_W * bodies_[ghost.body].centre_W - eye_W).squaredNorm();
  };
  std::stable_sort(ghosts.begin(), ghosts.end(), [&](const BodyInstance& a, const BodyInstance& b) {
    return from_eye(a) > from_eye(b);
  });
  for (const BodyInstance& ghost : ghosts) {
    SetPose(camera.ViewFromWorld(), ghost.X_W);
    DrawGhost(bodies_[ghost.body], ghost);
  }
}

bool Renderer::Draw(const CameraModel& camera, const DrawList& list, const QSize& size,
                    const MayGoOn& may_go_on) {
  GLint target = 0;
  gl_->glGetIntegerv(GL_DRAW_FRAMEBUFFER_BINDING, &target);
  gl_->glViewport(0, 0, size.width(), size.height());
  gl_->glDisable(GL_CULL_FACE);
  gl_->glDisable(GL_SCISSOR_TEST);
  gl_->glDisable(GL_BLEND);
  gl_->glEnable(GL_DEPTH_TEST);
  gl_->glDepthFunc(GL_LEQUAL);
  gl_->glDepthMask(GL_TRUE);
  // translucent bodies must not make the window translucent
  gl_->glBlendFuncSeparate(GL_SRC_ALPHA, GL_ONE_MINUS_SRC_ALPHA, GL_ZERO, GL_ONE);
  gl_->glEnable(GL_POLYGON_OFFSET_FILL);
  gl_->glPolygonOffset(1.0F, 1.0F);  // puts edges in front of their surfaces

  const StaticKey key = KeyOf(camera, list, size);
  shader_->bind();
  const Eigen::Matrix4f projection = key.projection.cast<float>();
  const Eigen::Vector3f up_C = key.X_CW.block<3, 1>(0, 2).cast<float>();
  gl_->glUniformMatrix4fv(at_.projection, 1, GL_FALSE, projection.data());
  gl_->glUniform3f(at_.up, up_C.x(), up_C.y(), up_C.z());

  StaticPicture& picture = statics_[key.format.samples];
  if (picture.key() == key) {
    picture.Bind(*gl_);
  } else {
    picture.Begin(*gl_, key);
    ++static_pictures_;
    DrawBackground();
  }
  const bool whole = DrawStatic(picture, may_go_on);
  picture.CopyTo(*gl_, static_cast<GLuint>(target));
  DrawMoving(camera, list);
  DrawGhosts(camera, list);

  gl_->glDisable(GL_POLYGON_OFFSET_FILL);
  gl_->glDisable(GL_BLEND);
  gl_->glDisable(GL_DEPTH_TEST);
  gl_->glBindVertexArray(0);
  shader_->release();
  return whole;
}

}  // namespace tandem
