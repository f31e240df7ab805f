#pragma once

#include <functional>
#include <map>
#include <thread>

#include "collab/dds/dds_api.h"
#include "collab/messages.h"
#include "collab/transport.h"

namespace tandem {

/// Tells the inbox who is there and what the session is about, from a thread of its own.
class ControlThread {
 public:
  struct Sources {
    dds_entity_t participant = 0;
    dds_entity_t peer_info = 0;  // readers
    dds_entity_t scene = 0;
    dds_entity_t event = 0;     // 0: a viewer has none
    dds_entity_t on_match = 0;  // guard condition: writers of fast topics have come or gone
  };

  /// Starts. `refresh_owners` is called first of all and whenever `on_match` is raised.
  ControlThread(const Sources& sources, PeerId self, Inbox& inbox,
                std::function<void()> refresh_owners);
  /// Stops. Not from within a call to the inbox.
  ~ControlThread();
  ControlThread(const ControlThread&) = delete;
  ControlThread& operator=(const ControlThread&) = delete;

 private:
  void Run();
  void TakePeerInfo();
  void TakeScenes();
  void TakeEvents();
  void Hear(const PeerInfo& info, dds_instance_handle_t writer);
  void NoteEnd(PeerId peer, const dds_sample_info_t& end);

  const Sources sources_;
  const PeerId self_;
  Inbox& inbox_;
  const std::function<void()> refresh_owners_;
  const dds_entity_t stop_;
  std::map<PeerId, dds_instance_handle_t> present_;  // with the writer each was heard by last
  std::thread thread_;
};

}  // namespace tandem
