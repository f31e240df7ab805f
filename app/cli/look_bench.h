#pragma once

#include <array>
#include <vector>

#include "engine/contact/refined_contacts.h"

namespace tandem {

/// Points of a body laid beside a map's surface, here and there, to time exact looks with: most of
/// those that a frame looks at are near contact and do not push. Where the map has a vertex a point
/// of the body's surface, where it has an edge one of its edges, else a vertex, as frames have it.
class LookBench {
 public:
  /// `shell`, `voxmap` and `details` must outlive it; none of them empty.
  LookBench(const Pointshell& shell, const Voxmap& voxmap, const SurfaceDetails& details);

  std::size_t size() const noexcept { return candidates_.size(); }
  /// Looks at all of them, as at points of which nothing is known yet.
  void LookAtAll() noexcept;

 private:
  struct Point {
    std::uint32_t point;
    std::uint32_t edge;  // of an edge point: into Pointshell::edges
  };
  using Points = std::array<std::vector<Point>, kFields>;  // by Label

  static Points SomeOfEach(const Pointshell& shell);
  void LayOn(const Points& points, const Voxmap& voxmap, const SurfaceDetails& details,
             const GridIndex& chunk_V);

  std::vector<Candidate> candidates_;
  std::vector<Contact> contacts_;
  RefinedContacts refined_;
};

}  // namespace tandem
