#include "engine/scene/scene_hash.h"

#include <algorithm>
#include <array>
#include <cstddef>

#include "engine/base/files/regular_file.h"
#include "engine/base/hash.h"
#include "engine/geometry/formats/gltf_buffers.h"
#include "engine/geometry/import/declared_unit.h"
#include "engine/scene/force_parameters.h"

namespace tandem {

namespace {

/// Bytes, with buffers: the process that reads a mesh has 2 GB of memory.
constexpr std::uintmax_t kLargestMesh = 4ULL << 30U;
constexpr double kUnitOfFile = -1;  // a scale that no body can have

/// Hashes a file and subtracts the bytes read from `budget`.
Result<std::uint64_t> HashFile(const std::filesystem::path& file, std::uintmax_t& budget) {
  const Result<RegularFile> opened = RegularFile::Open(file);
  if (!opened) return opened.error();
  // a file without a size is empty, or the system generates it without end
  const std::uintmax_t reported = opened->size();
  if (reported > budget) return Error{file.string() + ": is larger than any mesh that is read"};
  Hash64 hash;
  std::uint64_t size = 0;
  std::array<char, 65536> block{};
  while (size < reported) {
    const std::size_t got = opened->Read(size, block);
    if (got == 0) break;
    hash.AddBytes(block.data(), got);
    size += got;
  }
  hash.Add(size);
  budget -= std::min<std::uintmax_t>(budget, size);
  return hash.value();
}

/// Returns the hash of all files that a mesh is read from.
Result<std::uint64_t> HashMesh(const std::filesystem::path& file) {
  std::uintmax_t budget = kLargestMesh;
  const Result<std::uint64_t> own = HashFile(file, budget);
  if (!own) return own;
  const Result<std::vector<std::filesystem::path>> buffers = GltfBuffers(file);
  if (!buffers) return buffers.error();
  // a mesh of one file keeps the hash by which recordings and earlier versions know it
  if (buffers->empty()) return own;
  Hash64 hash;
  hash.Add(*own);
  for (const std::filesystem::path& buffer : *buffers) {
    const Result<std::uint64_t> more = HashFile(buffer, budget);
    if (!more) return more;
    hash.Add(*more);
  }
  return hash.value();
}

// adding 0 turns a negative zero, which means the same, into 0
void Add(Hash64& hash, double value) {
  hash.Add(value + 0.0);
}

std::uint64_t HashValues(const Scene& scene, std::size_t i) {
  const SceneBody& body = scene.bodies[i];
  Hash64 hash;
  Add(hash, static_cast<double>(scene.WholeOf(i)));
  Add(hash, body.free ? 1 : 0);
  AddTo(hash, body.constraint);
  Add(hash, body.scale.value_or(1));
  // the file's bytes contain the unit, but not whether it counts
  if (!body.scale && KindDeclaresUnit(body.mesh)) Add(hash, kUnitOfFile);
  if (!body.part.empty()) hash.AddBytes(body.part.data(), body.part.size());
  const Vec3& p = body.X_WM.p;
  const Quat& q = body.X_WM.q;
  for (const double x : {p.x(), p.y(), p.z(), q.x(), q.y(), q.z(), q.w()}) Add(hash, x);
  Add(hash, body.fixed ? 1 : 0);
  Add(hash, body.shared ? 1 : 0);
  Add(hash, body.mass);
  Add(hash, body.density);
  Add(hash, body.inward_shift_voxels);
  // scenes of one point a voxel keep the hash by which recordings and earlier versions know them
  const bool has_own_points = !body.fixed && scene.WholeOf(i) == i;
  if (has_own_points && body.point_spacing_voxels != 1) Add(hash, body.point_spacing_voxels);
  return hash.value();
}

}  // namespace

Result<SceneHash> HashScene(const Scene& scene) {
  SceneHash result;
  result.parameters = HashOf(ParametersOf(scene));
  Hash64 hash;
  const Vec3& g = scene.gravity_W;
  for (const double x : {g.x(), g.y(), g.z()}) Add(hash, x);
  for (const ScenePair& pair : scene.pairs) {
    Add(hash, scene.BodyNamed(pair.pointshell));
    Add(hash, scene.BodyNamed(pair.voxmap));
  }
  for (std::size_t i = 0; i < scene.bodies.size(); ++i) {
    const Result<std::uint64_t> mesh = HashMesh(scene.bodies[i].mesh);
    if (!mesh) return mesh.error();
    const SceneHash::Body body{.values = HashValues(scene, i), .mesh = *mesh};
    result.bodies.push_back(body);
    hash.Add(body.values);
    hash.Add(body.mesh);
  }
  result.content = hash.value();
  return result;
}

}  // namespace tandem
