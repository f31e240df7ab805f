#include <QCoreApplication>
#include <cstdlib>

#include <gmock/gmock.h>

#include "tests/support/environment.h"

// Tests of Qt's models: an event loop, and no window.
int main(int argc, char** argv) {
  tandem::testing::KeepOutOfPersonsFolders();
  ::testing::InitGoogleMock(&argc, argv);
  const QCoreApplication app(argc, argv);
  return RUN_ALL_TESTS();
}
