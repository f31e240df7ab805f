#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <utility>
#include <vector>

#include "engine/contact/field/field_pair.h"

namespace tandem {

/// Tells whether two bodies touch: yes or no, with a place. After an answer of yes, the next query
/// first looks at its place, so that bodies that go on touching cost one query. Not for several
/// threads at once.
class TouchQuery {
 public:
  /// Both surfaces must have the same voxel size, and outlive the query.
  TouchQuery(const BodySurface& one, const BodySurface& other);

  /// Distance up to which surfaces touch, voxels: the error bound of a field.
  static constexpr double kTouching = 0.02;
  /// Returns a place (p_W) of one body's features that touches the other or lies in it; nothing if
  /// they do not touch. Does not allocate.
  std::optional<Vec3> Find(const Pose& X_WA, const Pose& X_WB) noexcept;
  /// Forgets the place of the last answer.
  void Forget() noexcept { witness_.reset(); }

 private:
  /// The features of one body and the field of the other.
  struct Side {
    const BodyFeatures* features;
    const DistanceField* field;
    Mat3 R_VF = Mat3::Identity();  // pose of F in the field's frame V, voxels
    Vec3 p_VF = Vec3::Zero();
    /// Chunks that may touch, with a bound of how deep they may be.
    std::vector<std::pair<float, std::uint32_t>> chunks;
  };
  struct Witness {
    std::size_t side = 0;
    Vec3 place_F = Vec3::Zero();
  };

  void FindChunks(Side& side) const noexcept;
  std::optional<Vec3> FindIn(const Side& side) const noexcept;
  std::optional<Vec3> FindInBlock(const Side& side, std::uint32_t block) const noexcept;
  /// Does the same for a piece of a straight edge, by halves until these are shorter than
  /// kTouching.
  std::optional<Vec3> FindOnEdge(const Side& side, const Vec3& middle_F,
                                 const Vec3& half_F) const noexcept;

  double s_;  // voxel size, m
  std::array<const BodySurface*, 2> bodies_;
  std::array<Side, 2> sides_;
  std::optional<Witness> witness_;
};

}  // namespace tandem
