#include <QCoreApplication>
#include <cstdlib>

#include <gmock/gmock.h>

// Tests of Qt's models: an event loop, and no window.
int main(int argc, char** argv) {
  setenv("XDG_STATE_HOME", "/dev/null", 0);  // a test leaves nothing in a person's folders
  ::testing::InitGoogleMock(&argc, argv);
  const QCoreApplication app(argc, argv);
  return RUN_ALL_TESTS();
}
