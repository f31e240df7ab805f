#include <cstdlib>

#include <gmock/gmock.h>

#include "engine/geometry/mesh_file.h"

int main(int argc, char** argv) {
  setenv("XDG_STATE_HOME", "/dev/null", 0);  // a test leaves nothing in a person's folders
  tandem::RunImportHelperIfAsked(argc, argv);
  ::testing::InitGoogleMock(&argc, argv);
  return RUN_ALL_TESTS();
}
