#include "engine/geometry/import/mesh_file.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <cerrno>
#include <cmath>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <limits>
#include <new>
#include <optional>
#include <string>
#include <string_view>
#include <system_error>
#include <vector>

#include <unistd.h>

#include "engine/base/files/regular_file.h"
#include "engine/geometry/formats/native_readers.h"
#include "engine/geometry/formats/raw_mesh.h"
#include "engine/geometry/import/assimp_reader.h"
#include "engine/geometry/import/declared_unit.h"
#include "engine/geometry/import/import_child.h"
#include "engine/geometry/import/import_confinement.h"
#include "engine/geometry/mesh/weld.h"

namespace tandem {
namespace {

constexpr double kFarthest = 1e7;  // m; no mock-up is larger than the Earth

/// Returns plain text, without line breaks and of a length for a person, from any source.
std::string OneLine(std::string_view words) {
  constexpr std::size_t kLongestWords = 300;
  std::string line;
  for (const char c : words) {
    const bool blank = static_cast<unsigned char>(c) <= ' ' || c == 0x7f;
    if (!blank) line += c;
    if (blank && !line.empty() && line.back() != ' ') line += ' ';
  }
  while (!line.empty() && (line.back() == ' ' || line.back() == '.')) line.pop_back();
  return PlainLine(line, kLongestWords);
}

std::string Number(double x) {
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "%.4g", x);
  return text.data();
}

std::string Size(std::size_t bytes) {
  const double mib = static_cast<double>(bytes) / (1 << 20);
  return mib < 1024 ? Number(mib) + " MiB" : Number(mib / 1024) + " GiB";
}

std::string SystemWords(int error_number) {
  return std::generic_category().message(error_number);
}

std::string SignalName(int signal) {
  const char* name = sigdescr_np(signal);  // the thread-safe strsignal
  return name == nullptr ? "unknown" : name;
}

/// Returns all faults of the file that are known before it is read.
std::optional<Error> FaultOf(const std::filesystem::path& file, const std::string& name) {
  std::error_code error;
  const std::filesystem::file_status status = std::filesystem::status(file, error);
  if (status.type() == std::filesystem::file_type::not_found) {
    return Error{"mesh file " + name + " does not exist: check the path"};
  }
  if (error) return Error{"cannot read mesh file " + name + ": " + error.message()};
  if (std::filesystem::is_directory(status)) {
    return Error{name + " is a directory: name a mesh file in it"};
  }
  if (!std::filesystem::is_regular_file(status)) {
    return Error{name + " is not a regular file: name a mesh file"};
  }
  if (access(file.c_str(), R_OK) != 0) {
    return Error{"cannot read mesh file " + name + ": " + SystemWords(errno)};
  }
  return std::nullopt;
}

/// Tells by the extension whether a file is of CAD programs; the mesh library reads only IFC's STEP
/// of these.
bool HoldsCadSurfaces(const std::filesystem::path& file) {
  constexpr std::array<std::string_view, 16> kEndings{
      ".step", ".stp",    ".p21",    ".igs", ".iges", ".brep",    ".sat", ".x_t",
      ".x_b",  ".sldprt", ".sldasm", ".ipt", ".prt",  ".catpart", ".jt",  ".fcstd"};
  std::string ending = file.extension().string();
  std::ranges::transform(ending, ending.begin(), [](unsigned char c) {
    return static_cast<char>(std::tolower(c));
  });
  return std::ranges::count(kEndings, ending) > 0;
}

Result<ReadAnswer> ReadInChild(const std::filesystem::path& file, const std::string& name,
                               const ImportOptions& options) {
  using End = ImportChildRun::End;
  const ImportLimits limits{options.seconds_limit, options.memory_limit_bytes};
  const ImportChildRun run = RunImportChild(file, options.part, limits);
  if (run.end == End::kNotStarted) {
    return Error{"cannot start the process that reads " + name + ": " + SystemWords(run.code)};
  }
  if (run.end == End::kTooLate || (run.end == End::kKilledBySignal && run.code == SIGXCPU)) {
    return Error{"reading " + name + " took more than " + Number(options.seconds_limit) +
                 " s: use a smaller mesh or a longer limit"};
  }
  std::optional<ReadAnswer> answer = ParseAnswer(run.answer);
  if (run.end == End::kTooMuchSaid || (answer && answer->kind == ReadAnswer::Kind::kOutOfMemory)) {
    return Error{"reading " + name + " needs more than " + Size(options.memory_limit_bytes) +
                 ": the file is damaged, or use a smaller mesh or a larger limit"};
  }
  if (run.end == End::kKilledBySignal || !answer) {
    const std::string how =
        run.end == End::kKilledBySignal
            ? std::string("signal ") + std::to_string(run.code) + ", " + SignalName(run.code)
            : "exit code " + std::to_string(run.code);
    return Error{
        "the mesh library crashed on " + name + " (" + how +
        "): the file is damaged or of a kind that it cannot read; export it as STL or OBJ"};
  }
  if (answer->kind == ReadAnswer::Kind::kRefused && HoldsCadSurfaces(file)) {
    return Error{name +
                 " holds CAD surfaces, which are not triangles: export the part from the CAD "
                 "program as STL, 3MF or OBJ"};
  }
  if (answer->kind == ReadAnswer::Kind::kRefused) {
    return Error{"cannot read " + name + " as a mesh: " + OneLine(answer->words)};
  }
  return std::move(*answer);
}

/// Keeps only the points that triangles use, in their order.
void DropUnusedPoints(RawMesh& mesh) {
  std::vector<std::uint32_t> new_index(mesh.points.size(), 0);
  for (const TriangleMesh::Triangle& t : mesh.triangles) {
    for (const std::uint32_t i : t) new_index[i] = 1;
  }
  std::uint32_t kept = 0;
  for (std::size_t i = 0; i < mesh.points.size(); ++i) {
    if (new_index[i] == 0) continue;
    mesh.points[kept] = mesh.points[i];
    new_index[i] = kept++;
  }
  mesh.points.resize(kept);
  for (TriangleMesh::Triangle& t : mesh.triangles) {
    for (std::uint32_t& i : t) i = new_index[i];
  }
}

/// Returns the fault of an answer, which is untrusted.
std::optional<Error> FaultOfMesh(const RawMesh& raw, double scale, const std::string& name) {
  if (raw.triangles.empty()) {
    return Error{name +
                 " holds no triangles that could be read: export the part's surface as a "
                 "triangle mesh"};
  }
  std::size_t not_finite = 0;
  double farthest = 0;
  for (const FilePoint& p : raw.points) {
    bool finite = true;
    for (const double x : p) {
      finite = finite && std::abs(x) <= double{std::numeric_limits<float>::max()};
      farthest = std::max(farthest, std::abs(x * scale));
    }
    not_finite += finite ? 0U : 1U;
  }
  if (not_finite > 0) {
    return Error{name + ": " + std::to_string(not_finite) + " of its " +
                 std::to_string(raw.points.size()) +
                 " vertices are infinite or not numbers: the file is damaged"};
  }
  if (farthest > kFarthest) {
    return Error{name + " reaches " + Number(farthest) +
                 " m from its origin: the file is damaged or the scale of " + Number(scale) +
                 " m per unit is wrong"};
  }
  return std::nullopt;
}

/// Positions in single precision, from a place near the mesh.
struct NearPoints {
  Vec3 origin = Vec3::Zero();
  std::vector<FloatPoint> points;
  /// Distance between neighbouring numbers of single precision where the mesh stands, over its
  /// size.
  double coarseness = 0;
};

/// Takes positions from a place near the mesh where they are far from the file's origin, as map
/// coordinates are.
NearPoints NearTheMesh(const RawMesh& raw) {
  constexpr double kFar = 8;  // sizes of the mesh
  Bounds bounds;
  for (const FilePoint& p : raw.points) bounds.Add(Vec3(p[0], p[1], p[2]));
  const double farthest = bounds.max.cwiseAbs().cwiseMax(bounds.min.cwiseAbs()).maxCoeff();
  const double size = bounds.size().norm();
  NearPoints near;
  if (size > 0 && farthest > kFar * size) near.origin = bounds.min;
  near.points.reserve(raw.points.size());
  for (const FilePoint& p : raw.points) {
    const Vec3 from = Vec3(p[0], p[1], p[2]) - near.origin;
    near.points.push_back(
        {static_cast<float>(from.x()), static_cast<float>(from.y()), static_cast<float>(from.z())});
  }
  const auto single = static_cast<float>(farthest);
  const double step =
      double{std::nextafter(single, std::numeric_limits<float>::max())} - double{single};
  near.coarseness = size > 0 ? step / size : 0;
  return near;
}

/// Makes a mesh of a sound answer, and welds it.
Result<TriangleMesh> Build(ReadAnswer& answer, double scale, const std::string& name,
                           const ImportOptions& options) {
  RawMesh& raw = answer.mesh;
  for (const TriangleMesh::Triangle& t : raw.triangles) {
    for (const std::uint32_t i : t) {
      if (i >= raw.points.size()) {
        return Error{name + ": a triangle uses vertex " + std::to_string(i) +
                     ", but there are only " + std::to_string(raw.points.size())};
      }
    }
  }
  DropUnusedPoints(raw);
  if (const auto fault = FaultOfMesh(raw, scale, name)) return *fault;
  const NearPoints near = NearTheMesh(raw);
  constexpr double kCoarse = 1e-5;
  if (answer.single_precision && near.coarseness > kCoarse) {
    answer.remarks.push_back("it stands so far from its origin that its 32-bit numbers are " +
                             Number(100 * near.coarseness) +
                             " % of its size apart: export it with its origin near the part");
  }

  const Weld weld = WeldNear(near.points, options.weld_tolerance);
  TriangleMesh mesh;
  mesh.vertices.reserve(weld.first_point.size());
  for (const std::uint32_t point : weld.first_point) {
    const FloatPoint& p = near.points[point];
    mesh.vertices.emplace_back(scale *
                               (near.origin + Vec3(double{p[0]}, double{p[1]}, double{p[2]})));
  }
  mesh.triangles = std::move(raw.triangles);
  double largest_area = 0;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    for (std::uint32_t& i : mesh.triangles[t]) i = weld.vertex_of_point[i];
    const Vec3 side = mesh.corner(t, 1) - mesh.corner(t, 0);
    largest_area = std::max(largest_area, side.cross(mesh.corner(t, 2) - mesh.corner(t, 0)).norm());
  }
  if (largest_area == 0) {
    return Error{name + ": none of its " + std::to_string(mesh.triangles.size()) +
                 " triangles has any area: the file is damaged or the weld tolerance too large"};
  }
  return mesh;
}

