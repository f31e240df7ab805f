#include "engine/field/build/field_packer.h"

#include <algorithm>
#include <limits>
#include <utility>

namespace tandem {

FieldPacker::FieldPacker(const FieldHeader& header, const std::vector<FieldFace>& faces)
    : faces_(faces), kept_(faces.size(), ~0U) {
  field_.header = header;
}

Result<DistanceField> FieldPacker::Pack() {
  // the kernel counts bytes in 32 bits
  constexpr std::size_t kMost = std::numeric_limits<std::int32_t>::max() - 64;
  if (field_.steps.size() > kMost) {
    return Error{"the steps of the field would need more than 2 GiB; take larger voxels"};
  }
  return FieldImage::Pack(std::move(field_));
}

void FieldPacker::Store(BuiltHyperbrick& hyperbrick) {
  field_.header.error_bound = std::max(field_.header.error_bound, hyperbrick.within_band);
  field_.header.outer_error_bound = std::max(field_.header.outer_error_bound, hyperbrick.beyond);
  if (hyperbrick.entries.empty()) {
    field_.hyperbricks.push_back(hyperbrick.bound);
    return;
  }
  field_.hyperbricks.push_back(static_cast<std::int32_t>(field_.first_bricks.size()));
  field_.first_bricks.push_back(static_cast<std::uint32_t>(field_.bricks.size()));
  for (const std::int32_t entry : hyperbrick.entries) {
    field_.tables.push_back(static_cast<std::int16_t>(entry));
  }
  for (BuiltBrick& brick : hyperbrick.bricks) Store(brick);
  hyperbrick = {};
}

void FieldPacker::Store(const BuiltBrick& brick) {
  FieldBrick stored = brick.packed.brick;
  if (brick.lists.cells != 0) {
    stored.flags |= FieldBrick::kHasLists;
    StoreLists(brick.lists);
  }
  stored.steps = static_cast<std::uint32_t>(field_.steps.size());
  field_.steps.insert(field_.steps.end(), brick.packed.steps.begin(), brick.packed.steps.end());
  field_.bricks.push_back(stored);
  field_.header.most_over =
      std::max(field_.header.most_over, static_cast<double>(stored.MostOver()));
}

void FieldPacker::StoreLists(const BuiltLists& cells) {
  std::vector<std::uint32_t> faces;  // faces of the brick
  for (const std::vector<std::uint32_t>& list : cells.faces) {
    faces.insert(faces.end(), list.begin(), list.end());
  }
  std::sort(faces.begin(), faces.end());
  faces.erase(std::unique(faces.begin(), faces.end()), faces.end());
  const FieldLists lists{cells.cells, static_cast<std::uint32_t>(field_.list_faces.size()),
                         static_cast<std::uint16_t>(faces.size())};
  for (const std::uint32_t face : faces) {
    const std::uint32_t sheet = faces_[face].sheet ? DistanceField::kSheet : 0U;
    field_.list_faces.push_back(Keep(face) | sheet);
  }
  for (std::size_t k = cells.faces.size(); k-- > 0;) {
    std::vector<std::uint8_t> list(lists.ListBytes());
    list[0] = cells.shares[k];
    list[1] = cells.overs[k];
    for (const std::uint32_t face : cells.faces[k]) {
      const auto at = static_cast<std::size_t>(std::lower_bound(faces.begin(), faces.end(), face) -
                                               faces.begin());
      list[2 + at / 8] = static_cast<std::uint8_t>(list[2 + at / 8] | 1U << at % 8);
    }
    field_.steps.insert(field_.steps.end(), list.begin(), list.end());
  }
  const auto* bytes = reinterpret_cast<const std::uint8_t*>(&lists);
  field_.steps.insert(field_.steps.end(), bytes, bytes + sizeof lists);
}

std::uint32_t FieldPacker::Keep(std::uint32_t face) {
  if (kept_[face] == ~0U) {
    kept_[face] = static_cast<std::uint32_t>(field_.faces.size());
    DistanceField::Face stored;
    for (std::size_t k = 0; k < 3; ++k) {
      stored[k] = faces_[face].corners_L[k].cast<float>();
    }
    field_.faces.push_back(stored);
  }
  return kept_[face];
}

}  // namespace tandem
