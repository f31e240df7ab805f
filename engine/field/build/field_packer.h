#pragma once

#include <cstdint>
#include <vector>

#include "engine/base/result.h"
#include "engine/field/build/built_bricks.h"
#include "engine/field/build/face_distance.h"
#include "engine/field/query/field_image.h"

namespace tandem {

/// Puts hyperbricks one after another into the arrays of a field.
class FieldPacker {
 public:
  /// `faces` are those that lists name by number; they must outlive it.
  FieldPacker(const FieldHeader& header, const std::vector<FieldFace>& faces);

  const FieldHeader& header() const noexcept { return field_.header; }
  /// Appends a hyperbrick, x fastest. One with bricks is empty afterwards.
  void Store(BuiltHyperbrick& hyperbrick);
  /// Makes the field of all that is stored.
  Result<DistanceField> Pack();

 private:
  void Store(const BuiltBrick& brick);
  void StoreLists(const BuiltLists& cells);
  /// Returns the number among the stored faces of a face that a list names.
  std::uint32_t Keep(std::uint32_t face);

  const std::vector<FieldFace>& faces_;
  std::vector<std::uint32_t> kept_;  // per face: its number in the field, or ~0
  FieldImage::Parts field_;
};

}  // namespace tandem
