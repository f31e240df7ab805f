#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "engine/contact/features/round_features.h"
#include "engine/contact/pair/contact_model.h"
#include "engine/field/query/distance_field.h"

namespace tandem {

/// Contact of a body's balls and cylinders in one frame. The places of a round surface that face
/// the other body push in place of its features. So nothing comes or goes as it rolls, and neither
/// stiffness nor damping of contact resists the roll.
///
/// Features tell on which sides a round surface touches: Take() sees their pushes. A side has the
/// mean direction of the pushes of the features that face it. A ball has one place on a side, a
/// cylinder a row of places. Off edges and corners, features push as always. Lengths are in voxels,
/// places in the frame V of the other body's field.
class RoundContacts {
 public:
  /// `contacts`: the number of contacts that there is room for. Only the constructor allocates.
  explicit RoundContacts(std::size_t contacts) : taken_(contacts) {}

  /// Begins with the features of a body that stands at X_VF.
  void Begin(const RoundFeatures& features, const Pose& X_VF) noexcept;
  /// Sees the push on a feature of a round. `contact`: the number of its contact, or kNoContact.
  static constexpr std::size_t kNoContact = ~std::size_t{0};
  void Take(std::uint8_t round, const Vec3& place_V, const FieldPush& push,
            std::size_t contact) noexcept;
  /// Says that a contact is not one of a round's feature.
  void Leave(std::size_t contact) noexcept { taken_[contact] = {}; }
  /// Reduces the contacts from number `first` on by what the rounds' places bear. Returns how many
  /// contacts there are then.
  std::size_t Reduce(std::span<Contact> contacts, std::size_t first) const noexcept;

  /// A place of a round surface that faces the other body.
  struct Facing {
    Vec3 place_V;
    Vec3 away_V;       // unit, off the other body
    double share = 0;  // share of its push
  };
  /// Calls visit(facing) for all places that face the other body.
  template <class Visit>
  void VisitFacing(const Visit& visit) const noexcept {
    for (std::size_t s = 0; s < side_count_; ++s) {
      const double share = Strength(s);
      if (share <= 0) continue;
      const Row row = RowOf(sides_[s]);
      for (std::size_t k = row.first; k < row.end; ++k) {
        visit(Facing{row.begin_V + static_cast<double>(k) * row.step_V, row.away_V, share});
      }
    }
  }
  /// Returns the share of a push on such a place that counts, 0 off edges and corners.
  static double ShareOf(const Facing& facing, const FieldPush& push) noexcept;

 private:
  static constexpr std::size_t kMostSides = 32;
  /// The most sides on which one round surface touches. With more it lies in a hollow that holds it
  /// all round, and its features push.
  static constexpr int kMostSidesOfOne = 6;

  struct Side {
    std::uint8_t round = 0;
    Vec3 first_V = Vec3::Zero();
    Vec3 sum_V = Vec3::Zero();
    double weight = 0;
    double low = 0;  // along a cylinder's axis, where features touch
    double high = 0;
  };
  struct Taken {
    std::int32_t side = -1;
    double share = 0;
  };
  struct Placed {
    Vec3 centre_V;
    Vec3 axis_V;
  };
  /// A row of places: k from `first` to `end`.
  struct Row {
    Vec3 begin_V;
    Vec3 step_V;
    Vec3 away_V;
    std::size_t first = 0;
    std::size_t end = 1;
  };

  double Strength(std::size_t side) const noexcept;
  Row RowOf(const Side& side) const noexcept;

  const RoundFeatures* features_ = nullptr;
  std::array<Placed, RoundFeatures::kMostRounds> placed_;
  std::array<int, RoundFeatures::kMostRounds> sides_of_{};
  std::array<Side, kMostSides> sides_;
  std::size_t side_count_ = 0;
  std::vector<Taken> taken_;  // per contact
};

}  // namespace tandem
