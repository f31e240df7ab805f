#include "collab/dds/transport/control_thread.h"

#include <algorithm>
#include <utility>
#include <vector>

#include <pthread.h>

#include "collab/dds/cyclone/partitions.h"
#include "collab/dds/cyclone/take_samples.h"
#include "collab/dds/networks/live_domains.h"
#include "collab/dds/wire/wire.h"
#include "engine/realtime/clock.h"

namespace tandem {
namespace {

std::vector<dds_instance_handle_t> MatchedWriters(dds_entity_t reader) {
  std::vector<dds_instance_handle_t> writers(64);
  dds_return_t found = 0;
  for (;;) {
    found = dds_get_matched_publications(reader, writers.data(), writers.size());
    if (found < 0) return {};
    if (static_cast<std::size_t>(found) <= writers.size()) break;
    writers.resize(2 * static_cast<std::size_t>(found));
  }
  writers.resize(static_cast<std::size_t>(found));
  std::ranges::sort(writers);
  return writers;
}

ProgramId ProgramOf(dds_entity_t participant) {
  ProgramId program{};
  dds_guid_t guid{};
  if (dds_get_guid(participant, &guid) == DDS_RETCODE_OK) {
    std::copy_n(guid.v, program.size(), program.begin());
  }
  return program;
}

// A crashed peer's keys are used again before anybody has noticed: that is no twin. A twin is
// reported only after both have been heard for this time.
constexpr std::int64_t kTwinNs = 1'500'000'000;
// Bounds the manifests whose writers may not speak for their authors yet.
constexpr std::size_t kMostWaitingScenes = 2 * kMaxPeers;
// Bounds the writers whose facts are kept. Beyond it all facts are looked up again, which happens
// when writers are invented.
constexpr std::size_t kMostFacts = 1024;

}  // namespace

ControlThread::ControlThread(Sources sources, PeerId self, Inbox& inbox,
                             std::function<void(const Seats&)> refresh_owners)
    : sources_(std::move(sources)),
      self_(self),
      inbox_(inbox),
      refresh_owners_(std::move(refresh_owners)),
      self_program_(ProgramOf(sources_.participant)),
      stop_(dds_create_guardcondition(sources_.participant)),
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
  for (const dds_entity_t reader :
       {sources_.peer_info, sources_.viewer_info, sources_.scene, sources_.event}) {
    if (reader == 0) continue;
    const dds_entity_t any = dds_create_readcondition(reader, DDS_ANY_STATE);
    dds_waitset_attach(waitset.get(), any, 0);
  }
  dds_waitset_attach(waitset.get(), sources_.on_match, 0);
  dds_waitset_attach(waitset.get(), stop_, 0);

  refresh_owners_(seats_);
  NoteMet();
  for (;;) {
    dds_waitset_wait(waitset.get(), nullptr, 0, DDS_INFINITY);
    bool raised = false;
    if (dds_read_guardcondition(stop_, &raised) == DDS_RETCODE_OK && raised) return;
    // lowered before the look-up, so that a writer that comes meanwhile raises it again
    const bool changed =
        dds_take_guardcondition(sources_.on_match, &raised) == DDS_RETCODE_OK && raised;
    TakePresence<tandem_PeerInfo>(sources_.peer_info);
    TakePresence<tandem_ViewerInfo>(sources_.viewer_info);
    if (changed) {
      if (sources_.event != 0) TakeEvents();
      SayGoodbyes();
      NoteMet();
    }
    if (changed) EndPresence();
    if (std::exchange(seats_changed_, false) || changed) {
      refresh_owners_(seats_);
      EndScenes();  // an impostor's scene, before its author's is taken
    }
    TakeScenes();
    if (changed) EndScenes();
    ReceiveWaitingScenes();
    if (sources_.event != 0) TakeEvents();
    SayGoodbyes();
  }
}

void ControlThread::SayGoodbyes() {
  for (const PeerId peer : std::exchange(leaving_, {})) {
    if (here_.erase(peer) == 0) continue;
    seats_.erase(peer);
    seats_changed_ = true;
    inbox_.OnPeerLeft(peer);
  }
}