/// Says where the unit that is taken differs from what the file says of it.
void AddUnitRemarks(std::optional<double> scale, ReadAnswer& answer) {
  constexpr double kSame = 1e-6;
  const double declared = answer.metres_per_unit;
  if (scale && declared > 0 && std::abs(*scale / declared - 1) > kSame) {
    answer.remarks.push_back(
        (answer.unit_of_format
             ? "its format has " + Number(declared) + " m per unit where a file names no other"
             : "it declares " + Number(declared) + " m per unit") +
        ", and the scale of " + Number(*scale) + " m per unit is taken in its place");
  }
  if (!scale && !(declared > 0) && answer.remarked_unit > 0 && answer.remarked_unit != 1) {
    answer.remarks.push_back("a remark in it says " + Number(answer.remarked_unit) +
                             " m per unit, and it is read in metres: give a scale of " +
                             Number(answer.remarked_unit) + ", or of 1 if it is in metres");
  }
}

}  // namespace

Result<TriangleMesh> ImportMesh(const std::filesystem::path& file, const ImportOptions& options,
                                std::vector<std::string>* remarks) {
  const std::string name = OneLine(file.native());
  if (options.scale && (!(*options.scale > 0) || !std::isfinite(*options.scale))) {
    return Error{"the scale of " + name + " must be a number above 0, not " +
                 Number(*options.scale)};
  }
  if (!(options.weld_tolerance >= 0) || !std::isfinite(options.weld_tolerance)) {
    return Error{"the weld tolerance of " + name + " must be 0 or a number above, not " +
                 Number(options.weld_tolerance)};
  }
  if (std::optional<Error> fault = FaultOf(file, name)) return *fault;
  Result<ReadAnswer> answer = ReadInChild(file, name, options);
  if (!answer) return answer.error();
  if (!options.scale && KindDeclaresUnit(file) && !(answer->metres_per_unit > 0)) {
    return Error{name +
                 ": the unit that it declares cannot be read: give a \"scale\", in metres "
                 "per unit of the file (0.001 for millimetres)"};
  }
  AddUnitRemarks(options.scale, *answer);
  const double declared = answer->metres_per_unit > 0 ? answer->metres_per_unit : 1.0;
  Result<TriangleMesh> mesh = Build(*answer, options.scale.value_or(declared), name, options);
  if (mesh && remarks != nullptr) {
    for (const std::string& remark : answer->remarks) remarks->push_back(OneLine(remark));
  }
  return mesh;
}

void RunImportHelperIfAsked(int argc, char** argv) {
  const std::optional<ImportJob> job = ImportJobOf(argc, argv);
  if (!job) return;
  ConfineTo(job->limits);
  ConfineToFile(job->file);
  NoteWhenMemoryRunsOut();
  bool delivered = false;
  try {
    std::optional<ReadAnswer> answer = ReadNatively(job->file, job->part);
    if (!answer) answer = ReadWithAssimp(job->file.native(), job->part);
    delivered = WriteAnswer(job->answer_fd, *answer);
  } catch (const std::bad_alloc&) {
    delivered = WriteAnswer(job->answer_fd, {ReadAnswer::Kind::kOutOfMemory, {}, {}, 0});
  }
  _exit(delivered ? 0 : 1);  // the program's cleanup has nothing to clean up
}

}  // namespace tandem
