#include <QApplication>
#include <QSurfaceFormat>
#include <cstdlib>

#include <gmock/gmock.h>

#include "app/view/render/gl_check.h"

// Tests of the window and the renderer; need a display.
int main(int argc, char** argv) {
  setenv("XDG_STATE_HOME", "/dev/null", 0);  // a test leaves nothing in a person's folders
  ::testing::InitGoogleMock(&argc, argv);
  QSurfaceFormat::setDefaultFormat(tandem::RendererFormat());
  const QApplication app(argc, argv);
  return RUN_ALL_TESTS();
}