void ControlThread::NoteMet() {
  if (!sources_.secured) return;
  // every program has a writer of one of these, and none is matched before its keys are proven
  std::vector<ProgramId> met{self_program_};
  for (const dds_entity_t reader : {sources_.peer_info, sources_.viewer_info, sources_.scene}) {
    for (const dds_instance_handle_t writer : MatchedWriters(reader)) {
      const WriterFacts& facts = Facts(reader, writer);
      if (facts.participant != 0) met.push_back(facts.program);
    }
  }
  std::ranges::sort(met);
  met.erase(std::unique(met.begin(), met.end()), met.end());
  ForEachLiveDomain([&](DomainNetworks& networks) {
    if (networks.domain() == sources_.domain) networks.SetMet(met);
  });
}

const WriterFacts& ControlThread::Facts(dds_entity_t reader, dds_instance_handle_t writer) {
  if (const auto known = facts_.find(writer); known != facts_.end()) return known->second;
  if (facts_.size() >= kMostFacts) facts_.clear();
  static const WriterFacts kNone;
  WriterFacts facts = FactsOfWriter(reader, writer);
  if (facts.participant == 0) return kNone;  // gone: perhaps it comes back
  return facts_[writer] = std::move(facts);
}

bool ControlThread::IsOwn(PeerId peer, const WriterFacts& facts) const {
  if (peer == 0 || facts.owner.peer != peer) return false;
  const auto seat = seats_.find(peer);
  return seat == seats_.end() || seat->second == facts.participant;
}

template <typename Wire>
void ControlThread::TakePresence(dds_entity_t reader) {
  PeerInfo info;
  TakeSamples<Wire>(reader, [&](const Wire& wire, const dds_sample_info_t& sample) {
    if (!sample.valid_data) return;
    if (FromWire(wire, info)) return Receive(info, reader, sample.publication_handle);
    const PeerId speaker = Facts(reader, sample.publication_handle).owner.peer;
    if (speaker != 0 && speaker != self_) inbox_.OnDropped(speaker, Drop::kHuge);
  });
}

void ControlThread::Receive(PeerInfo& info, dds_entity_t reader, dds_instance_handle_t writer) {
  const WriterFacts facts = Facts(reader, writer);
  if (facts.participant == 0) return;  // a remainder of a writer that is gone
  if (facts.owner.peer != info.peer) {
    if (facts.owner.peer != self_) inbox_.OnDropped(facts.owner.peer, Drop::kImpostor);
    return;
  }
  if (sources_.revoked.contains(info.peer)) {
    inbox_.OnDropped(info.peer, Drop::kRevoked);
    return;
  }
  if (sources_.secured) {
    // the permissions of old keys say nothing of names
    if (facts.owner.name.empty()) return inbox_.OnDropped(info.peer, Drop::kImpostor);
    info.name = facts.owner.name;
  }
  const auto known = here_.find(info.peer);
  if (info.peer == self_) {
    // permissions let nobody without our keys speak as us; in a plain session anybody can
    if (sources_.secured && !info.leaving) inbox_.OnTwin(info);
    if (!sources_.secured) inbox_.OnDropped(self_, Drop::kImpostor);
    return;
  }
  if (known != here_.end() && known->second.writer != writer) {
    // its sample is lost; it sends again when the other's writer is gone
    if (known->second.twin_ns == 0) known->second.twin_ns = MonotonicNowNs();
    return;
  }
  if (info.leaving) {
    // its last events are heard first
    if (known != here_.end()) leaving_.insert(info.peer);
    return;
  }
  if (known == here_.end()) {
    if (sources_.quiet->Has(writer)) return;  // sent before it fell silent
    here_[info.peer] = {reader, writer, 0};
    seats_[info.peer] = facts.participant;
    seats_changed_ = true;
  } else if (known->second.twin_ns != 0 && MonotonicNowNs() - known->second.twin_ns > kTwinNs) {
    known->second.twin_ns = 0;
    inbox_.OnDropped(info.peer, sources_.secured ? Drop::kTwin : Drop::kImpostor);
  }
  inbox_.OnPeerInfo(info, MonotonicNowNs());
}

