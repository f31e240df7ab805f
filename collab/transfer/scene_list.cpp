#include "collab/transfer/scene_list.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <set>
#include <string_view>
#include <utility>

#include <zstd.h>

#include "collab/transfer/file_messages.h"
#include "engine/base/check.h"

namespace tandem {

namespace {

constexpr std::string_view kBegin = "tandem files 1\n";
constexpr std::size_t kFileHead = 1 + 8 + 32;  // kind, size, digest
constexpr int kLevel = 1;                      // Zstandard's level

// The index of a kind travels in lists, so new kinds are added at the end.
constexpr std::array<std::string_view, 22> kKinds{
    ".json", ".stl", ".obj", ".ply", ".off",  ".3mf", ".glb", ".gltf", ".dae", ".fbx",  ".3ds",
    ".x3d",  ".wrl", ".amf", ".dxf", ".x3db", ".lwo", ".ac",  ".ase",  ".b3d", ".ms3d", ".blend"};

template <typename T>
void Append(std::vector<char>& out, T value) {
  for (std::size_t i = 0; i < sizeof value; ++i) {
    out.push_back(static_cast<char>((std::uint64_t{value} >> (8 * i)) & 0xFFU));
  }
}

void Append(std::vector<char>& out, const Sha256& digest) {
  const auto* begin = reinterpret_cast<const char*>(digest.data());
  out.insert(out.end(), begin, begin + digest.size());
}

/// Takes values from the front of the remaining bytes; the caller has checked their number.
class Front {
 public:
  explicit Front(std::span<const char> bytes) : rest_(bytes) {}
  std::size_t size() const { return rest_.size(); }
  template <typename T>
  T Take() {
    std::uint64_t value = 0;
    for (std::size_t i = 0; i < sizeof(T); ++i) {
      value |= std::uint64_t{static_cast<unsigned char>(rest_[i])} << (8 * i);
    }
    rest_ = rest_.subspan(sizeof(T));
    return static_cast<T>(value);
  }
  Sha256 TakeDigest() {
    Sha256 digest{};
    std::memcpy(digest.data(), rest_.data(), digest.size());
    rest_ = rest_.subspan(digest.size());
    return digest;
  }

