#pragma once

#include <QSurfaceFormat>
#include <string>

#include "engine/base/result.h"

namespace tandem {

/// What the renderer asks of OpenGL: 3.3 core with 24 bits of depth. Its default format must be set
/// before the QApplication is made.
QSurfaceFormat RendererFormat();

/// The OpenGL that a program has got.
struct GlInfo {
  std::string renderer;  // "llvmpipe (LLVM 15.0.6, 256 bits)"
  bool software =
      false;  // drawn by the processor: a frame takes long, and its cores are others' too
};

/// Tries whether a context of RendererFormat() can be made, and can draw into a framebuffer,
/// without touching a window. The error says what is missing and what a person can do. Needs a
/// QGuiApplication.
Result<GlInfo> CheckGl();

}  // namespace tandem
