#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "engine/base/result.h"
#include "engine/base/spatial.h"
#include "engine/contact/pair/clearance.h"
#include "engine/contact/pair/contact_kind.h"
#include "engine/scene/scene_constraint.h"
#include "engine/voxel/map/voxel.h"

namespace tandem {

/// One part in the scene file. Its place in Scene::bodies is its number on the network.
struct SceneBody {
  std::string name;
  std::filesystem::path mesh;   // resolved path: absolute, or relative to the working directory
  std::string part;             // part of the mesh file, by its name there; empty: the whole file
  std::optional<double> scale;  // metres per file unit; nothing: as the file declares, else 1
  Pose X_WM;                    // pose of the file's frame at the start
  bool fixed = false;           // never moves
  bool shared = false;          // several users may hold it at once (type-2); else one (type-1)
  double mass = 0;              // kg; 0 for fixed bodies, and where the density determines it
  double density = 0;           // kg/m^3, when mass is 0
  double inward_shift_voxels =
      0;  // shift of the pointshell along its normals (paper §7: the ball seats)
  double point_spacing_voxels = 1;  // spacing of points, voxels; at most 1 (paper §3.2)
  bool free = false;                // moves by forces when no hand holds it
  SceneConstraint constraint;       // joint that restricts its motion (paper fn. 1)
  std::string merge_with;           // name of the body that this body is a part of; else empty
  std::array<float, 3> colour{0.7F, 0.7F, 0.7F};  // red, green, blue, 0 to 1
};

/// A script for a hand, and the body that it takes hold of. The demo gives them to its peers in
/// this order.
struct SceneHand {
  std::string body;            // name of a moving body
  std::filesystem::path file;  // as for meshes
};

/// A pair whose pointshell the scene chooses instead of the body of fewer points (paper §2.1).
struct ScenePair {
  std::string pointshell;  // names of moving bodies
  std::string voxmap;
};

/// A scene file, read and checked but with no mesh loaded. The format: docs/scene-format.md.
struct Scene {
  std::string name;
  std::filesystem::path file;
  double voxel_size = 0.001;         // m
  int range_voxels = kDefaultRange;  // range of the marks' fields
  /// For refined contact, voxels: the distance from surfaces up to which distances are exact, and
  /// the distance at which force can begin.
  double fine_band_voxels = kDefaultFineBand;
  double clearance_range_voxels = kDefaultClearanceRange;
  ContactModel contact = ContactModel::kRefined;
  int force_layer = DefaultForceLayer(ContactModel::kRefined);  // free layers (paper §3.2)
  double friction = 0;                                          // Coulomb's mu of all contacts
  Vec3 gravity_W = Vec3::Zero();                                // m/s^2
  std::vector<SceneBody> bodies;
  std::vector<ScenePair> pairs;
  std::vector<SceneHand> hands;

  /// Returns the bounds of a hand's clearance.
  ClearanceBounds clearance_bounds() const;
  /// Returns the index of the body of that name, or -1.
  int BodyNamed(const std::string& body_name) const;
  /// Returns the index of the body that this one moves with: itself, or the body it is merged with.
  std::size_t WholeOf(std::size_t body) const;
  /// Returns whether the pointshell of two moving bodies is `a`: as `pairs` says, else the body of
  /// fewer points, for speed (paper §2.1), and `a` if they are equal.
  bool IsPointshell(std::size_t a, double a_points, std::size_t b, double b_points) const;
};

/// Reads a scene. An error names the file, the place in it (`bodies[1].mass_kg`) and what was
/// expected there.
Result<Scene> LoadScene(const std::filesystem::path& file);

}  // namespace tandem
