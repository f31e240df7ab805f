#pragma once

#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "engine/base/result.h"
#include "engine/base/spatial.h"
#include "engine/geometry/formats/affine34.h"
#include "engine/geometry/formats/collada/collada_mesh.h"
#include "engine/geometry/formats/collada/xml_tree.h"

namespace tandem {

/// Returns the affine map of sixteen numbers, row by row; nothing: its last row is not 0 0 0 1.
std::optional<Affine34> AffineOf(const double* numbers);

/// A mesh that a controller shapes, at rest.
struct ControlledMesh {
  RawMesh mesh;
  bool placed = false;         // joints place it, and its node does not
  std::vector<bool> mirrored;  // by point, where joints place it
};

/// Reads <controller> elements: skins at the rest pose of their joints, and morphs with the weights
/// that the file holds.
class ColladaControllers {
 public:
  /// Finds where a joint stands by its name, or by its id if `by_id`; the error says why it cannot.
  using FindJoint = std::function<Result<Affine34>(const std::string& name, bool by_id)>;

  explicit ColladaControllers(ColladaMeshReader& meshes) : meshes_(meshes) {}

  /// Reads a geometry, or what a controller makes of one. A fault is noted at `meshes`.
  ControlledMesh Read(const XmlElement& element, const FindJoint& joints, int depth = 0);

 private:
  ControlledMesh ReadMorph(const XmlElement& morph, const FindJoint& joints, int depth);
  ControlledMesh ReadSkin(const XmlElement& skin, const FindJoint& joints, int depth);
  const XmlElement* InputOf(const XmlElement& parent, const char* semantic);
  /// Returns the words of a source, and whether they are ids.
  static std::pair<std::vector<std::string>, bool> NamesOf(const XmlElement& source);
  std::optional<std::vector<Affine34>> JointsOf(const XmlElement& skin, const FindJoint& joints);

  ColladaMeshReader& meshes_;
};

}  // namespace tandem
