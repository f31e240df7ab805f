#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "engine/geometry/mesh/triangle_mesh.h"

namespace tandem {

/// A position in a file, in its units.
using FilePoint = std::array<double, 3>;

/// Triangles as a file holds them: not welded, in file units, not yet checked.
struct RawMesh {
  std::vector<FilePoint> points;
  std::vector<TriangleMesh::Triangle> triangles;
};

/// The answer of the reading process.
struct ReadAnswer {
  enum class Kind : std::uint32_t { kMesh, kRefused, kOutOfMemory };
  Kind kind = Kind::kRefused;
  std::string words;  // text of a refusal
  RawMesh mesh;
  double metres_per_unit = 0;     // as the file declares; 0: it does not
  bool unit_of_format = false;    // that is the format's own unit, and the file names none
  double remarked_unit = 0;       // metres per unit as a remark in the file says; 0: none does
  bool single_precision = false;  // the file holds positions as 32-bit numbers
  /// Statements of the file that the reader does not honour, one line each, for the user.
  std::vector<std::string> remarks = {};
};

/// Writes an answer into a pipe, for ParseAnswer() in a process of the same program. Returns false
/// when the reader has gone.
bool WriteAnswer(int fd, const ReadAnswer& answer);

/// Returns the answer that `bytes` are, or nothing if they are cut short or are something else.
std::optional<ReadAnswer> ParseAnswer(std::string_view bytes);

}  // namespace tandem
