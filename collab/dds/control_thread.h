#pragma once

#include <functional>
#include <map>
#include <set>
#include <string>
#include <thread>

#include "collab/dds/dds_api.h"
#include "collab/dds/partitions.h"
#include "collab/dds/quiet_writers.h"
#include "collab/messages.h"
#include "collab/transport.h"

namespace tandem {

/// Tells the inbox who is there and what the session is about, from a thread of its own.
///
/// A peer is here as long as the writer lives that it was heard by: an instance of peer_info can be
/// touched by any writer of the topic, so what becomes of one tells nothing. Who was heard first as
/// a peer has that peer's seat; another who speaks as the same peer is not heard until it is gone.
class ControlThread {
 public:
  struct Sources {
    dds_entity_t participant = 0;
    dds_entity_t peer_info = 0;  // readers
    dds_entity_t viewer_info = 0;
    dds_entity_t scene = 0;
    dds_entity_t event = 0;         // 0: a viewer has none
    dds_entity_t on_match = 0;      // guard condition: writers have come or gone, or fallen silent
    QuietWriters* quiet = nullptr;  // of peer_info and viewer_info
    bool secured = false;           // partitions have names, which are the members'
    std::set<PeerId> revoked;       // whose keys are not valid any more
  };

  /// Starts. `refresh_owners` is called first of all, whenever `on_match` is raised, and when seats
  /// are taken or left.
  ControlThread(Sources sources, PeerId self, Inbox& inbox,
                std::function<void(const Seats&)> refresh_owners);
  /// Stops. Not from within a call to the inbox.
  ~ControlThread();
  ControlThread(const ControlThread&) = delete;
  ControlThread& operator=(const ControlThread&) = delete;

 private:
  struct Here {
    dds_entity_t reader = 0;
    dds_instance_handle_t writer = 0;
    std::int64_t twin_ns = 0;  // since when another speaks as it too; 0: none does
  };
  /// A manifest is said once. A program that is started anew, before its run that crashed has been
  /// given up, says it while that run has the seat.
  struct WaitingScene {
    SceneManifest manifest;
    std::int64_t since_ns = 0;
    bool told = false;  // as an impostor's, after a while
  };

  void Run();
  template <typename Wire>
  void TakePresence(dds_entity_t reader);
  void TakeScenes();
  /// Offers of those who may speak as their peers by now.
  void HearWaitingScenes();
  /// Hands a manifest on. False: another has the seat of its author, or offers in its name.
  bool HearScene(const SceneManifest& manifest, dds_instance_handle_t writer);
  void TakeEvents();
  void Hear(PeerInfo& info, dds_entity_t reader, dds_instance_handle_t writer);
  /// Ends the presence of those whose writers are gone or silent.
  void EndPresence();
  void EndScenes();
  void SayGoodbyes();
  const WriterFacts& Facts(dds_entity_t reader, dds_instance_handle_t writer);
  /// Tells by partition and seat whether that writer may speak as the peer.
  bool IsOwn(PeerId peer, const WriterFacts& facts) const;

  const Sources sources_;
  const PeerId self_;
  Inbox& inbox_;
  const std::function<void(const Seats&)> refresh_owners_;
  const dds_entity_t stop_;
  std::map<PeerId, Here> here_;
  std::map<PeerId, dds_instance_handle_t> offering_;  // writers of manifests that were heard
  std::map<dds_instance_handle_t, WaitingScene> waiting_scenes_;  // by writer
  std::map<dds_instance_handle_t, WriterFacts> facts_;
  std::set<PeerId> leaving_;  // have said goodbye
  Seats seats_;
  bool seats_changed_ = false;
  std::thread thread_;
};

}  // namespace tandem
