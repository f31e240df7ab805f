#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "engine/base/files/image_bytes.h"
#include "engine/field/query/distance_field.h"

namespace tandem {

/// The layout of the block of bytes that holds a distance field. It means the same wherever it
/// lies:
///
///   header       | the number of entries of each array
///   hyperbricks  | int32 each, x fastest: number of a table, or a bound
///   first bricks | uint32 per table: the number of its first brick
///   tables       | int16 per brick of a table's hyperbrick; one more, which the kernel reads
///   bricks       | FieldBrick each
///   steps        | the bricks' steps and lists (FieldLists); four bytes more
///   list faces   | uint32 each: numbers of faces
///   faces        | three corners each
///
/// Each array begins on a cache line behind the previous one, so the counts alone tell the places.
struct FieldHeader {
  double voxel_size = 0;  // m
  double band = 0;        // voxels, as all lengths below
  double range = 0;
  double error_bound = 0;
  double outer_error_bound = 0;
  double most_over = 0;                 // greatest excess of an interpolated value
  std::array<double, 3> faces_min_L{};  // box of all faces
  std::array<double, 3> faces_max_L{};
  GridIndex origin;  // voxels from W's origin
  GridIndex size;    // hyperbricks
  std::uint64_t tables = 0;
  std::uint64_t bricks = 0;
  std::uint64_t step_bytes = 0;
  std::uint64_t list_faces = 0;
  std::uint64_t faces = 0;
  std::uint64_t bytes = 0;  // size of the block
};
static_assert(sizeof(FieldHeader) == 168);

/// Makes the blocks of distance fields, and checks blocks that come from elsewhere.
class FieldImage {
 public:
  /// A field in the making. Pack() fills in the header's counts from the arrays.
  struct Parts {
    FieldHeader header;
    std::vector<std::int32_t> hyperbricks;
    std::vector<std::uint32_t> first_bricks;
    std::vector<std::int16_t> tables;
    std::vector<FieldBrick> bricks;
    std::vector<std::uint8_t> steps;
    std::vector<std::uint32_t> list_faces;
    std::vector<DistanceField::Face> faces;
  };
  static DistanceField Pack(Parts parts);

  /// Returns the field of a block from an untrusted source; nothing, if reading it could leave the
  /// block or find values that no field has.
  static std::optional<DistanceField> Read(ImageBlock block);

 private:
  friend class DistanceField;

  struct Places {
    std::uint64_t hyperbricks, first_bricks, tables, bricks, steps, list_faces, faces, bytes;
  };
  static Places PlacesOf(const FieldHeader& header);
  static bool IsSound(const FieldHeader& header);
  static bool TablesAreSound(const DistanceField& field);
  static bool BricksAreSound(const DistanceField& field);
  static bool IsSound(const DistanceField& field, const FieldBrick& brick);
  static bool ListsAreSound(const DistanceField& field, const FieldBrick& brick);
  static bool FacesAreSound(const DistanceField& field);
};

}  // namespace tandem
