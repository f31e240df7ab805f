#pragma once

#include <filesystem>
#include <string>

#include <gtest/gtest.h>

#include "engine/geometry/import/mesh_file.h"
#include "tests/engine/geometry/import/mesh_file_samples.h"

namespace tandem::testing {

inline std::string WhyNot(const Result<TriangleMesh>& mesh) {
  return mesh ? "it is a mesh" : mesh.error().what;
}

/// Writes mesh files to a folder of its own.
class MeshFile : public ::testing::Test {
 protected:
  std::filesystem::path Write(const std::string& name, const std::string& content) {
    return folder_.Write(name, content);
  }
  TempFolder folder_;
};

}  // namespace tandem::testing
