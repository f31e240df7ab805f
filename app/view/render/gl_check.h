#pragma once

#include <QSurfaceFormat>
#include <string>

#include "engine/base/result.h"

namespace tandem {

/// Returns the format that the renderer needs: OpenGL 3.3 core with 24 bits of depth. It must be
/// the default format before the QApplication is made.
QSurfaceFormat RendererFormat();

/// The OpenGL implementation in use.
struct GlInfo {
  std::string renderer;  // "llvmpipe (LLVM 15.0.6, 256 bits)"
  bool software =
      false;  // drawn by the processor: a frame takes long and uses cores that others need
  std::string version{};  // "OpenGL 4.5"
};

/// Tries whether a context of RendererFormat() can be made and can draw into a framebuffer, without
/// a window. The error says what is missing and what a person can do. Needs a QGuiApplication.
Result<GlInfo> CheckGl();

}  // namespace tandem
