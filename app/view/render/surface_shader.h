#pragma once

namespace tandem {

/// The modes of the one shader. It draws lit surfaces, in one colour or in vertex colours, and
/// plain lines. It draws the background's gradient, from `colour` below to `colour_above`, and lit
/// cubes of side `cube` about each instance's centre. Camera frame C as in CameraModel.
enum class ShaderMode : int { kLit = 0, kPlain = 1, kBackground = 2, kLitByVertex = 3, kCubes = 4 };

inline constexpr const char* kVertexShader = R"(#version 330 core
layout(location = 0) in vec3 p;
layout(location = 1) in vec3 n;
layout(location = 2) in vec4 vertex_colour;
layout(location = 3) in vec3 centre;
uniform mat4 camera_from_model;
uniform mat4 projection;
uniform int mode;
uniform vec4 colour;
uniform float cube;
out vec3 p_C;
out vec3 n_C;
out vec4 own_colour;
void main() {
  own_colour = mode == 3 ? vertex_colour : colour;
  if (mode == 2) {  // one triangle over the whole picture
    gl_Position = vec4(gl_VertexID == 1 ? 3.0 : -1.0, gl_VertexID == 2 ? 3.0 : -1.0, 1.0, 1.0);
    p_C = gl_Position.xyz;
    n_C = vec3(0.0);
    return;
  }
  vec4 at_C = camera_from_model * vec4(mode == 4 ? centre + cube * p : p, 1.0);
  p_C = at_C.xyz;
  n_C = mat3(camera_from_model) * n;
  gl_Position = projection * at_C;
}
)";

// The key light comes over the viewer's left shoulder, a weak fill light from the lower right.
// Surfaces that face up are a little brighter, and surfaces at grazing angles a little darker, so
// that hollows look hollow.
inline constexpr const char* kFragmentShader = R"(#version 330 core
in vec3 p_C;
in vec3 n_C;
in vec4 own_colour;
uniform int mode;
uniform vec4 colour;
uniform vec3 colour_above;
uniform vec3 up_C;
out vec4 pixel;
const vec3 key = normalize(vec3(-0.40, 0.55, 0.85));
const vec3 fill = normalize(vec3(0.90, 0.05, 0.40));
void main() {
  if (mode == 1) {
    pixel = colour;
    return;
  }
  if (mode == 2) {
    pixel = vec4(mix(colour.rgb, colour_above, clamp(0.5 + 0.5 * p_C.y, 0.0, 1.0)), 1.0);
    return;
  }
  vec3 eye = normalize(-p_C);
  vec3 n = normalize(gl_FrontFacing ? n_C : -n_C);
  if (mode == 4) {  // flat faces
    n = normalize(cross(dFdx(p_C), dFdy(p_C)));
  }
  float sky = 0.5 + 0.5 * dot(n, up_C);
  float facing = clamp(dot(n, eye), 0.0, 1.0);
  float light = 0.34 + 0.20 * sky + 0.46 * max(dot(n, key), 0.0) + 0.22 * max(dot(n, fill), 0.0);
  light *= 0.82 + 0.18 * facing;
  float shine = 0.14 * pow(max(dot(n, normalize(key + eye)), 0.0), 32.0);
  pixel = vec4(min(own_colour.rgb * light * 1.10 + shine, 1.0), own_colour.a);
}
)";

}  // namespace tandem
