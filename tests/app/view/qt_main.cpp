#include <QCoreApplication>

#include <gmock/gmock.h>

// Tests of Qt's models: an event loop, and no window.
int main(int argc, char** argv) {
  ::testing::InitGoogleMock(&argc, argv);
  const QCoreApplication app(argc, argv);
  return RUN_ALL_TESTS();
}
