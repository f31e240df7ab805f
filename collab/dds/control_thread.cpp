#include "collab/dds/control_thread.h"

#include <array>
#include <utility>

#include <pthread.h>

#include "collab/dds/fast_reader.h"
#include "collab/dds/partitions.h"
#include "collab/dds/wire.h"

namespace tandem {
namespace {

// Calls use(sample, info) for all that waits in a reader; a sample without data has only its key.
template <typename Wire, typename Use>
void TakeAll(dds_entity_t reader, Use use) {
  constexpr std::size_t kBatch = 16;
  dds_return_t taken = 0;
  do {
    std::array<void*, kBatch> samples{};
    std::array<dds_sample_info_t, kBatch> infos{};
    taken = dds_take(reader, samples.data(), infos.data(), kBatch, kBatch);
    for (int i = 0; i < taken; ++i) {
      const auto k = static_cast<std::size_t>(i);
      use(*static_cast<const Wire*>(samples[k]), infos[k]);
    }
    if (taken > 0) dds_return_loan(reader, samples.data(), taken);
  } while (taken == static_cast<dds_return_t>(kBatch));
}

}  // namespace

ControlThread::ControlThread(const Sources& sources, PeerId self, Inbox& inbox,
                             std::function<void()> refresh_owners)
    : sources_(sources),
      self_(self),
      inbox_(inbox),
      refresh_owners_(std::move(refresh_owners)),
      stop_(dds_create_guardcondition(sources.participant)),
      thread_([this] {
        Run();
      }) {}

ControlThread::~ControlThread() {
  dds_set_guardcondition(stop_, true);
  thread_.join();
}

void ControlThread::Run() {
  pthread_setname_np(pthread_self(), "dds-control");
  const Entity waitset(dds_create_waitset(sources_.participant));
  for (const dds_entity_t reader : {sources_.peer_info, sources_.scene, sources_.event}) {
    if (reader == 0) continue;
    const dds_entity_t any = dds_create_readcondition(reader, DDS_ANY_STATE);
    dds_waitset_attach(waitset.get(), any, 0);
  }
  dds_waitset_attach(waitset.get(), sources_.on_match, 0);
  dds_waitset_attach(waitset.get(), stop_, 0);

  refresh_owners_();
  for (;;) {
    dds_waitset_wait(waitset.get(), nullptr, 0, DDS_INFINITY);
    bool raised = false;
    if (dds_read_guardcondition(stop_, &raised) == DDS_RETCODE_OK && raised) return;
    // lowered before looking, so that a writer that comes meanwhile raises it again
    if (dds_take_guardcondition(sources_.on_match, &raised) == DDS_RETCODE_OK && raised) {
      refresh_owners_();
    }
    TakePeerInfo();
    TakeScenes();
    if (sources_.event != 0) TakeEvents();
  }
}

void ControlThread::TakePeerInfo() {
  PeerInfo info;
  TakeAll<tandem_PeerInfo>(sources_.peer_info,
                           [&](const tandem_PeerInfo& wire, const dds_sample_info_t& sample) {
                             if (wire.peer == self_) return;
                             if (sample.valid_data && FromWire(wire, info))
                               Hear(info, sample.publication_handle);
                             if (sample.instance_state != DDS_IST_ALIVE) NoteEnd(wire.peer, sample);
                           });
}

void ControlThread::Hear(const PeerInfo& info, dds_instance_handle_t writer) {
  const auto known = present_.find(info.peer);
  const bool same_writer = known != present_.end() && known->second == writer;
  if (!same_writer && OwnerOfWriter(sources_.peer_info, writer) != info.peer) return;
  present_[info.peer] = writer;
  inbox_.OnPeerInfo(info, MonotonicNow_ns());
}

// Only a peer's own writer may say goodbye for it.
void ControlThread::NoteEnd(PeerId peer, const dds_sample_info_t& end) {
  const auto known = present_.find(peer);
  if (known == present_.end()) return;
  const bool disposed = end.instance_state == DDS_IST_NOT_ALIVE_DISPOSED;
  if (disposed && known->second != end.publication_handle) return;
  present_.erase(known);
  if (disposed) {
    inbox_.OnPeerLeft(peer);
  } else {
    inbox_.OnPeerLost(peer);
  }
}

void ControlThread::TakeScenes() {
  SceneManifest manifest;
  TakeAll<tandem_SceneManifest>(
      sources_.scene, [&](const tandem_SceneManifest& wire, const dds_sample_info_t& sample) {
        if (sample.valid_data && FromWire(wire, manifest)) inbox_.OnScene(manifest);
      });
}

void ControlThread::TakeEvents() {
  Event event;
  TakeAll<tandem_Event>(
      sources_.event, [&](const tandem_Event& wire, const dds_sample_info_t& sample) {
        if (!sample.valid_data || wire.peer == self_ || !FromWire(wire, event)) return;
        if (OwnerOfWriter(sources_.event, sample.publication_handle) != event.peer) return;
        inbox_.OnEvent(event, MonotonicNow_ns());
      });
}

}  // namespace tandem
