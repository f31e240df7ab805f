#include "engine/geometry/mesh_file.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <cerrno>
#include <cmath>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <limits>
#include <new>
#include <optional>
#include <string>
#include <string_view>
#include <system_error>
#include <vector>

#include <assimp/Importer.hpp>
#include <assimp/config.h>
#include <assimp/postprocess.h>
#include <assimp/scene.h>
#include <unistd.h>

#include "engine/base/regular_file.h"
#include "engine/geometry/declared_unit.h"
#include "engine/geometry/import_child.h"
#include "engine/geometry/import_confinement.h"
#include "engine/geometry/own_readers.h"
#include "engine/geometry/raw_mesh.h"

namespace tandem {
namespace {

constexpr double kFarthest = 1e7;  // m; no mock-up is larger than the Earth

// ---- In the reading process: assimp's scene becomes one list of triangles. ----

using Affine = Eigen::Matrix<double, 3, 4>;

Affine AffineOf(const aiMatrix4x4& m) {
  Affine affine;
  affine << double{m.a1}, double{m.a2}, double{m.a3}, double{m.a4},  //
      double{m.b1}, double{m.b2}, double{m.b3}, double{m.b4},        //
      double{m.c1}, double{m.c2}, double{m.c3}, double{m.c4};
  return affine;
}

Affine Times(const Affine& a, const Affine& b) {
  Affine product;
  product << a.leftCols<3>() * b.leftCols<3>(), a.leftCols<3>() * b.col(3) + a.col(3);
  return product;
}

/// Returns what makes a mesh unfit for assimp's own steps, which trust it; empty if nothing does.
std::string FaultOf(const aiMesh& mesh) {
  if (mesh.mNumFaces > 0 && (mesh.mFaces == nullptr || mesh.mVertices == nullptr)) {
    return "has faces but no vertices";
  }
  for (unsigned f = 0; f < mesh.mNumFaces; ++f) {
    const aiFace& face = mesh.mFaces[f];
    if (face.mNumIndices > 0 && face.mIndices == nullptr) return "has a face without corners";
    for (unsigned k = 0; k < face.mNumIndices; ++k) {
      if (face.mIndices[k] >= mesh.mNumVertices) {
        return "face " + std::to_string(f) + " uses vertex " + std::to_string(face.mIndices[k]) +
               ", but there are only " + std::to_string(mesh.mNumVertices);
      }
    }
  }
  return {};
}

/// Appends the triangles of a mesh as the node places them. Points and lines have no surface.
void AppendMesh(const aiMesh& mesh, const Affine& X_MN, RawMesh& whole) {
  constexpr std::size_t kMost = std::numeric_limits<std::uint32_t>::max() - 1;
  if (whole.points.size() + mesh.mNumVertices > kMost) throw std::bad_alloc();
  const auto first = static_cast<std::uint32_t>(whole.points.size());
  for (unsigned v = 0; v < mesh.mNumVertices; ++v) {
    const aiVector3D& p = mesh.mVertices[v];
    const Vec3 p_MV =
        X_MN.leftCols<3>() * Vec3(double{p.x}, double{p.y}, double{p.z}) + X_MN.col(3);
    whole.points.push_back(
        {static_cast<float>(p_MV.x()), static_cast<float>(p_MV.y()), static_cast<float>(p_MV.z())});
  }
  const bool mirrored = X_MN.leftCols<3>().determinant() < 0;
  for (unsigned f = 0; f < mesh.mNumFaces; ++f) {
    const aiFace& face = mesh.mFaces[f];
    if (face.mNumIndices != 3) continue;
    const unsigned* i = face.mIndices;
    whole.triangles.push_back(
        {first + i[0], first + i[mirrored ? 2 : 1], first + i[mirrored ? 1 : 2]});
  }
}

void AppendNode(const aiScene& scene, const aiNode& node, const Affine& X_MP, RawMesh& whole) {
  const Affine X_MN = Times(X_MP, AffineOf(node.mTransformation));
  for (unsigned m = 0; m < node.mNumMeshes; ++m) {
    if (node.mMeshes[m] < scene.mNumMeshes) {
      AppendMesh(*scene.mMeshes[node.mMeshes[m]], X_MN, whole);
    }
  }
  for (unsigned c = 0; c < node.mNumChildren; ++c) {
    AppendNode(scene, *node.mChildren[c], X_MN, whole);
  }
}

/// Appends the nodes of that name, and meshes of that name elsewhere; returns whether there was
/// any.
bool AppendPart(const aiScene& scene, const aiNode& node, const std::string& part,
                const Affine& X_MP, RawMesh& whole) {
  if (node.mName.C_Str() == part) {
    AppendNode(scene, node, X_MP, whole);
    return true;
  }
  const Affine X_MN = Times(X_MP, AffineOf(node.mTransformation));
  bool found = false;
  for (unsigned m = 0; m < node.mNumMeshes; ++m) {
    if (node.mMeshes[m] >= scene.mNumMeshes) continue;
    const aiMesh& mesh = *scene.mMeshes[node.mMeshes[m]];
    if (mesh.mName.C_Str() != part) continue;
    AppendMesh(mesh, X_MN, whole);
    found = true;
  }
  for (unsigned c = 0; c < node.mNumChildren; ++c) {
    found = AppendPart(scene, *node.mChildren[c], part, X_MN, whole) || found;
  }
  return found;
}

/// Collects the names of the nodes that hold something, and of meshes with their own name.
void CollectNames(const aiScene& scene, const aiNode& node, std::vector<std::string>& names) {
  const auto add = [&names](const char* name) {
    if (*name != '\0' && std::ranges::count(names, name) == 0) names.emplace_back(name);
  };
  if (node.mNumMeshes > 0) add(node.mName.C_Str());
  for (unsigned m = 0; m < node.mNumMeshes; ++m) {
    const bool several = node.mNumMeshes > 1 && node.mMeshes[m] < scene.mNumMeshes;
    if (several) add(scene.mMeshes[node.mMeshes[m]]->mName.C_Str());
  }
  for (unsigned c = 0; c < node.mNumChildren; ++c) CollectNames(scene, *node.mChildren[c], names);
}

std::string NoPart(const aiScene& scene, const std::string& part) {
  constexpr std::size_t kMostNames = 12;
  std::vector<std::string> names;
  CollectNames(scene, *scene.mRootNode, names);
  std::string words = "it has no part '" + part + "', but ";
  if (names.empty()) return words + "parts without names only";
  for (std::size_t i = 0; i < std::min(names.size(), kMostNames); ++i) {
    words += (i == 0 ? "" : ", ") + names[i];
  }
  if (names.size() > kMostNames)
    words += " and " + std::to_string(names.size() - kMostNames) + " more";
  return words;
}

// Set when an allocation failed; the reading process has one thread.
bool memory_ran_out = false;

/// For std::set_new_handler(): code that catches the exception may not report it.
[[noreturn]] void NoteThatMemoryRanOut() {
  memory_ran_out = true;
  throw std::bad_alloc();
}

ReadAnswer RefusalOf(const Assimp::Importer& importer) {
  // assimp catches all exceptions, and frees its memory before it reports one
  if (memory_ran_out) return {ReadAnswer::Kind::kOutOfMemory, {}, {}, 0};
  return {ReadAnswer::Kind::kRefused, importer.GetErrorString(), {}, 0};
}

std::size_t TrianglesIn(const aiScene& scene) {
  std::size_t triangles = 0;
  for (unsigned m = 0; m < scene.mNumMeshes; ++m) {
    const aiMesh& mesh = *scene.mMeshes[m];
    for (unsigned f = 0; f < mesh.mNumFaces; ++f) triangles += mesh.mFaces[f].mNumIndices == 3;
  }
  return triangles;
}

ReadAnswer ReadByAssimp(const std::string& file, const std::string& part) {
  Assimp::Importer importer;
  importer.SetPropertyBool(AI_CONFIG_IMPORT_COLLADA_IGNORE_UP_DIRECTION, true);
  importer.SetPropertyBool(AI_CONFIG_IMPORT_FBX_PRESERVE_PIVOTS, false);
  // Triangulating aborts on faces that use vertices the mesh does not have. So it waits until the
  // faces are known to be sound. No other step is wanted: joining, validating and finding
  // degenerates each change or refuse good meshes.
  const std::optional<std::string> text = TextInstead(file);
  const aiScene* scene =
      text ? importer.ReadFileFromMemory(text->data(), text->size(), 0, EndingOf(file).c_str())
           : importer.ReadFile(file, 0);
  if (scene == nullptr) return RefusalOf(importer);
  for (unsigned m = 0; m < scene->mNumMeshes; ++m) {
    if (std::string fault = FaultOf(*scene->mMeshes[m]); !fault.empty()) {
      return {ReadAnswer::Kind::kRefused, "mesh " + std::to_string(m) + ": " + fault, {}, 0};
    }
  }
  const std::string fault = SilentFault(file, text.value_or(std::string()), TrianglesIn(*scene));
  if (!fault.empty()) return {ReadAnswer::Kind::kRefused, fault, {}, 0};
  scene = importer.ApplyPostProcessing(aiProcess_Triangulate);
  if (scene == nullptr) return RefusalOf(importer);
  ReadAnswer answer{ReadAnswer::Kind::kMesh, {}, {}, 0};
  if (scene->mRootNode == nullptr) return answer;
  const Affine X_MM = AffineOf(aiMatrix4x4());
  if (part.empty()) {
    AppendNode(*scene, *scene->mRootNode, X_MM, answer.mesh);
  } else if (!AppendPart(*scene, *scene->mRootNode, part, X_MM, answer.mesh)) {
    return {ReadAnswer::Kind::kRefused, NoPart(*scene, part), {}, 0};
  }
  return answer;
}

// ---- In the program: the result, in words or welded. ----

/// Returns plain text, without line breaks and of a length for a person, from any source.
std::string OneLine(std::string_view words) {
  constexpr std::size_t kLongestWords = 300;
  std::string line;
  for (const char c : words) {
    const bool blank = static_cast<unsigned char>(c) <= ' ' || c == 0x7f;
    if (!blank) line += c;
    if (blank && !line.empty() && line.back() != ' ') line += ' ';
  }
  while (!line.empty() && (line.back() == ' ' || line.back() == '.')) line.pop_back();
  return PlainLine(line, kLongestWords);
}

std::string Number(double x) {
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "%.4g", x);
  return text.data();
}

std::string Size(std::size_t bytes) {
  const double mib = static_cast<double>(bytes) / (1 << 20);
  return mib < 1024 ? Number(mib) + " MiB" : Number(mib / 1024) + " GiB";
}

std::string SystemWords(int error_number) {
  return std::generic_category().message(error_number);
}

std::string SignalName(int signal) {
  const char* name = sigdescr_np(signal);  // the thread-safe strsignal
  return name == nullptr ? "unknown" : name;
}

/// Returns all faults of the file that are known before it is read.
std::optional<Error> FaultOf(const std::filesystem::path& file, const std::string& name) {
  std::error_code error;
  const std::filesystem::file_status status = std::filesystem::status(file, error);
  if (status.type() == std::filesystem::file_type::not_found) {
    return Error{"mesh file " + name + " does not exist: check the path"};
  }
  if (error) return Error{"cannot read mesh file " + name + ": " + error.message()};
  if (std::filesystem::is_directory(status)) {
    return Error{name + " is a directory: name a mesh file in it"};
  }
  if (!std::filesystem::is_regular_file(status)) {
    return Error{name + " is not a regular file: name a mesh file"};
  }
  if (access(file.c_str(), R_OK) != 0) {
    return Error{"cannot read mesh file " + name + ": " + SystemWords(errno)};
  }
  return std::nullopt;
}

/// Tells by the extension whether a file is of CAD programs; the mesh library reads only IFC's STEP
/// of these.
bool HoldsCadSurfaces(const std::filesystem::path& file) {
  constexpr std::array<std::string_view, 16> kEndings{
      ".step", ".stp",    ".p21",    ".igs", ".iges", ".brep",    ".sat", ".x_t",
      ".x_b",  ".sldprt", ".sldasm", ".ipt", ".prt",  ".catpart", ".jt",  ".fcstd"};
  std::string ending = file.extension().string();
  std::ranges::transform(ending, ending.begin(), [](unsigned char c) {
    return static_cast<char>(std::tolower(c));
  });
  return std::ranges::count(kEndings, ending) > 0;
}

Result<ReadAnswer> ReadInChild(const std::filesystem::path& file, const std::string& name,
                               const ImportOptions& options) {
  using End = ImportChildRun::End;
  const ImportLimits limits{options.seconds_limit, options.memory_limit_bytes};
  const ImportChildRun run = RunImportChild(file, options.part, limits);
  if (run.end == End::kNotStarted) {
    return Error{"cannot start the process that reads " + name + ": " + SystemWords(run.code)};
  }
  if (run.end == End::kTooLate || (run.end == End::kKilledBySignal && run.code == SIGXCPU)) {
    return Error{"reading " + name + " took more than " + Number(options.seconds_limit) +
                 " s: use a smaller mesh or a longer limit"};
  }
  std::optional<ReadAnswer> answer = ParseAnswer(run.answer);
  if (run.end == End::kTooMuchSaid || (answer && answer->kind == ReadAnswer::Kind::kOutOfMemory)) {
    return Error{"reading " + name + " needs more than " + Size(options.memory_limit_bytes) +
                 ": the file is damaged, or use a smaller mesh or a larger limit"};
  }
  if (run.end == End::kKilledBySignal || !answer) {
    const std::string how =
        run.end == End::kKilledBySignal
            ? std::string("signal ") + std::to_string(run.code) + ", " + SignalName(run.code)
            : "exit code " + std::to_string(run.code);
    return Error{
        "the mesh library crashed on " + name + " (" + how +
        "): the file is damaged or of a kind that it cannot read; export it as STL or OBJ"};
  }
  if (answer->kind == ReadAnswer::Kind::kRefused && HoldsCadSurfaces(file)) {
    return Error{name +
                 " holds CAD surfaces, which are not triangles: export the part from the CAD "
                 "program as STL, 3MF or OBJ"};
  }
  if (answer->kind == ReadAnswer::Kind::kRefused) {
    return Error{"cannot read " + name + " as a mesh: " + OneLine(answer->words)};
  }
  return std::move(*answer);
}

/// Keeps only the points that triangles use, in their order.
void DropUnusedPoints(RawMesh& mesh) {
  std::vector<std::uint32_t> new_index(mesh.points.size(), 0);
  for (const TriangleMesh::Triangle& t : mesh.triangles) {
    for (const std::uint32_t i : t) new_index[i] = 1;
  }
  std::uint32_t kept = 0;
  for (std::size_t i = 0; i < mesh.points.size(); ++i) {
    if (new_index[i] == 0) continue;
    mesh.points[kept] = mesh.points[i];
    new_index[i] = kept++;
  }
  mesh.points.resize(kept);
  for (TriangleMesh::Triangle& t : mesh.triangles) {
    for (std::uint32_t& i : t) i = new_index[i];
  }
}

/// Checks the child's answer as untrusted, and welds it.
Result<TriangleMesh> Build(RawMesh raw, double scale, const std::string& name,
                           const ImportOptions& options) {
  if (raw.triangles.empty()) {
    return Error{name +
                 " holds no triangles that could be read: export the part's surface as a "
                 "triangle mesh"};
  }
  for (const TriangleMesh::Triangle& t : raw.triangles) {
    for (const std::uint32_t i : t) {
      if (i >= raw.points.size()) {
        return Error{name + ": a triangle uses vertex " + std::to_string(i) +
                     ", but there are only " + std::to_string(raw.points.size())};
      }
    }
  }
  DropUnusedPoints(raw);
  std::size_t not_finite = 0;
  double farthest = 0;
  for (const FloatPoint& p : raw.points) {
    bool finite = true;
    for (const float x : p) {
      finite = finite && std::isfinite(x);
      farthest = std::max(farthest, std::abs(double{x} * scale));
    }
    not_finite += finite ? 0U : 1U;
  }
  if (not_finite > 0) {
    return Error{name + ": " + std::to_string(not_finite) + " of its " +
                 std::to_string(raw.points.size()) +
                 " vertices are infinite or not numbers: the file is damaged"};
  }
  if (farthest > kFarthest) {
    return Error{name + " reaches " + Number(farthest) +
                 " m from its origin: the file is damaged or the scale of " + Number(scale) +
                 " m per unit is wrong"};
  }

  const Weld weld = WeldNear(raw.points, options.weld_tolerance);
  TriangleMesh mesh;
  mesh.vertices.reserve(weld.first_point.size());
  for (const std::uint32_t point : weld.first_point) {
    const FloatPoint& p = raw.points[point];
    mesh.vertices.emplace_back(scale * Vec3(double{p[0]}, double{p[1]}, double{p[2]}));
  }
  mesh.triangles = std::move(raw.triangles);
  double largest_area = 0;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    for (std::uint32_t& i : mesh.triangles[t]) i = weld.vertex_of_point[i];
    const Vec3 side = mesh.corner(t, 1) - mesh.corner(t, 0);
    largest_area = std::max(largest_area, side.cross(mesh.corner(t, 2) - mesh.corner(t, 0)).norm());
  }
  if (largest_area == 0) {
    return Error{name + ": none of its " + std::to_string(mesh.triangles.size()) +
                 " triangles has any area: the file is damaged or the weld tolerance too large"};
  }
  return mesh;
}

}  // namespace

