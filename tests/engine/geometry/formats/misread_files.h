#pragma once

#include <string>

#include <gmock/gmock.h>

#include "engine/geometry/import/mesh_file.h"
#include "engine/geometry/mesh/mass_properties.h"
#include "tests/engine/geometry/import/mesh_file_samples.h"

namespace tandem::testing {

inline std::string With(std::string text, const std::string& old, const std::string& words) {
  const std::size_t at = text.find(old);
  EXPECT_NE(at, std::string::npos) << old;
  return at == std::string::npos ? text : text.replace(at, old.size(), words);
}

/// Reads files that a test makes, of known volume or to be refused.
class MisreadFiles : public ::testing::Test {
 protected:
  Result<TriangleMesh> Read(const std::string& name, const std::string& content,
                            const ImportOptions& options = {}) {
    return ImportMesh(folder_.Write(name, content), options);
  }
  void ExpectVolume(double volume, const std::string& name, const std::string& content,
                    const ImportOptions& options = {}) {
    const Result<TriangleMesh> mesh = Read(name, content, options);
    ASSERT_TRUE(mesh) << mesh.error().what;
    EXPECT_NEAR(ComputeMassProperties(*mesh).volume, volume, 1e-6 * volume) << name;
  }
  void ExpectRefused(const std::string& why, const std::string& name, const std::string& content,
                     const ImportOptions& options = {}) {
    const Result<TriangleMesh> mesh = Read(name, content, options);
    ASSERT_FALSE(mesh) << name;
    EXPECT_THAT(mesh.error().what, ::testing::HasSubstr(why));
  }
  TempFolder folder_;
};

/// A prism on an L of area 3, 2 high, with concave faces of six corners: a volume of 6.
inline const std::string kOffPrism =
    "12 8 18\n0 0 0\n2 0 0\n2 1 0\n1 1 0\n1 2 0\n0 2 0\n0 0 2\n2 0 2\n2 1 2\n1 1 2\n1 2 2\n0 2 2\n"
    "6 5 4 3 2 1 0\n6 6 7 8 9 10 11\n4 0 1 7 6\n4 1 2 8 7\n4 2 3 9 8\n4 3 4 10 9\n4 4 5 11 10\n"
    "4 5 0 6 11\n";

/// Returns a 3MF model that may use the production extension.
inline std::string ThreeMfModel(const std::string& inside, const std::string& unit = "millimeter",
                                const std::string& needs = "p", const std::string& spaces = "") {
  return "<?xml version=\"1.0\"?><model unit=\"" + unit +
         "\" xmlns=\"http://schemas.microsoft.com/3dmanufacturing/core/2015/02\" "
         "xmlns:p=\"http://schemas.microsoft.com/3dmanufacturing/production/2015/06\" " +
         spaces + " requiredextensions=\"" + needs + "\">" + inside + "</model>";
}

}  // namespace tandem::testing
