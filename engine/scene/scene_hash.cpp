#include "engine/scene/scene_hash.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <string>

#include "engine/base/files/regular_file.h"
#include "engine/base/files/sha256.h"
#include "engine/base/hash.h"
#include "engine/geometry/formats/gltf_buffers.h"
#include "engine/geometry/import/declared_unit.h"
#include "engine/scene/force_parameters.h"

namespace tandem {

namespace {

/// Bytes, with buffers: the process that reads a mesh has 2 GB of memory.
constexpr std::uintmax_t kLargestMesh = 4ULL << 30U;
constexpr double kUnitOfFile = -1;  // a scale that no body can have

/// A file or a mesh by both hashes.
struct Hashes {
  std::uint64_t quick = 0;
  Sha256 digest{};
};

/// Hashes a file and subtracts the bytes read from `budget`.
Result<Hashes> HashFile(const std::filesystem::path& file, std::uintmax_t& budget) {
  const Result<RegularFile> opened = RegularFile::Open(file);
  if (!opened) return opened.error();
  // a file without a size is empty, or the system generates it without end
  const std::uintmax_t reported = opened->size();
  if (reported > budget) return Error{file.string() + ": is larger than any mesh that is read"};
  Hash64 quick;
  RunningSha256 digest;
  std::uint64_t size = 0;
  std::array<char, 65536> block{};
  while (size < reported) {
    const std::size_t got = opened->Read(size, block);
    if (got == 0) break;
    quick.AddBytes(block.data(), got);
    digest.AddBytes(block.data(), got);
    size += got;
  }
  quick.Add(size);
  budget -= std::min<std::uintmax_t>(budget, size);
  return Hashes{quick.value(), digest.Value()};
}

/// Hashes all files that a mesh is read from, and adds their number and digests to the scene's.
Result<Hashes> HashMesh(const std::filesystem::path& file, RunningSha256& scene) {
  std::uintmax_t budget = kLargestMesh;
  const Result<Hashes> own = HashFile(file, budget);
  if (!own) return own;
  const Result<std::vector<std::filesystem::path>> buffers = GltfBuffers(file);
  if (!buffers) return buffers.error();
  scene.Add(std::uint64_t{buffers->size()});
  scene.Add(own->digest);
  // a mesh of one file keeps the hash by which recordings and earlier versions know it
  if (buffers->empty()) return own;
  Hash64 quick;
  RunningSha256 digest;
  quick.Add(own->quick);
  digest.Add(own->digest);
  for (const std::filesystem::path& buffer : *buffers) {
    const Result<Hashes> more = HashFile(buffer, budget);
    if (!more) return more;
    quick.Add(more->quick);
    digest.Add(more->digest);
    scene.Add(more->digest);
  }
  return Hashes{quick.value(), digest.Value()};
}

/// Returns the kind by which a mesh file is read: the same bytes may be two meshes, each of its own
/// kind.
std::string KindOf(const std::filesystem::path& mesh) {
  std::string kind = mesh.extension().string();
  std::ranges::transform(kind, kind.begin(), [](char c) {
    return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
  });
  return kind;
}

/// Feeds values to both hashes. The digest also has the length of each text, and whether a value is
/// there, so that no two contents are one sequence of bytes.
class BothHashes {
 public:
  explicit BothHashes(RunningSha256& digest) : digest_(digest) {}

  // adding 0 turns a negative zero, which means the same, into 0
  void Add(double value) {
    quick_.Add(value + 0.0);
    digest_.Add(value + 0.0);
  }
  void AddIf(bool there, double value) {
    digest_.Add(there);
    if (there) Add(value);
  }
  void Add(std::uint64_t value) {
    quick_.Add(value);
    digest_.Add(value);
  }
  void AddQuick(std::uint64_t hash) { quick_.Add(hash); }
  void AddText(const std::string& text) {
    quick_.AddBytes(text.data(), text.size());
    digest_.AddText(text);
  }
  std::uint64_t quick() const { return quick_.value(); }

 private:
  Hash64 quick_;
  RunningSha256& digest_;
};

/// Hashes the values of a body, and adds them to the scene's digest.
std::uint64_t HashValues(const Scene& scene, std::size_t i, RunningSha256& digest) {
  const SceneBody& body = scene.bodies[i];
  BothHashes hashes(digest);
  hashes.Add(static_cast<double>(scene.WholeOf(i)));
  hashes.Add(body.free ? 1.0 : 0.0);
  for (const std::uint64_t value : ContentOf(body.constraint)) hashes.Add(value);
  hashes.Add(body.scale.value_or(1));
  // the file's bytes contain the unit, but not whether it counts
  hashes.AddIf(!body.scale && KindDeclaresUnit(body.mesh), kUnitOfFile);
  hashes.AddText(body.part);
  const Vec3& p = body.X_WM.p;
  const Quat& q = body.X_WM.q;
  for (const double x : {p.x(), p.y(), p.z(), q.x(), q.y(), q.z(), q.w()}) hashes.Add(x);
  hashes.Add(body.fixed ? 1.0 : 0.0);
  hashes.Add(body.shared ? 1.0 : 0.0);
  hashes.Add(body.mass);
  hashes.Add(body.density);
  hashes.Add(body.inward_shift_voxels);
  // scenes of one point a voxel keep the hash by which recordings and earlier versions know them
  const bool has_own_points = !body.fixed && scene.WholeOf(i) == i;
  hashes.AddIf(has_own_points && body.point_spacing_voxels != 1, body.point_spacing_voxels);
  return hashes.quick();
}

}  // namespace

Result<SceneHash> HashScene(const Scene& scene) {
  SceneHash result;
  result.parameters = HashOf(ParametersOf(scene));
  RunningSha256 digest;
  BothHashes hashes(digest);
  digest.AddText("scene");
  const Vec3& g = scene.gravity_W;
  for (const double x : {g.x(), g.y(), g.z()}) hashes.Add(x);
  digest.Add(std::uint64_t{scene.pairs.size()});
  for (const ScenePair& pair : scene.pairs) {
    hashes.Add(static_cast<double>(scene.BodyNamed(pair.pointshell)));
    hashes.Add(static_cast<double>(scene.BodyNamed(pair.voxmap)));
  }
  digest.Add(std::uint64_t{scene.bodies.size()});
  for (std::size_t i = 0; i < scene.bodies.size(); ++i) {
    digest.AddText(KindOf(scene.bodies[i].mesh));
    const Result<Hashes> mesh = HashMesh(scene.bodies[i].mesh, digest);
    if (!mesh) return mesh.error();
    const SceneHash::Body body{
        .values = HashValues(scene, i, digest), .mesh = mesh->quick, .mesh_digest = mesh->digest};
    result.bodies.push_back(body);
    hashes.AddQuick(body.values);
    hashes.AddQuick(body.mesh);
  }
  result.content = hashes.quick();
  result.digest = digest.Value();
  return result;
}

}  // namespace tandem
