#include "engine/geometry/formats/raw_mesh.h"

#include <algorithm>
#include <cerrno>
#include <cstring>

#include <unistd.h>

namespace tandem {
namespace {

constexpr std::uint64_t kMagic = 0x0448'5345'4d44'4e54;  // "TNDMESH", 4

struct StreamHeader {
  std::uint64_t magic;
  std::uint64_t kind;
  std::uint64_t words;
  std::uint64_t points;
  std::uint64_t triangles;
  std::uint64_t remarks;  // bytes, each remark ends a line
  std::uint64_t single_precision;
  std::uint64_t unit_of_format;
  double metres_per_unit;
  double remarked_unit;
};
static_assert(sizeof(FilePoint) == 24 && sizeof(TriangleMesh::Triangle) == 12);

bool WriteAll(int fd, const void* data, std::size_t size) {
  const char* at = static_cast<const char*>(data);
  while (size > 0) {
    const ssize_t written = write(fd, at, size);
    if (written < 0 && errno == EINTR) continue;
    if (written <= 0) return false;
    at += written;
    size -= static_cast<std::size_t>(written);
  }
  return true;
}

/// Takes `count` elements off the front of `bytes`.
template <typename Container>
void Take(std::string_view& bytes, std::uint64_t count, Container& into) {
  into.resize(count);
  const std::size_t size = count * sizeof(typename Container::value_type);
  if (size > 0) std::memcpy(into.data(), bytes.data(), size);
  bytes.remove_prefix(size);
}

}  // namespace

bool WriteAnswer(int fd, const ReadAnswer& answer) {
  const RawMesh& mesh = answer.mesh;
  std::string remarks;
  for (const std::string& remark : answer.remarks) remarks += remark + '\n';
  const StreamHeader header{kMagic,
                            static_cast<std::uint64_t>(answer.kind),
                            answer.words.size(),
                            mesh.points.size(),
                            mesh.triangles.size(),
                            remarks.size(),
                            answer.single_precision ? 1U : 0U,
                            answer.unit_of_format ? 1U : 0U,
                            answer.metres_per_unit,
                            answer.remarked_unit};
  return WriteAll(fd, &header, sizeof header) &&
         WriteAll(fd, answer.words.data(), answer.words.size()) &&
         WriteAll(fd, remarks.data(), remarks.size()) &&
         WriteAll(fd, mesh.points.data(), mesh.points.size() * sizeof(FilePoint)) &&
         WriteAll(fd, mesh.triangles.data(),
                  mesh.triangles.size() * sizeof(TriangleMesh::Triangle));
}

std::optional<ReadAnswer> ParseAnswer(std::string_view bytes) {
  StreamHeader header{};
  if (bytes.size() < sizeof header) return std::nullopt;
  std::memcpy(&header, bytes.data(), sizeof header);
  bytes.remove_prefix(sizeof header);
  // refuses counts beyond the bytes at hand before it multiplies them
  const std::uint64_t size = bytes.size();
  if (header.magic != kMagic || header.kind > 2 || header.words > size || header.points > size ||
      header.triangles > size || header.remarks > size ||
      header.words + header.remarks + sizeof(FilePoint) * header.points +
              sizeof(TriangleMesh::Triangle) * header.triangles !=
          size) {
    return std::nullopt;
  }
  ReadAnswer answer;
  answer.kind = static_cast<ReadAnswer::Kind>(header.kind);
  answer.metres_per_unit = header.metres_per_unit;
  answer.remarked_unit = header.remarked_unit;
  answer.single_precision = header.single_precision != 0;
  answer.unit_of_format = header.unit_of_format != 0;
  Take(bytes, header.words, answer.words);
  std::string remarks;
  Take(bytes, header.remarks, remarks);
  for (std::size_t at = 0; at < remarks.size();) {
    const std::size_t end = std::min(remarks.find('\n', at), remarks.size());
    answer.remarks.push_back(remarks.substr(at, end - at));
    at = end + 1;
  }
  Take(bytes, header.points, answer.mesh.points);
  Take(bytes, header.triangles, answer.mesh.triangles);
  return answer;
}

}  // namespace tandem
