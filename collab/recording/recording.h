#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "collab/frame_tap.h"
#include "collab/peer.h"
#include "engine/base/regular_file.h"
#include "engine/base/result.h"
#include "engine/world/force_parameters.h"

namespace tandem {

/// What a recording begins with: how the peer was made. The file is the line "tandem-recording 2",
/// the header as JSON with its length before it, then frame after frame: length, CRC-32 and content
/// (frame_code.h). Whatever a crash tore off at the end is left out. Files that begin with
/// "tandem-recording 1" are the same without peers' names.
struct RecordingHeader {
  std::string program;  // version that recorded
  std::string name;     // the peer's
  std::string scene;    // file
  std::uint64_t scene_hash = 0;
  ForceParameters parameters;  // the session's, which may not be the file's
  bool contact = true;
  std::string law;
  CouplingLimits limits;  // of the law
  PeerOptions peer;       // without law and tap
  DeviceCapabilities device{};  // of it the gains that the device bears
  double device_scale = 1;      // by which these are so, at first
};

std::string AsText(const RecordingHeader& header);
/// Refuses what no recorder writes: numbers out of their bounds, texts that are not plain.
Result<RecordingHeader> ParseHeader(const std::string& text);

/// All inputs of one frame, in the order in which they were used, and what it ended in.
struct RecordedFrame {
  std::int64_t now_ns = 0;
  double capacity = 0;
  std::vector<MembershipChange> changes;
  std::vector<Event> events;
  std::vector<Command> commands;
  std::vector<ObjectState> states;
  std::vector<CouplingLinks> links;
  Anchor device;
  std::uint64_t state_hash = 0;
};

/// The frame that `bytes` are; nothing: no recorder writes such, whatever its checksum says. A
/// replay takes what this gives without a further check.
std::optional<RecordedFrame> DecodeFrame(std::span<const char> bytes);

/// Of what follows `before`, whose CRC that is; 0: of nothing.
std::uint32_t Crc32(const void* data, std::size_t size, std::uint32_t before = 0);

/// How all peers of a recording are called; who is nowhere named is left out.
std::map<PeerId, std::string> NamesIn(const std::filesystem::path& file);

/// Reads a recording from its beginning, frame by frame. A stranger may have made it.
class RecordingReader {
 public:
  static Result<RecordingReader> Open(const std::filesystem::path& file);

  const RecordingHeader& header() const noexcept { return header_; }
  /// The next frame; nothing at the end, or where the file is torn or damaged. From there on
  /// nothing can be repeated, for every frame rests on those before.
  std::optional<RecordedFrame> Next();
  /// How peers are called, as far as the frames read so far tell; the recording peer itself too.
  const std::map<PeerId, std::string>& names() const noexcept { return names_; }
  /// Whether the file ends within a frame, as what a crash cut off does.
  bool torn() const noexcept { return fault_ == Fault::kTorn; }
  /// Whether a frame is not as it was written though the file goes on behind it.
  bool damaged() const noexcept { return fault_ == Fault::kDamaged; }
  /// The bytes from the first frame that cannot be had to the end.
  std::uintmax_t unread_bytes() const noexcept { return unread_bytes_; }

 private:
  enum class Fault : std::uint8_t { kNone, kTorn, kDamaged };
  explicit RecordingReader(RegularFile file) : file_(std::move(file)) {}
  /// Takes the next bytes of the file; how many there were.
  std::size_t Take(std::span<char> bytes);
  std::nullopt_t Stop(Fault fault);
  /// The next frame's content, or a name's, into bytes_; false at the end, and where Stop() says
  /// why.
  bool ReadContent();
  /// Takes the name that bytes_ are; false: they are none.
  bool TakeName();
  /// Whether a whole frame is among what is left.
  bool GoesOn();

  RegularFile file_;
  std::string block_;        // read ahead
  std::size_t taken_ = 0;    // of block_
  std::uintmax_t read_ = 0;  // of the file, block_ included
  RecordingHeader header_;
  std::uintmax_t at_ = 0;    // where the next frame begins
  std::uintmax_t unread_bytes_ = 0;
  std::vector<char> bytes_;
  std::map<PeerId, std::string> names_;
  Fault fault_ = Fault::kNone;
};

}  // namespace tandem
