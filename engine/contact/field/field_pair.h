#pragma once

#include <array>
#include <optional>
#include <span>
#include <vector>

#include "engine/contact/features/body_features.h"
#include "engine/contact/features/round_features.h"
#include "engine/contact/field/field_schedule.h"
#include "engine/contact/field/round_contacts.h"
#include "engine/contact/pair/body_pair.h"
#include "engine/contact/pair/contact_forces.h"
#include "engine/contact/pair/tangent_plane.h"
#include "engine/field/query/distance_field.h"

namespace tandem {

/// Voxels of depth from which a contact has its full stiffness.
inline constexpr double kFullStiffnessDepth = 0.1;

/// The surface of a body for refined contact.
struct BodySurface {
  DistanceField field;
  BodyFeatures features;  // in the field's frame V
  RoundFeatures rounds;   // its balls and cylinders
  Pose X_BV;
  /// Largest distance of its surface from its frame's origin, m; 0: it never moves.
  double radius = 0;
};

/// Two bodies with exact surfaces (decision 0041). The features of each are looked up in the
/// other's distance field, and sharp edges that cross are met in closed form. Force begins at
/// kRefinedClearance from the surface, less the shell's shift, or where the clearance says.
class FieldPair final : public BodyPair {
 public:
  struct Options {
    bool both_move = false;   // both bodies move: cross() is kept
    double inward_shift = 0;  // shift of the shell's surface along its inward normals, voxels
    ScheduleOptions schedule{};
  };
  /// Both surfaces must have the same voxel size, and outlive the pair.
  FieldPair(const BodySurface& shell, const BodySurface& map, const Options& options,
            const ContactGains& gains);

  PairReport Collide(const BodyMotion& shell_body, const BodyMotion& map_body,
                     LinearizedForce& on_shell, LinearizedForce& on_map) noexcept override;
  TestDemand test_demand() const noexcept override { return demand_; }
  void SetClearance(const Clearance& clearance) noexcept override;
  ClearanceBounds clearance_bounds() const noexcept override;
  double voxel_size() const noexcept override { return s_; }
  Pose X_BV() const noexcept override { return map_->X_BV; }
  PoseReading Read(const BodyMotion& shell_body, const BodyMotion& map_body) noexcept override;
  std::span<const Contact> contacts() const noexcept override {
    return {contacts_.data(), contact_count_};
  }

  /// Counts the feature points of either body within the reach of the other that the last
  /// Collide(), at the same poses, did not find. For tests and benches; allocates.
  std::size_t CountUnfound(const BodyMotion& shell_body, const BodyMotion& map_body) const;
  /// Returns the number of feature points of both bodies.
  std::size_t point_count() const noexcept {
    return shell_->features.point_count() + map_->features.point_count();
  }

 private:
  /// The places of both fields, in voxels: X_VF of the schedules.
  struct Places {
    Pose shell_in_map;
    Pose map_in_shell;
    PairPlaces pair;
  };
  Places PlacesOf(const BodyMotion& shell_body, const BodyMotion& map_body) const noexcept;
  /// Returns how the shell's body moved against the map since the last call.
  PairMotion MotionSince(const Pose& X_VS) noexcept;
  void FindContacts(const Places& places, bool shell_rolls, bool map_rolls) noexcept;
  /// One body whose features are looked up in the other's field.
  struct Direction {
    const BodySurface& own;
    const BodySurface& other;
    const Pose& X_VF;
    const Pose& shell_in_map;
    bool to_map;  // the other is the map
    bool rounds;  // own round surfaces push where they face the other
  };
  /// Returns the distance up to which features of a body are looked up, voxels.
  double LookUpReach(const BodySurface& own, const BodySurface& other, bool rolls) const noexcept;
  /// Finds the contacts of one body's features with the other's field.
  void CollideField(const FieldSchedule& schedule, const Direction& in) noexcept;
  /// Finds those of the features that lie on round surfaces, or of the others, looked up as far as
  /// `reach`. All are others if no round surface pushes where it faces.
  void CollidePoints(const FieldSchedule& schedule, const Direction& in, bool on_rounds,
                     double reach) noexcept;
  /// Finds the contacts of round surfaces where they face the other body.
  void CollideFacing(const Direction& in) noexcept;
  /// A feature point that is near the other's surface, in the frame V of the other's field.
  struct TouchingPoint {
    Vec3 inward_V;
    std::optional<Vec3> tangent_V{};  // tangent of a sharp edge's part
    double weight;
    std::uint8_t round = RoundFeatures::kNone;
  };
  /// Calls visit(push) for the pushes that count on a point, turned back where it has come through
  /// a wall.
  template <class Visit>
  static void VisitPushes(const TouchingPoint& point, const Vec3& place_V,
                          std::span<const FieldPush> pushes, const DistanceField& field,
                          const Visit& visit) noexcept;
  /// Adds the contact of a place that the other body pushes.
  void AddPush(const Vec3& place_V, const FieldPush& push, double share,
               const Direction& in) noexcept;
  void CollideEdges(const Pose& shell_in_map) noexcept;
  /// Keeps a contact if it has depth. Lengths are in voxels.
  void Add(const Vec3& p_V, const Vec3& nhat_V, double depth, double share) noexcept;
  /// Adds the loads of the contacts. Stiffness is in proportion to the contacts' sum, up to a
  /// bound.
  void AddForces(const Places& places, LinearizedForce& on_shell, LinearizedForce& on_map) noexcept;
  void CountDemand() noexcept;

  const BodySurface* shell_;
  const BodySurface* map_;
  double s_;  // voxel size, m
  bool both_move_;
  ContactGains gains_;
  double inward_shift_;     // voxels
  double full_reach_ = 0;   // reach where there is room, voxels
  double reach_ = 0;        // reach in this fit, voxels
  FieldSchedule of_shell_;  // the shell's features in the map's field
  FieldSchedule of_map_;
  std::optional<Pose> X_VS_;  // at the last Collide()
  std::vector<Contact> contacts_;
  std::size_t contact_count_ = 0;
  RoundContacts round_contacts_;
  std::size_t round_queries_ = 0;  // places looked up for round_contacts_
  bool over_capacity_ = false;
  TestDemand demand_;  // as of the last Collide()
};

}  // namespace tandem
