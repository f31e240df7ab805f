#include <cstdlib>

#include <gmock/gmock.h>

#include "engine/geometry/import/mesh_file.h"
#include "tests/support/environment.h"

int main(int argc, char** argv) {
  tandem::testing::KeepOutOfPersonsFolders();
  tandem::RunImportHelperIfAsked(argc, argv);
  ::testing::InitGoogleMock(&argc, argv);
  return RUN_ALL_TESTS();
}
