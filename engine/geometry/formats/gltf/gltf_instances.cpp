#include "engine/geometry/formats/gltf/gltf_instances.h"

#include <cstddef>
#include <optional>
#include <string>

#include "engine/base/spatial.h"
#include "engine/geometry/formats/gltf/gltf_placing.h"

namespace tandem {

namespace {

constexpr const char* kInstancing = "EXT_mesh_gpu_instancing";

}  // namespace

bool HasGltfInstances(const JsonNode& node) {
  return node.Has("extensions") && node["extensions"].Has(kInstancing);
}

Result<std::vector<Affine34>> GltfInstancesOf(const JsonNode& node, const Affine34& X_MN,
                                              GltfNumbers& numbers) {
  if (!HasGltfInstances(node)) return std::vector<Affine34>{X_MN};
  const JsonNode attributes = node["extensions"][kInstancing]["attributes"];
  std::optional<std::size_t> count;
  std::string fault;
  const auto read = [&](const char* key,
                        std::size_t components) -> std::optional<GltfNumbers::Numbers> {
    if (!attributes.Has(key) || !fault.empty()) return std::nullopt;
    auto taken = numbers.Read(attributes[key].Unsigned());
    if (!taken) {
      fault = numbers.fault();
    } else if (taken->components != components || (count && *count != taken->count)) {
      fault = "the attributes of its instances do not fit one another";
    } else {
      count = taken->count;
    }
    return taken;
  };
  const auto t = read("TRANSLATION", 3);
  const auto r = read("ROTATION", 4);
  const auto s = read("SCALE", 3);
  if (!fault.empty()) return Error{fault};
  if (!count) return std::vector<Affine34>{X_MN};
  std::vector<Affine34> places;
  for (std::size_t i = 0; i < *count; ++i) {
    Affine34 X = Affine34::Identity();
    if (r) X.leftCols<3>() = TurnBy(r->At(i, 0), r->At(i, 1), r->At(i, 2), r->At(i, 3));
    if (s) {
      X.leftCols<3>() = X.leftCols<3>() * Vec3(s->At(i, 0), s->At(i, 1), s->At(i, 2)).asDiagonal();
    }
    if (t) X.col(3) = Vec3(t->At(i, 0), t->At(i, 1), t->At(i, 2));
    places.push_back(ProductOf(X_MN, X));
  }
  return places;
}

}  // namespace tandem
