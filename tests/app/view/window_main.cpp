#include <QApplication>
#include <QSurfaceFormat>
#include <cstdlib>

#include <gmock/gmock.h>

#include "app/view/render/gl_check.h"
#include "tests/support/environment.h"

// Runs tests of the window and the renderer, which need a display.
int main(int argc, char** argv) {
  tandem::testing::KeepOutOfPersonsFolders();
  ::testing::InitGoogleMock(&argc, argv);
  QSurfaceFormat::setDefaultFormat(tandem::RendererFormat());
  const QApplication app(argc, argv);
  return RUN_ALL_TESTS();
}
