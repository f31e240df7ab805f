#include "engine/geometry/formats/gltf/gltf_mesh.h"

#include <algorithm>
#include <optional>

namespace tandem {

namespace {

constexpr std::uint64_t kByteComponents = 5121;   // without sign
constexpr std::uint64_t kShortComponents = 5123;  // without sign
constexpr std::uint64_t kFloatComponents = 5126;
enum Mode : int { kTriangles = 4, kTriangleStrip = 5, kTriangleFan = 6 };

}  // namespace

bool GltfMeshReader::IsPacked(const JsonNode& primitive) const {
  if (!primitive.Has("extensions")) return false;
  if (!primitive["extensions"].Has("KHR_draco_mesh_compression")) return false;
  // some files hold the plain numbers too
  return !numbers_.HasNumbers(UnsignedOf(primitive["attributes"], "POSITION", UINT64_MAX));
}

GltfPrimitive GltfMeshReader::Read(const JsonNode& primitive, const std::vector<double>& weights) {
  GltfPrimitive read;
  const int mode = primitive.Has("mode") ? primitive["mode"].WholeNumber(0, 6) : kTriangles;
  if (mode < kTriangles) {
    remarks_.Count("primitive of points or lines", "primitives of points or lines",
                   "without a surface left out");
    return read;
  }
  if (IsPacked(primitive)) {
    fault_ =
        "its triangles cannot be had: they are packed (KHR_draco_mesh_compression); export it "
        "without compression";
    return read;
  }
  if (!primitive["attributes"].Has("POSITION")) {
    remarks_.Count("primitive without positions", "primitives without positions", "left out");
    return read;
  }
  ReadPoints(primitive, weights, read);
  if (fault_.empty()) ReadJoints(primitive["attributes"], read);
  if (fault_.empty()) ReadTriangles(primitive, read);
  if (fault_.empty()) fault_ = numbers_.fault();
  return read;
}

void GltfMeshReader::ReadPoints(const JsonNode& primitive, const std::vector<double>& weights,
                                GltfPrimitive& read) {
  const auto places = numbers_.Read(primitive["attributes"]["POSITION"].Unsigned());
  if (!places) return;
  if (places->components != 3 || (places->type != kFloatComponents && !quantized_)) {
    fault_ = "the places of its vertices are not three floats each: export it so";
    return;
  }
  read.points.reserve(places->count);
  for (std::size_t i = 0; i < places->count; ++i) {
    read.points.emplace_back(places->At(i, 0), places->At(i, 1), places->At(i, 2));
  }
  const std::vector<JsonNode> targets = ItemsOf(primitive, "targets");
  for (std::size_t t = 0; t < std::min(targets.size(), weights.size()); ++t) {
    if (weights[t] == 0 || !targets[t].Has("POSITION")) continue;
    const auto moves = numbers_.Read(targets[t]["POSITION"].Unsigned());
    if (!moves) return;
    if (moves->components != 3 || moves->count != read.points.size()) {
      fault_ = "a morph target does not fit its mesh: the file is damaged";
      return;
    }
    for (std::size_t i = 0; i < moves->count; ++i) {
      read.points[i] += weights[t] * Vec3(moves->At(i, 0), moves->At(i, 1), moves->At(i, 2));
    }
  }
}

void GltfMeshReader::ReadJoints(const JsonNode& attributes, GltfPrimitive& read) {
  for (int set = 0; set < 16; ++set) {
    const std::string joints_key = "JOINTS_" + std::to_string(set);
    const std::string weights_key = "WEIGHTS_" + std::to_string(set);
    if (!attributes.Has(joints_key) || !attributes.Has(weights_key)) return;
    auto joints = numbers_.Read(attributes[joints_key].Unsigned());
    auto weights = numbers_.Read(attributes[weights_key].Unsigned());
    if (!joints || !weights) return;
    if (joints->components != 4 || weights->components != 4 ||
        joints->count != read.points.size() || weights->count != read.points.size()) {
      fault_ = "the joints of a skin do not fit its mesh: the file is damaged";
      return;
    }
    const bool whole = joints->type == kByteComponents || joints->type == kShortComponents;
    if (!whole || joints->normalized) {
      fault_ = "the joints of a skin are not numbers of joints: the file is damaged";
      return;
    }
    read.joints.resize(read.points.size());
    for (std::size_t i = 0; i < read.points.size(); ++i) {
      for (std::size_t k = 0; k < 4; ++k) {
        if (weights->At(i, k) == 0) continue;
        read.joints[i].emplace_back(static_cast<std::uint32_t>(joints->At(i, k)),
                                    weights->At(i, k));
      }
    }
  }
}

void GltfMeshReader::ReadTriangles(const JsonNode& primitive, GltfPrimitive& read) {
  const int mode = primitive.Has("mode") ? primitive["mode"].WholeNumber(0, 6) : kTriangles;
  std::vector<double> order;
  if (primitive.Has("indices")) {
    auto indices = numbers_.Read(primitive["indices"].Unsigned());
    if (!indices) return;
    if (indices->components != 1 || indices->type == kFloatComponents) {
      fault_ = "its indices are no whole numbers: the file is damaged";
      return;
    }
    order = std::move(indices->values);
  } else {
    for (std::size_t i = 0; i < read.points.size(); ++i) order.push_back(static_cast<double>(i));
  }
  const auto last = static_cast<double>(read.points.size());
  const auto add = [&](std::size_t a, std::size_t b, std::size_t c) {
    ++read.stated;
    if (order[a] >= last || order[b] >= last || order[c] >= last) return;
    read.triangles.push_back({static_cast<std::uint32_t>(order[a]),
                              static_cast<std::uint32_t>(order[b]),
                              static_cast<std::uint32_t>(order[c])});
  };
  const std::size_t count = order.size();
  if (mode == kTriangles) {
    for (std::size_t i = 0; i + 2 < count; i += 3) add(i, i + 1, i + 2);
    if (count % 3 != 0) {
      remarks_.Count("primitive of a number of corners that three does not divide",
                     "primitives of a number of corners that three does not divide",
                     "read without the last corners");
    }
    return;
  }
  for (std::size_t i = 0; i + 2 < count; ++i) {
    if (mode == kTriangleFan) {
      add(i + 1, i + 2, 0);
    } else {
      add(i, i + 1 + i % 2, i + 2 - i % 2);
    }
  }
}

}  // namespace tandem
