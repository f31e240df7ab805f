#include <QCoreApplication>
#include <cstdlib>

#include <gmock/gmock.h>

#include "tests/support/environment.h"

// Runs tests of Qt's models with an event loop and no window.
int main(int argc, char** argv) {
  tandem::testing::KeepOutOfPersonsFolders();
  ::testing::InitGoogleMock(&argc, argv);
  const QCoreApplication app(argc, argv);
  return RUN_ALL_TESTS();
}
