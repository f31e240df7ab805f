#include "scenes/generators/thread.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numbers>

#include "engine/base/check.h"

namespace tandem {
namespace {

constexpr std::size_t kRows = 4;  // rows of vertices of a ridge's section
constexpr double kRise = 0.5;     // turns

// Returns the height of the ridge at that turn, as a share.
double Height(const Thread& thread, double turn) {
  return std::clamp(std::min(turn - 1, thread.turns - 1 - turn) / kRise, 0.0, 1.0);
}

// Vertices of a surface between loops, each with `sides` points, and the triangles between them.
class Surface {
 public:
  explicit Surface(std::size_t sides) : sides_(sides) {}

  /// Returns the number of a loop's first vertex.
  std::size_t Add(const Loop& loop) {
    TANDEM_CHECK(loop.size() == sides_);
    const std::size_t first = mesh_.vertices.size();
    mesh_.vertices.insert(mesh_.vertices.end(), loop.begin(), loop.end());
    return first;
  }
  void Triangle(std::size_t a, std::size_t b, std::size_t c) {
    mesh_.triangles.push_back({static_cast<std::uint32_t>(a), static_cast<std::uint32_t>(b),
                               static_cast<std::uint32_t>(c)});
  }
  /// Adds the quad between the points i and i + 1 of a lower loop and of an upper one.
  void Quad(std::size_t lower, std::size_t upper, std::size_t i) {
    const std::size_t j = (i + 1) % sides_;
    Triangle(lower + i, lower + j, upper + j);
    Triangle(lower + i, upper + j, upper + i);
  }
  void Band(std::size_t lower, std::size_t upper) {
    for (std::size_t i = 0; i < sides_; ++i) Quad(lower, upper, i);
  }
  void Cap(std::size_t loop, bool upwards) {
    Vec3 middle = Vec3::Zero();
    for (std::size_t i = 0; i < sides_; ++i) {
      middle += mesh_.vertices[loop + i] / static_cast<double>(sides_);
    }
    const std::size_t centre = mesh_.vertices.size();
    mesh_.vertices.push_back(middle);
    for (std::size_t i = 0; i < sides_; ++i) {
      const std::size_t j = (i + 1) % sides_;
      Triangle(loop + (upwards ? i : j), loop + (upwards ? j : i), centre);
    }
  }
  const TriangleMesh& mesh() const { return mesh_; }

 private:
  std::size_t sides_;
  TriangleMesh mesh_;
};

/// Adds the rows of points along the thread. Row m goes round once, and row m + 4 goes on where it
/// ends.
std::vector<std::size_t> AddRows(const Thread& thread, Surface& surface) {
  const auto sides = static_cast<std::size_t>(thread.sides);
  std::vector<std::size_t> rows;
  for (std::size_t m = 0; m < kRows * static_cast<std::size_t>(thread.turns); ++m) {
    const std::array<double, kRows> widths = {-thread.foot_width, -thread.crest_width,
                                              thread.crest_width, thread.foot_width};
    const bool crest = m % kRows == 1 || m % kRows == 2;
    Loop row;
    for (std::size_t i = 0; i < sides; ++i) {
      const double share = static_cast<double>(i) / thread.sides;
      const double turn = static_cast<double>(m / kRows) + share;
      const double up = crest ? Height(thread, turn) : 0;
      const double radius = thread.foot_radius + up * (thread.crest_radius - thread.foot_radius);
      const double angle = 2 * std::numbers::pi * share;
      row.emplace_back(radius * std::cos(angle), radius * std::sin(angle),
                       thread.start + thread.pitch * turn + 0.5 * widths.at(m % kRows));
    }
    rows.push_back(surface.Add(row));
  }
  return rows;
}

void AddFlanks(const std::vector<std::size_t>& rows, std::size_t sides, Surface& surface) {
  const std::size_t end = sides - 1;
  for (std::size_t m = 0; m + 1 < rows.size(); ++m) {
    for (std::size_t i = 0; i < end; ++i) surface.Quad(rows[m], rows[m + 1], i);
    if (m + kRows + 1 >= rows.size()) continue;
    const std::size_t next = rows[m + kRows];
    const std::size_t after = rows[m + kRows + 1];
    surface.Triangle(rows[m] + end, next, after);
    surface.Triangle(rows[m] + end, after, rows[m + 1] + end);
  }
}

/// Joins the thread's ends to the circles below and above. The first turn hangs over the circle
/// below and the last stands out over its own end, so that between the last point of a turn and the
/// first of the next there is a fan of triangles.
void AddEnds(const std::vector<std::size_t>& rows, std::size_t sides, std::size_t bottom,
             std::size_t top, Surface& surface) {
  const std::size_t end = sides - 1;
  const std::size_t first = rows.front();
  const std::size_t last = rows.back();
  for (std::size_t i = 0; i < end; ++i) {
    surface.Quad(bottom, first, i);
    surface.Quad(last, top, i);
  }
  for (std::size_t m = 0; m < kRows; ++m) {
    surface.Triangle(first + end, rows[m], rows[m + 1]);
    const std::size_t under = rows[rows.size() - 1 - kRows + m];
    surface.Triangle(last, rows[rows.size() - kRows + m] + end, under + end);
  }
  surface.Triangle(first + end, bottom, first);
  surface.Triangle(first + end, bottom + end, bottom);
  surface.Triangle(last, top + end, last + end);
  surface.Triangle(last, top, top + end);
}

}  // namespace

TriangleMesh Threaded(const Thread& thread, const std::vector<Loop>& below,
                      const std::vector<Loop>& above, SkinEnds ends) {
  TANDEM_CHECK(thread.turns >= 3 && !below.empty() && !above.empty());
  const auto sides = static_cast<std::size_t>(thread.sides);
  Surface surface(sides);
  std::vector<std::size_t> low;
  std::vector<std::size_t> high;
  for (const Loop& loop : below) low.push_back(surface.Add(loop));
  for (const Loop& loop : above) high.push_back(surface.Add(loop));

  const std::vector<std::size_t> rows = AddRows(thread, surface);
  AddFlanks(rows, sides, surface);
  AddEnds(rows, sides, low.back(), high.front(), surface);

  for (std::size_t k = 0; k + 1 < low.size(); ++k) surface.Band(low[k], low[k + 1]);
  for (std::size_t k = 0; k + 1 < high.size(); ++k) surface.Band(high[k], high[k + 1]);
  if (ends == SkinEnds::kJoined) {
    surface.Band(high.back(), low.front());
  } else {
    surface.Cap(low.front(), false);
    surface.Cap(high.back(), true);
  }
  return TurnedOutward(surface.mesh());
}

}  // namespace tandem