void ControlThread::EndPresence() {
  std::map<dds_entity_t, std::vector<dds_instance_handle_t>> matched;
  for (const dds_entity_t reader : {sources_.peer_info, sources_.viewer_info}) {
    matched[reader] = MatchedWriters(reader);
  }
  for (auto it = here_.begin(); it != here_.end();) {
    const PresentPeer& here = it->second;
    const bool is_matched = std::ranges::binary_search(matched[here.reader], here.writer);
    if (is_matched && !sources_.quiet->Has(here.writer)) {
      ++it;
      continue;
    }
    if (!is_matched) sources_.quiet->Forget(here.writer);
    const PeerId peer = it->first;
    it = here_.erase(it);
    seats_.erase(peer);
    seats_changed_ = true;
    inbox_.OnPeerLost(peer);
  }
  // handles are not used again in a process's life, so facts of gone writers are useless
  if (facts_.size() > kMostFacts / 2) facts_.clear();
}

void ControlThread::TakeScenes() {
  SceneManifest manifest;
  TakeSamples<tandem_SceneManifest>(sources_.scene, [&](const tandem_SceneManifest& wire,
                                                        const dds_sample_info_t& sample) {
    if (!sample.valid_data || wire.offered_by == self_) return;
    const WriterFacts& facts = Facts(sources_.scene, sample.publication_handle);
    if (facts.participant == 0 || facts.owner.peer == self_) return;
    if (facts.owner.peer != wire.offered_by) {
      return inbox_.OnDropped(facts.owner.peer, Drop::kImpostor);
    }
    if (sources_.revoked.contains(wire.offered_by)) {
      return inbox_.OnDropped(wire.offered_by, Drop::kRevoked);
    }
    if (!FromWire(wire, manifest)) {
      return inbox_.OnDropped(wire.offered_by, Drop::kAbsurdScene);
    }
    const dds_instance_handle_t writer = sample.publication_handle;
    if (ReceiveScene(manifest, writer)) {
      waiting_scenes_.erase(writer);
    } else if (waiting_scenes_.contains(writer) || waiting_scenes_.size() < kMostWaitingScenes) {
      waiting_scenes_[writer] = {manifest, MonotonicNowNs()};
    }
  });
}

bool ControlThread::ReceiveScene(const SceneManifest& manifest, dds_instance_handle_t writer) {
  const PeerId author = manifest.offered_by;
  const auto known = offering_.find(author);
  const bool other_offers = known != offering_.end() && known->second != writer;
  if (other_offers || !IsOwn(author, Facts(sources_.scene, writer))) return false;
  offering_[author] = writer;
  inbox_.OnScene(manifest);
  return true;
}

void ControlThread::ReceiveWaitingScenes() {
  if (waiting_scenes_.empty()) return;
  const std::vector<dds_instance_handle_t> matched = MatchedWriters(sources_.scene);
  for (auto it = waiting_scenes_.begin(); it != waiting_scenes_.end();) {
    auto& [writer, scene] = *it;
    if (!std::ranges::binary_search(matched, writer) || ReceiveScene(scene.manifest, writer)) {
      it = waiting_scenes_.erase(it);
      continue;
    }
    if (!scene.reported && MonotonicNowNs() - scene.since_ns > kTwinNs) {
      scene.reported = true;
      inbox_.OnDropped(scene.manifest.offered_by, Drop::kImpostor);
    }
    ++it;
  }
}

void ControlThread::EndScenes() {
  const std::vector<dds_instance_handle_t> matched = MatchedWriters(sources_.scene);
  for (auto it = offering_.begin(); it != offering_.end();) {
    const auto seat = seats_.find(it->first);
    const auto facts = facts_.find(it->second);
    const bool is_impostor =
        seat != seats_.end() && facts != facts_.end() && facts->second.participant != seat->second;
    if (!is_impostor && std::ranges::binary_search(matched, it->second)) {
      ++it;
      continue;
    }
    inbox_.OnSceneWithdrawn(it->first);
    it = offering_.erase(it);
  }
}

void ControlThread::TakeEvents() {
  Event event;
  TakeSamples<tandem_Event>(
      sources_.event, [&](const tandem_Event& wire, const dds_sample_info_t& sample) {
        if (!sample.valid_data || wire.peer == self_ || !FromWire(wire, event)) return;
        const WriterFacts& facts = Facts(sources_.event, sample.publication_handle);
        if (facts.participant == 0 || facts.owner.peer == self_) return;
        if (!IsOwn(event.peer, facts)) {
          return inbox_.OnDropped(facts.owner.peer, Drop::kImpostor);
        }
        if (!here_.contains(event.peer)) return inbox_.OnDropped(event.peer, Drop::kStranger);
        inbox_.OnEvent(event, MonotonicNowNs());
      });
}

}  // namespace tandem
