#pragma once

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <optional>
#include <string>
#include <vector>

#include "collab/frame_tap.h"
#include "collab/peer.h"
#include "engine/base/result.h"
#include "engine/world/force_parameters.h"

namespace tandem {

/// What a recording begins with: how the peer was made. The file is the line "tandem-recording 1",
/// the header as JSON with its length before it, then frame after frame: length, CRC-32 and content
/// (frame_code.h). Whatever a crash tore off at the end is left out.
struct RecordingHeader {
  std::string program;  // version that recorded
  std::string name;     // the peer's
  std::string scene;    // file
  std::uint64_t scene_hash = 0;
  ForceParameters parameters;  // the session's, which may not be the file's
  bool contact = true;
  std::string law;
  CouplingLimits limits;  // of the law
  PeerOptions peer;  // without law and tap
};

std::string AsText(const RecordingHeader& header);
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

/// Of what follows `before`, whose CRC that is; 0: of nothing.
std::uint32_t Crc32(const void* data, std::size_t size, std::uint32_t before = 0);

/// Reads a recording from its beginning, frame by frame.
class RecordingReader {
 public:
  static Result<RecordingReader> Open(const std::filesystem::path& file);

  const RecordingHeader& header() const noexcept { return header_; }
  /// The next frame; nothing at the end, or where the file is torn or damaged.
  std::optional<RecordedFrame> Next();
  /// Whether the end came before the end of a frame.
  bool torn() const noexcept { return torn_; }

 private:
  std::ifstream stream_;
  RecordingHeader header_;
  std::vector<char> bytes_;
  bool torn_ = false;
};

}  // namespace tandem
