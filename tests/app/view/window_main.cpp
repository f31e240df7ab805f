#include <QApplication>
#include <QSurfaceFormat>

#include <gmock/gmock.h>

#include "app/view/render/gl_check.h"

// Tests of the window and the renderer; need a display.
int main(int argc, char** argv) {
  ::testing::InitGoogleMock(&argc, argv);
  QSurfaceFormat::setDefaultFormat(tandem::RendererFormat());
  const QApplication app(argc, argv);
  return RUN_ALL_TESTS();
}
