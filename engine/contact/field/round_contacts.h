#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "engine/contact/features/round_features.h"
#include "engine/contact/pair/contact_model.h"
#include "engine/field/query/distance_field.h"

namespace tandem {

/// Contact of a body's balls and cylinders in one frame. A round surface pushes at the facing
/// places, those that face the other body, in place of its features. So nothing comes or goes as it
/// rolls, and neither stiffness nor damping of contact resists the roll.
///
/// Features tell in which directions a round surface touches: Take() adds each to the nodes of a
/// lattice about its direction, by shares that change steadily as the direction does. A cylinder's
/// lattice has a layer for each voxel of its length. Each node that has weight has one facing
/// place. The nodes of one direction share one push. Features lose what the places deliver, and no
/// more: off edges, corners and sheets, deep in a body, and where a round surface touches all
/// round, features push as always. Lengths are in voxels, places in the frame V of the other body's
/// field.
class RoundContacts {
 public:
  /// For a pair of bodies with room for `contacts`. Only the constructor allocates.
  RoundContacts(const RoundFeatures& one, const RoundFeatures& other, std::size_t contacts);

  /// Begins with the features of a body that stands at X_VF. They are looked up as far as `wide`
  /// voxels beyond the reach. `strength`: the share of all pushes that facing places may bear.
  void Begin(const RoundFeatures& features, const Pose& X_VF, double wide,
             double strength) noexcept;
  /// Sees the push on a feature of a round. `depth`: of its contact, which has the number
  /// `contact`; kNoContact: it has none.
  static constexpr std::size_t kNoContact = ~std::size_t{0};
  void Take(std::uint8_t round, const Vec3& place_V, const FieldPush& push, double depth,
            std::size_t contact) noexcept;

  /// A place of a round surface that faces the other body.
  struct Facing {
    Vec3 place_V;
    Vec3 away_V;  // unit, off the other body
    std::uint32_t node = 0;
    double share = 0;  // share of its push
  };
  /// Calls visit(facing) for all facing places. All features have been taken.
  template <class Visit>
  void VisitFacing(const Visit& visit) noexcept {
    for (const std::uint32_t group : groups_) {
      Share(group);
      for (std::uint32_t n = heads_[group]; n != kNone; n = nodes_[n].next) {
        if (nodes_[n].share > 0) visit(FacingAt(n));
      }
    }
  }
  /// Returns the share of a push on a facing place that counts, for a push of `depth`. What it
  /// delivers is remembered.
  double Deliver(const Facing& facing, const FieldPush& push, double depth) noexcept;
  /// Reduces the contacts of the features by what facing places delivered. Leaves those out, from
  /// number `first` on, that have no share. Returns how many contacts there are then.
  std::size_t Reduce(std::span<Contact> contacts, std::size_t first) const noexcept;

 private:
  static constexpr std::uint32_t kNone = ~0U;
  static constexpr int kCells = 8;  // the lattice's, for a component of a direction
  static constexpr std::uint32_t kSide = kCells + 1;

  struct Node {
    Vec3 sum_V = Vec3::Zero();  // sum of directions, weighted
    double weight = 0;
    std::uint32_t group = 0;
    std::uint32_t next = kNone;       // the next of its group
    std::uint32_t counts_as = kNone;  // the node of its group that has the same direction
    double share = 0;                 // share of a push on its facing place
    double fullness = 0;              // share of pushes in its direction that places replace
    double delivered = 0;             // sum of shares
    double delivered_depth = 0;       // sum of depths, weighted by shares
  };
  /// The nodes about a direction, and its shares in them.
  struct Splat {
    std::array<std::uint32_t, 8> nodes;
    std::array<double, 8> shares;
  };
  struct Taken {
    std::size_t contact = 0;
    std::uint8_t round = 0;
    double share = 0;  // share of its contact that facing places may replace
    double depth = 0;
    Vec3 direction_V;
    double along = 0;
  };
  struct Placed {
    Vec3 centre_V;
    Vec3 axis_V;
    Vec3 side_V;
    double strength = 0;
    double cap = 0;
    std::uint32_t first_node = 0;
    std::uint32_t first_group = 0;
    std::uint32_t layers = 0;
    double step = 0;  // between the layers of a cylinder
  };

  static std::uint32_t LayersOf(const RoundSurface& surface) noexcept;
  Splat SplatOf(std::uint8_t round, const Vec3& direction_V, double along) const noexcept;
  std::uint32_t GroupOf(std::uint8_t round, std::uint32_t node) const noexcept;
  /// Adds a feature's weight to the nodes about its direction: of a cylinder in all layers that it
  /// tells of.
  void AddWeight(std::uint8_t round, double weight, const Vec3& direction_V, double along) noexcept;
  /// Adds a weight to the nodes that are `farther` than those of a splat.
  void AddTo(std::uint8_t round, const Splat& splat, std::uint32_t farther, double weight,
             const Vec3& direction_V) noexcept;
  /// Shares out the push of each direction among the nodes of a group.
  void Share(std::uint32_t group) noexcept;
  /// Lets nodes of a group with the same direction count as one.
  void Unite(std::uint32_t group) noexcept;
  Facing FacingAt(std::uint32_t node) const noexcept;

  const RoundFeatures* features_ = nullptr;
  std::array<Placed, RoundFeatures::kMostRounds> placed_;
  std::vector<Node> nodes_;
  std::vector<std::uint32_t> heads_;    // per group: its first node
  std::vector<std::uint8_t> round_of_;  // per group
  std::vector<std::uint32_t> groups_;   // groups that have nodes with weight
  std::vector<std::uint32_t> weighty_;  // nodes with weight
  /// Features with contacts. Those for which there is no room keep their push; then it touches all
  /// round.
  static constexpr std::size_t kMostTaken = std::size_t{1} << 15U;
  std::vector<Taken> taken_;
  std::size_t most_taken_ = 0;
};

}  // namespace tandem
