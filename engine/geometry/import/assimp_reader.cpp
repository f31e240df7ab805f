#include "engine/geometry/import/assimp_reader.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <new>
#include <optional>
#include <vector>

#include <assimp/Importer.hpp>
#include <assimp/config.h>
#include <assimp/postprocess.h>
#include <assimp/scene.h>

#include "engine/geometry/formats/affine34.h"
#include "engine/geometry/formats/native_readers.h"
#include "engine/geometry/formats/remark_list.h"

namespace tandem {
namespace {

Affine34 AffineOf(const aiMatrix4x4& m) {
  Affine34 affine;
  affine << double{m.a1}, double{m.a2}, double{m.a3}, double{m.a4},  //
      double{m.b1}, double{m.b2}, double{m.b3}, double{m.b4},        //
      double{m.c1}, double{m.c2}, double{m.c3}, double{m.c4};
  return affine;
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
void AppendMesh(const aiMesh& mesh, const Affine34& X_MN, RawMesh& whole) {
  constexpr std::size_t kMost = std::numeric_limits<std::uint32_t>::max() - 1;
  if (whole.points.size() + mesh.mNumVertices > kMost) throw std::bad_alloc();
  const auto first = static_cast<std::uint32_t>(whole.points.size());
  for (unsigned v = 0; v < mesh.mNumVertices; ++v) {
    const aiVector3D& p = mesh.mVertices[v];
    const Vec3 p_MV =
        X_MN.leftCols<3>() * Vec3(double{p.x}, double{p.y}, double{p.z}) + X_MN.col(3);
    whole.points.push_back({p_MV.x(), p_MV.y(), p_MV.z()});
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

void AppendNode(const aiScene& scene, const aiNode& node, const Affine34& X_MP, RawMesh& whole) {
  const Affine34 X_MN = ProductOf(X_MP, AffineOf(node.mTransformation));
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
                const Affine34& X_MP, RawMesh& whole) {
  if (node.mName.C_Str() == part) {
    AppendNode(scene, node, X_MP, whole);
    return true;
  }
  const Affine34 X_MN = ProductOf(X_MP, AffineOf(node.mTransformation));
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

/// Counts what the library reads of a scene, and the answer leaves out.
std::vector<std::string> RemarksOn(const aiScene& scene) {
  RemarkList remarks;
  remarks.Say(
      "its format is read by a library that leaves out in silence what it does not know: check its "
      "size and its shape");
  if (scene.mNumAnimations > 0) remarks.Say("its animations are not played: its rest pose is read");
  for (unsigned m = 0; m < scene.mNumMeshes; ++m) {
    const aiMesh& mesh = *scene.mMeshes[m];
    if (mesh.mNumBones > 0) {
      remarks.Count("skin", "skins", "read as bound to its bones, and not as they are posed");
    }
    if (mesh.mNumAnimMeshes > 0) {
      remarks.Count("mesh with morph targets", "meshes with morph targets", "read without them");
    }
    if ((mesh.mPrimitiveTypes & (aiPrimitiveType_POINT | aiPrimitiveType_LINE)) != 0) {
      remarks.Count("mesh of points or lines", "meshes of points or lines",
                    "without a surface left out");
    }
  }
  return remarks.Lines();
}

/// Returns metres per unit as an FBX file says, in centimetres, or 1 for COLLADA's first versions,
/// whose units the library multiplies in; 0: another format.
double UnitOf(const aiScene& scene, const std::string& file) {
  constexpr double kCentimetre = 0.01;
  if (EndingOf(file) == "dae") return 1;
  if (EndingOf(file) != "fbx") return 0;
  float units = 1;
  double long_units = 1;
  if (scene.mMetaData != nullptr) {
    if (!scene.mMetaData->Get("UnitScaleFactor", units) &&
        scene.mMetaData->Get("UnitScaleFactor", long_units)) {
      units = static_cast<float>(long_units);
    }
  }
  const double metres = kCentimetre * static_cast<double>(units);
  return std::isfinite(metres) && metres > 0 ? metres : 0;
}

}  // namespace

void NoteWhenMemoryRunsOut() {
  std::set_new_handler(NoteThatMemoryRanOut);
}

ReadAnswer ReadWithAssimp(const std::string& file, const std::string& part) {
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
  scene = importer.ApplyPostProcessing(aiProcess_Triangulate);
  if (scene == nullptr) return RefusalOf(importer);
  ReadAnswer answer{ReadAnswer::Kind::kMesh, {}, {}, 0};
  answer.single_precision = true;
  answer.remarks = RemarksOn(*scene);
  answer.metres_per_unit = UnitOf(*scene, file);
  if (EndingOf(file) == "dae") {
    answer.unit_of_format = true;
    answer.remarks.emplace_back(
        "it is of a version of COLLADA before 1.4: its unit is multiplied in, so that a scale is "
        "taken besides it");
  }
  if (scene->mRootNode == nullptr) return answer;
  const Affine34 X_MM = AffineOf(aiMatrix4x4());
  if (part.empty()) {
    AppendNode(*scene, *scene->mRootNode, X_MM, answer.mesh);
  } else if (!AppendPart(*scene, *scene->mRootNode, part, X_MM, answer.mesh)) {
    return {ReadAnswer::Kind::kRefused, NoPart(*scene, part), {}, 0};
  }
  return answer;
}

}  // namespace tandem
