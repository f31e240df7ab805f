#include "app/view/render/gl_check.h"

#include <QGuiApplication>
#include <QOffscreenSurface>
#include <QOpenGLContext>
#include <QOpenGLFramebufferObject>
#include <QOpenGLFunctions>
#include <algorithm>
#include <array>

namespace tandem {

namespace {

bool IsSoftware(const std::string& renderer) {
  constexpr std::array<const char*, 5> kNames{"llvmpipe", "softpipe", "SwiftShader", "swrast",
                                              "Software"};
  return std::any_of(kNames.begin(), kNames.end(), [&](const char* name) {
    return renderer.find(name) != std::string::npos;
  });
}

Error NoContext() {
  const std::string platform = QGuiApplication::platformName().toStdString();
  if (platform == "offscreen" || platform == "minimal") {
    return {"Qt's platform \"" + platform +
            "\" has no OpenGL. Unset QT_QPA_PLATFORM and give the program a display; without one, "
            "run it under xvfb-run (package xvfb)."};
  }
  return {
      "No OpenGL 3.3 context could be made. Is a driver installed? Mesa's (package "
      "libgl1-mesa-dri) draws on any machine; over ssh -X, start the program under xvfb-run or on "
      "the machine's own display."};
}

}  // namespace

QSurfaceFormat RendererFormat() {
  QSurfaceFormat format;
  format.setRenderableType(QSurfaceFormat::OpenGL);
  format.setVersion(3, 3);
  format.setProfile(QSurfaceFormat::CoreProfile);
  format.setDepthBufferSize(24);
  format.setSwapInterval(1);
  return format;
}

Result<GlInfo> CheckGl() {
  // the offscreen platform borrows GLX from a display that it then cannot draw to
  if (QGuiApplication::platformName() == QStringLiteral("offscreen")) return NoContext();
  QOpenGLContext context;
  context.setFormat(RendererFormat());
  if (!context.create()) return NoContext();
  QOffscreenSurface surface;
  surface.setFormat(context.format());
  surface.create();
  if (!surface.isValid() || !context.makeCurrent(&surface)) return NoContext();

  const QSurfaceFormat got = context.format();
  const char* renderer =
      reinterpret_cast<const char*>(context.functions()->glGetString(GL_RENDERER));
  const std::string name = renderer != nullptr ? renderer : "an unknown renderer";
  const bool draws = QOpenGLFramebufferObject(16, 16, QOpenGLFramebufferObject::Depth).isValid();
  context.doneCurrent();
  if (std::pair(got.majorVersion(), got.minorVersion()) < std::pair(3, 3)) {
    return Error{"OpenGL 3.3 is needed, and " + name + " has " +
                 std::to_string(got.majorVersion()) + "." + std::to_string(got.minorVersion()) +
                 ". With LIBGL_ALWAYS_SOFTWARE=1 Mesa draws on the processor instead."};
  }
  if (!draws) return Error{"The OpenGL of " + name + " cannot draw into a framebuffer."};
  const std::string version =
      "OpenGL " + std::to_string(got.majorVersion()) + "." + std::to_string(got.minorVersion());
  return GlInfo{name, IsSoftware(name), version};
}

}  // namespace tandem
