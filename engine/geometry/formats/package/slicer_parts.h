#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "engine/base/result.h"
#include "engine/geometry/formats/package/zip_archive.h"

namespace tandem {

/// The use of a part by a slicer.
enum class PartUse : std::uint8_t {
  kShape,     // the part is material
  kLeftOut,   // it changes settings or supports, and is no material
  kNegative,  // it takes material away
};

/// The uses of a 3MF file's parts, as slicers write them beside its first model.
struct SlicerParts {
  /// A range of an object's triangles, both ends included.
  struct Range {
    std::uint64_t first = 0, last = 0;
    PartUse use = PartUse::kShape;
  };
  std::map<std::string, std::vector<Range>> ranges_of;                 // by object
  std::map<std::pair<std::string, std::string>, PartUse> use_of_part;  // by object and component

  PartUse UseOf(const std::string& object, const std::string& component) const;
};

/// Returns the use that a word such as "ParameterModifier" or "negative_part" names.
PartUse PartUseNamed(const std::string& word);

/// Reads the files of settings in an archive; it may have none. An error, one line: one of them is
/// damaged, so that nobody knows what is material.
Result<SlicerParts> ReadSlicerParts(const ZipArchive& archive);

}  // namespace tandem
