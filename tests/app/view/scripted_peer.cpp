// A peer for tests of viewers: says over DDS where a body is, and simulates nothing.
//   scripted_peer SESSION NAME SCENE OBJECT DX DY DZ DELAY_MS [HASH [FILE]]
// moves OBJECT to and fro along (DX, DY, DZ) metres, until its standard input ends. HASH ("-": the
// scene's own) and FILE are what it says of the scene.
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <random>

#include <poll.h>

#include "collab/dds/transport/dds_transport.h"
#include "collab/session/viewer.h"
#include "engine/base/units.h"
#include "engine/realtime/clock.h"
#include "engine/scene/scene.h"

namespace {

using namespace tandem;

constexpr int kFrameMs = 16;
constexpr double kPeriod = 8;  // s

int Play(char** argv, int argc) {
  const Result<Scene> scene = LoadScene(argv[3]);
  if (!scene) {
    std::fprintf(stderr, "%s\n", scene.error().what.c_str());
    return 3;
  }
  SceneManifest manifest;
  manifest.name = scene->name;
  manifest.file = scene->file.string();
  manifest.voxel_size = scene->voxel_size;
  for (const SceneBody& body : scene->bodies) manifest.bodies.push_back({body.name, 0});
  const Result<SceneHash> hash = HashScene(*scene);
  const bool own_hash = argc <= 9 || std::strcmp(argv[9], "-") == 0;
  manifest.content_hash = own_hash ? hash->content : std::strtoull(argv[9], nullptr, 16);
  if (own_hash) manifest.content_digest = hash->digest;
  if (argc > 10) manifest.file = argv[10];

  std::random_device random;
  PeerInfo info;
  info.peer = 1 + random();
  manifest.offered_by = info.peer;
  info.name = argv[2];
  info.scene_hash = manifest.content_hash;
  Viewer active_peers;
  DdsOptions options;
  options.session = argv[1];
  options.peer = info.peer;
  options.interface = "lo";
  Result<std::unique_ptr<Transport>> joined = JoinOverDds(options, active_peers);
  if (!joined) {
    std::fprintf(stderr, "%s\n", joined.error().what.c_str());
    return 5;
  }
  Transport& transport = **joined;
  transport.Publish(manifest);

  const Vec3 way(std::strtod(argv[5], nullptr), std::strtod(argv[6], nullptr),
                 std::strtod(argv[7], nullptr));
  ViewFrame frame;
  frame.peer = info.peer;
  frame.delay_ms = std::strtof(argv[8], nullptr);
  frame.count = 1;
  frame.bodies[0].object = static_cast<ObjectId>(std::atoi(argv[4]));
  frame.bodies[0].flags = ViewBody::kHeld;
  const std::int64_t begin_ns = MonotonicNowNs();
  pollfd input{0, POLLIN, 0};
  while (poll(&input, 1, kFrameMs) == 0) {
    if (frame.seq % 16 == 0) transport.Publish(info);
    ++info.beat;
    frame.sample_ns = MonotonicNowNs();
    const double t = ToSeconds(frame.sample_ns - begin_ns);
    frame.bodies[0].X_W.p = (0.75 + 0.25 * std::cos(6.2831853 * t / kPeriod)) * way;
    transport.Publish(frame);
    ++frame.seq;
  }
  transport.Leave();
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 9 || argc > 11) return 2;
  return Play(argv, argc);
}
