#pragma once

#include <map>
#include <memory>
#include <string>
#include <vector>

#include "collab/peer/peer_node.h"
#include "collab/recording/mcap_writer.h"
#include "collab/recording/recording.h"

namespace tandem {

/// Writes a replayed recording for other programs, as an MCAP file (decision 0024) with ROS 2's
/// common messages, one in each channel for each frame. Lengths in m, forces in N, moments in N m,
/// all in the world's frame; times are the recording machine's monotonic clock. PEER is a peer's
/// name, or its id in hexadecimal if the recording lacks the name.
///
///   /bodies/NAME/pose, /twist     each moving body as this peer saw it; origin: centre of mass
///   /hand/pose                    the device
///   /hand/wrench                  its coupling on the body in hand, about the body's origin
///   /contact/wrench               all contact on the body in hand, as applied
///   /links/PEER/wrench            the coupling to another's instance, on the body in hand
///   /links/PEER/stiffness, /delay N/m; half the loop age, s
///   /peers/PEER/NAME/pose         poses received from other peers
///   /events                       comings and goings, requests and answers of peers, in words
class RecordingExport {
 public:
  static Result<std::unique_ptr<RecordingExport>> Create(
      const std::filesystem::path& file, const RecordingHeader& header, const WorldModel& model,
      const std::map<PeerId, std::string>& names = {});

  /// Adds a frame that `node` has just replayed.
  void Add(const RecordedFrame& frame, PeerNode& node);
  /// Ends the file. Returns the number of messages.
  Result<std::uint64_t> Close() { return writer_->Close(); }

 private:
  RecordingExport(std::unique_ptr<McapWriter> writer, const WorldModel& model,
                  const std::map<PeerId, std::string>& names);
  std::uint16_t Channel(const std::string& topic, std::uint16_t schema);
  std::string NameOf(ObjectId object) const;
  std::string NameOfPeer(PeerId peer) const;
  void AddBodies(const RecordedFrame& frame, const PeerNode& node);
  void AddForces(const RecordedFrame& frame, PeerNode& node);
  void AddWords(const RecordedFrame& frame);

  std::unique_ptr<McapWriter> writer_;
  const WorldModel* model_;
  std::uint16_t pose_ = 0;  // schemas
  std::uint16_t twist_ = 0;
  std::uint16_t wrench_ = 0;
  std::uint16_t number_ = 0;
  std::uint16_t text_ = 0;
  std::map<std::string, std::uint16_t> channels_;  // by topic
  std::map<PeerId, std::string> peers_;            // names of peers in topics
  std::vector<std::string> names_;                 // names of the scene's bodies in topics
};

}  // namespace tandem
