#pragma once

namespace tandem {

/// Looks whether a window can open here, and writes to descriptor `to` one JSON object: the
/// platform of Qt, the version and renderer of OpenGL, whether the processor draws, and what is
/// wrong. What libraries say goes there too. Returns the exit code, kExitDisplay where no window or
/// no OpenGL is. Call it in place of making a QApplication.
int CheckDisplayFor(int to, int argc, char** argv);

}  // namespace tandem