Result<TriangleMesh> ImportMesh(const std::filesystem::path& file, const ImportOptions& options) {
  const std::string name = OneLine(file.native());
  if (options.scale && (!(*options.scale > 0) || !std::isfinite(*options.scale))) {
    return Error{"the scale of " + name + " must be a number above 0, not " +
                 Number(*options.scale)};
  }
  if (!(options.weld_tolerance >= 0) || !std::isfinite(options.weld_tolerance)) {
    return Error{"the weld tolerance of " + name + " must be 0 or a number above, not " +
                 Number(options.weld_tolerance)};
  }
  if (std::optional<Error> fault = FaultOf(file, name)) return *fault;
  Result<ReadAnswer> answer = ReadInChild(file, name, options);
  if (!answer) return answer.error();
  if (!options.scale && KindDeclaresUnit(file) && !(answer->metres_per_unit > 0)) {
    return Error{name +
                 ": the unit that it declares cannot be read: give a \"scale\", in metres "
                 "per unit of the file (0.001 for millimetres)"};
  }
  const double declared = answer->metres_per_unit > 0 ? answer->metres_per_unit : 1.0;
  return Build(std::move(answer->mesh), options.scale.value_or(declared), name, options);
}

void RunImportHelperIfAsked(int argc, char** argv) {
  const std::optional<ImportJob> job = ImportJobOf(argc, argv);
  if (!job) return;
  ConfineTo(job->limits);
  ConfineToFile(job->file);
  std::set_new_handler(NoteThatMemoryRanOut);
  bool heard = false;
  try {
    std::optional<ReadAnswer> answer = ReadOurselves(job->file, job->part);
    if (!answer) answer = ReadByAssimp(job->file.native(), job->part);
    if (answer->kind == ReadAnswer::Kind::kMesh && !(answer->metres_per_unit > 0)) {
      answer->metres_per_unit = DeclaredUnit(job->file).value_or(0);
    }
    heard = WriteAnswer(job->answer_fd, *answer);
  } catch (const std::bad_alloc&) {
    heard = WriteAnswer(job->answer_fd, {ReadAnswer::Kind::kOutOfMemory, {}, {}, 0});
  }
  _exit(heard ? 0 : 1);  // the program's cleanup has nothing to clean up
}

}  // namespace tandem
