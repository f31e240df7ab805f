#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "engine/base/spatial.h"
#include "engine/base/text/json_reader.h"
#include "engine/geometry/formats/gltf/gltf_numbers.h"
#include "engine/geometry/formats/raw_mesh.h"
#include "engine/geometry/formats/remark_list.h"

namespace tandem {

/// A primitive of a glTF mesh in its rest pose, in the mesh's own frame.
struct GltfPrimitive {
  std::vector<Vec3> points;
  std::vector<TriangleMesh::Triangle> triangles;
  std::size_t stated = 0;  // triangles that the file states
  /// For skins, by point: joints and their weights.
  std::vector<std::vector<std::pair<std::uint32_t, double>>> joints;
};

/// Reads primitives: strips and fans, morph targets with their default weights, integers of
/// KHR_mesh_quantization.
class GltfMeshReader {
 public:
  GltfMeshReader(GltfNumbers& numbers, RemarkList& remarks, bool quantized)
      : numbers_(numbers), remarks_(remarks), quantized_(quantized) {}

  /// Reads a primitive with these weights of its morph targets. A fault is noted in fault().
  GltfPrimitive Read(const JsonNode& primitive, const std::vector<double>& weights);
  const std::string& fault() const noexcept { return fault_; }

 private:
  bool IsPacked(const JsonNode& primitive) const;
  void ReadPoints(const JsonNode& primitive, const std::vector<double>& weights,
                  GltfPrimitive& read);
  void ReadJoints(const JsonNode& attributes, GltfPrimitive& read);
  void ReadTriangles(const JsonNode& primitive, GltfPrimitive& read);

  GltfNumbers& numbers_;
  RemarkList& remarks_;
  bool quantized_;
  std::string fault_;
};

}  // namespace tandem
