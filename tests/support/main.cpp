#include <gmock/gmock.h>

#include "engine/geometry/mesh_file.h"

int main(int argc, char** argv) {
  tandem::RunImportHelperIfAsked(argc, argv);
  ::testing::InitGoogleMock(&argc, argv);
  return RUN_ALL_TESTS();
}
