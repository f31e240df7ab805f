#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "collab/peer/frame_observer.h"
#include "collab/peer/peer.h"
#include "engine/base/files/regular_file.h"
#include "engine/base/files/sha256.h"
#include "engine/base/result.h"
#include "engine/scene/force_parameters.h"

namespace tandem {

/// The beginning of a recording: how the peer was made. The file is the line "tandem-recording 2",
/// the header as JSON after its length, then frame after frame: length, CRC-32 and content
/// (frame_code.h). A frame that a crash cut off at the end is left out. Files that begin with
/// "tandem-recording 1" are the same without peers' names.
struct RecordingHeader {
  std::string program;  // version of the recording program
  std::string name;     // name of the peer
  std::string scene;    // file of the scene
  std::uint64_t scene_hash = 0;
  std::optional<Sha256> scene_digest;  // nullopt: recorded before digests, so the hash alone counts
  ForceParameters parameters;          // the session's, which may not be the file's
  std::string law;
  CouplingLimits limits;        // limits of the law
  PeerOptions peer;             // lacks law and tap
  DeviceCapabilities device{};  // only the gains that the device bears
  double device_scale = 1;      // device scale at which it bears them, at first
};

std::string AsText(const RecordingHeader& header);
/// Parses a header. Refuses values that no recorder writes: numbers out of bounds, texts that are
/// not plain.
Result<RecordingHeader> ParseHeader(const std::string& text);

/// All inputs of one frame, in the order of their use, and the hash of its final state.
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

/// Decodes a frame; nullopt: no recorder writes these bytes, even if their checksum is right. A
/// replay uses the result without further checks.
std::optional<RecordedFrame> DecodeFrame(std::span<const char> bytes);

/// Returns the CRC-32 of `data`, continued from the CRC `before` of preceding data; 0: there is
/// none.
std::uint32_t Crc32(const void* data, std::size_t size, std::uint32_t before = 0);

/// Returns the names of all peers of a recording; peers without a name are left out.
std::map<PeerId, std::string> NamesIn(const std::filesystem::path& file);

/// Reads a recording from its beginning, frame by frame. The file is not trusted.
class RecordingReader {
 public:
  static Result<RecordingReader> Open(const std::filesystem::path& file);

  const RecordingHeader& header() const noexcept { return header_; }
  /// Returns the next frame; nullopt at the end, or where the file is torn or damaged. From there
  /// on nothing can be repeated, for every frame depends on the earlier ones.
  std::optional<RecordedFrame> Next();
  /// The names of peers in the frames read so far, including the recording peer.
  const std::map<PeerId, std::string>& names() const noexcept { return names_; }
  /// Returns whether the file ends within a frame, as after a crash.
  bool torn() const noexcept { return fault_ == Fault::kTorn; }
  /// Returns whether a frame is damaged though the file goes on behind it.
  bool damaged() const noexcept { return fault_ == Fault::kDamaged; }
  /// The number of bytes from the first unreadable frame to the end.
  std::uintmax_t unread_bytes() const noexcept { return unread_bytes_; }

 private:
  enum class Fault : std::uint8_t { kNone, kTorn, kDamaged };
  explicit RecordingReader(RegularFile file) : file_(std::move(file)) {}
  /// Takes the next bytes of the file; returns how many there were.
  std::size_t Take(std::span<char> bytes);
  std::nullopt_t Stop(Fault fault);
  /// Reads the next frame's content, or a name's, into bytes_. Returns false at the end, and on
  /// faults, for which it calls Stop().
  bool ReadContent();
  /// Takes the name in bytes_; returns false if there is none.
  bool TakeName();
  /// Returns whether a whole frame is in the rest of the file.
  bool GoesOn();

  RegularFile file_;
  std::string block_;        // read ahead
  std::size_t taken_ = 0;    // offset in block_
  std::uintmax_t read_ = 0;  // bytes read of the file, including block_
  RecordingHeader header_;
  std::uintmax_t at_ = 0;  // beginning of the next frame
  std::uintmax_t unread_bytes_ = 0;
  std::vector<char> bytes_;
  std::map<PeerId, std::string> names_;
  Fault fault_ = Fault::kNone;
};

}  // namespace tandem
