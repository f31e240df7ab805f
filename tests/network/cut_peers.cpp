#include "tests/network/cut_peers.h"

#include <algorithm>
#include <chrono>
#include <csignal>
#include <fstream>
#include <random>
#include <sstream>
#include <thread>
#include <utility>

#include "collab/recording/replay.h"
#include "engine/base/check.h"
#include "engine/realtime/clock.h"
#include "scenes/generators/hand_file.h"

namespace tandem::testing {

namespace {

std::filesystem::path SceneFile() {
  return std::filesystem::path(TANDEM_SCENES) / "stability" / "free.json";
}

/// Returns the frame as the peer, who holds the cube, has just left it.
SeenFrame FrameOf(const Peer& peer, std::int64_t now_ns) {
  const SharedBody& shared = *peer.shared();
  SeenFrame frame;
  frame.now_ns = now_ns;
  frame.X_WB = peer.held_state()->X_WB;
  frame.hand_f_W = peer.report().hand_B_W.f;
  frame.links_f_W = Vec3::Zero();
  std::array<LinkView, kMaxLinks> links;
  const std::size_t count = shared.Links(now_ns, links);
  for (std::size_t k = 0; k < count; ++k) frame.links_f_W += peer.report().links_B_W[k].f;
  frame.coupled = shared.coupled();
  frame.instances = shared.Instances(frame.instance);
  return frame;
}

}  // namespace

const InstanceView* SeenFrame::InstanceOf(PeerId peer) const {
  const auto* const end = instance.begin() + instances;
  const auto* const found = std::find_if(instance.begin(), end, [peer](const InstanceView& view) {
    return view.peer == peer;
  });
  return found == end ? nullptr : found;
}

const SeenFrame& SeenPeer::At(std::int64_t ns) const {
  const auto after = std::ranges::lower_bound(frames, ns, {}, &SeenFrame::now_ns);
  return after == frames.begin() ? frames.front() : *(after - 1);
}

int SeenPeer::Count(MembershipChange::Kind kind, PeerId peer) const {
  return static_cast<int>(std::ranges::count_if(changes, [&](const SeenChange& change) {
    return change.kind == kind && change.peer == peer;
  }));
}

std::int64_t SeenPeer::First(MembershipChange::Kind kind, PeerId peer) const {
  for (const SeenChange& change : changes) {
    if (change.kind == kind && change.peer == peer) return change.now_ns;
  }
  return 0;
}

CutPeers::CutPeers(const std::vector<std::vector<Waypoint>>& hands) {
  auto hub = TapHub::Open(hands.size(), [](std::size_t, std::size_t) {
    return LinkConditions{};
  });
  TANDEM_CHECK(hub.has_value());
  hub_ = *std::move(hub);
  const std::string session = "cut-" + std::to_string(std::random_device{}());
  for (std::size_t i = 0; i < hands.size(); ++i) {
    HandScript script;
    script.waypoints = hands[i];
    const auto hand = folder_.Write("hand-" + std::to_string(i) + ".json", HandFile(script));
    // through a shell that puts both streams into a file and then is the peer
    std::vector<std::string> command{"/bin/sh", "-c", R"(f="$1"; shift; exec "$@" >>"$f" 2>&1)",
                                     "sh", FileOf(i, "said").string()};
    const std::vector<std::string> peer =
        hub_->At(i, {TANDEM_PROGRAM, "peer",
                     "--session",    session,
                     "--scene",      SceneFile().string(),
                     "--interface",  TapHub::kInterface,
                     "--name",       NameOf(i),
                     "--hold",       "part",
                     "--hand",       hand.string(),
                     "--wait-for",   std::to_string(hands.size() - 1),
                     "--capacity",   "20000",
                     "--record",     FileOf(i, "recording").string()});
    command.insert(command.end(), peer.begin(), peer.end());
    Result<ChildProcess> started = ChildProcess::Start(command);
    TANDEM_CHECK(started.has_value());
    peers_.push_back(*std::move(started));
  }
}

std::filesystem::path CutPeers::FileOf(std::size_t i, const char* ending) const {
  return folder_.path() / (NameOf(i) + "." + ending);
}

std::string CutPeers::OutputOf(std::size_t i) const {
  std::ostringstream text;
  text << std::ifstream(FileOf(i, "said")).rdbuf();
  return text.str();
}

bool CutPeers::Meet() {
  const auto met = [this] {
    for (std::size_t i = 0; i < peers_.size(); ++i) {
      const std::string output = OutputOf(i);
      for (std::size_t other = 0; other < peers_.size(); ++other) {
        if (i != other && output.find(NameOf(other) + " joined") == std::string::npos) return false;
      }
    }
    return true;
  };
  for (int waited = 0; waited < 300 && !met(); ++waited) {
    std::this_thread::sleep_for(std::chrono::milliseconds(100));
  }
  return met();
}

std::int64_t CutPeers::Cut(std::size_t from, std::size_t to, bool cut) {
  hub_->Switch(from, to, {.cut = cut});
  return MonotonicNowNs();
}

Result<std::vector<SeenPeer>> CutPeers::End() {
  const std::int64_t ended_ns = MonotonicNowNs();
  for (ChildProcess& peer : peers_) peer.Signal(SIGTERM);
  for (std::size_t i = 0; i < peers_.size(); ++i) {
    const int code = peers_[i].Wait(std::chrono::seconds(20)).value_or(-1);
    if (code != 0)
      return Error{NameOf(i) + " ended with " + std::to_string(code) + ":\n" + OutputOf(i)};
  }
  std::vector<SeenPeer> seen;
  for (std::size_t i = 0; i < peers_.size(); ++i) {
    Result<SeenPeer> one = Replayed(i, ended_ns);
    if (!one) return one.error();
    seen.push_back(*std::move(one));
  }
  return seen;
}

Result<SeenPeer> CutPeers::Replayed(std::size_t i, std::int64_t until_ns) const {
  kHapticThread.Enter();
  const Result<Scene> scene = LoadScene(SceneFile());
  if (!scene) return scene.error();
  const auto model = LoadWorld(*scene);
  if (!model) return model.error();
  Result<RecordingReader> reader = RecordingReader::Open(FileOf(i, "recording"));
  if (!reader) return reader.error();
  Result<std::unique_ptr<Replay>> replay = Replay::Create(reader->header(), *model);
  if (!replay) return replay.error();
  SeenPeer seen;
  seen.id = reader->header().peer.id;
  const Peer& peer = (*replay)->node().peer();
  const ReplayResult result =
      RunAll(*reader, **replay, [&](std::int64_t, const RecordedFrame& recorded) {
        if (recorded.now_ns >= until_ns) return false;
        for (const MembershipChange& change : recorded.changes) {
          if (change.kind >= MembershipChange::Kind::kClaims) continue;  // or beliefs
          seen.changes.push_back({recorded.now_ns, change.peer, change.kind});
        }
        if (seen.began_ns == 0) seen.began_ns = peer.started_ns().value_or(0);
        if (peer.shared() != nullptr) seen.frames.push_back(FrameOf(peer, recorded.now_ns));
        return true;
      });
  if (result.first_different) return Error{NameOf(i) + " cannot be repeated"};
  if (seen.frames.empty()) return Error{NameOf(i) + " held nothing"};
  return seen;
}

}  // namespace tandem::testing