 private:
  std::span<const char> rest_;
};

Error Refused(const std::string& why) {
  return Error{"the list of files that was sent is refused: " + why};
}

}  // namespace

std::uint64_t SceneList::total_bytes() const {
  std::uint64_t sum = 0;
  for (const ListedFile& file : files) sum += file.bytes;
  return sum;
}

std::uint32_t SceneList::pieces() const {
  std::size_t sum = 0;
  for (const ListedFile& file : files) sum += file.pieces.size();
  return static_cast<std::uint32_t>(sum);
}

bool IsSceneFileKind(std::string_view kind) {
  return std::ranges::find(kKinds, kind) != kKinds.end();
}

std::uint32_t PiecesOf(std::uint64_t bytes) {
  return static_cast<std::uint32_t>((bytes + kPieceBytes - 1) / kPieceBytes);
}

PiecePlace PlaceOf(const SceneList& list, std::uint32_t number) {
  std::size_t left = number;
  for (std::size_t f = 0; f < list.files.size(); ++f) {
    const ListedFile& file = list.files[f];
    if (left >= file.pieces.size()) {
      left -= file.pieces.size();
      continue;
    }
    const std::uint64_t at = left * kPieceBytes;
    return {
        .file = f,
        .piece = static_cast<std::uint32_t>(left),
        .at = at,
        .bytes = static_cast<std::size_t>(std::min<std::uint64_t>(kPieceBytes, file.bytes - at))};
  }
  TANDEM_CHECK(false);
  return {};
}

std::vector<char> Encode(const SceneList& list) {
  std::vector<char> out(kBegin.begin(), kBegin.end());
  Append(out, static_cast<std::uint32_t>(list.files.size()));
  for (const ListedFile& file : list.files) {
    const auto kind = std::ranges::find(kKinds, file.kind);
    TANDEM_CHECK(kind != kKinds.end());
    Append(out, static_cast<std::uint8_t>(kind - kKinds.begin()));
    Append(out, file.bytes);
    Append(out, file.digest);
    for (const Sha256& piece : file.pieces) Append(out, piece);
  }
  return out;
}

Result<SceneList> DecodeList(std::span<const char> bytes, std::uint64_t most_bytes) {
  if (bytes.size() < kBegin.size() + 4 || std::string_view(bytes.data(), kBegin.size()) != kBegin) {
    return Refused("it is none, or of another version of this program");
  }
  Front front(bytes.subspan(kBegin.size()));
  const auto count = front.Take<std::uint32_t>();
  if (count < 2 || count > SceneList::kMostFiles) {
    return Refused(std::to_string(count) + " files; a scene has 2 to " +
                   std::to_string(SceneList::kMostFiles));
  }
  SceneList list;
  std::set<std::pair<Sha256, std::string>> known;
  std::uint64_t left = most_bytes;
  for (std::uint32_t f = 0; f < count; ++f) {
    if (front.size() < kFileHead) return Refused("it is cut short");
    ListedFile file;
    const auto kind = front.Take<std::uint8_t>();
    if (kind >= kKinds.size() || (kind == 0) != (f == 0)) {
      return Refused("a kind of file that no scene has");
    }
    file.kind = kKinds[kind];
    file.bytes = front.Take<std::uint64_t>();
    file.digest = front.TakeDigest();
    if (file.bytes == 0) return Refused("an empty file");
    if (f == 0 && file.bytes > SceneList::kMostSceneBytes) {
      return Refused("a scene file of more than 4 MB");
    }
    if (file.bytes > left) {
      return Refused("more than " + std::to_string(most_bytes / 1'000'000) +
                     " MB (--scene-limit-mb allows more)");
    }
    left -= file.bytes;
    const std::size_t pieces = PiecesOf(file.bytes);
    if (front.size() / sizeof(Sha256) < pieces) return Refused("it is cut short");
    for (std::size_t p = 0; p < pieces; ++p) file.pieces.push_back(front.TakeDigest());
    if (!known.emplace(file.digest, file.kind).second) return Refused("a file twice");
    list.files.push_back(std::move(file));
  }
  if (front.size() != 0) return Refused("something behind its end");
  return list;
}

std::uint64_t MostListBytes(std::uint64_t most_bytes) {
  return kBegin.size() + 4 + SceneList::kMostFiles * (kFileHead + sizeof(Sha256)) +
         most_bytes / kPieceBytes * sizeof(Sha256);
}

struct PieceCoder::State {
  ZSTD_CCtx* packer = nullptr;  // both made when needed: most programs need neither
  ZSTD_DCtx* unpacker = nullptr;
};

PieceCoder::PieceCoder() : state_(std::make_unique<State>()) {}

PieceCoder::~PieceCoder() {
  ZSTD_freeCCtx(state_->packer);
  ZSTD_freeDCtx(state_->unpacker);
}

bool PieceCoder::Pack(std::span<const char> piece, std::vector<char>& out) {
  if (state_->packer == nullptr) state_->packer = ZSTD_createCCtx();
  TANDEM_CHECK(state_->packer != nullptr);
  out.resize(ZSTD_compressBound(piece.size()));
  const std::size_t packed =
      ZSTD_compressCCtx(state_->packer, out.data(), out.size(), piece.data(), piece.size(), kLevel);
  if (ZSTD_isError(packed) == 0 && packed < piece.size()) {
    out.resize(packed);
    return true;
  }
  out.assign(piece.begin(), piece.end());
  return false;
}

bool PieceCoder::Unpack(std::span<const char> bytes, bool compressed, std::span<char> piece) {
  if (!compressed) {
    if (bytes.size() != piece.size()) return false;
    std::ranges::copy(bytes, piece.begin());
    return true;
  }
  if (state_->unpacker == nullptr) state_->unpacker = ZSTD_createDCtx();
  TANDEM_CHECK(state_->unpacker != nullptr);
  const std::size_t unpacked =
      ZSTD_decompressDCtx(state_->unpacker, piece.data(), piece.size(), bytes.data(), bytes.size());
  return ZSTD_isError(unpacked) == 0 && unpacked == piece.size();
}

}  // namespace tandem
