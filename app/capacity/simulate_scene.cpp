#include "app/capacity/simulate_scene.h"

#include <algorithm>
#include <memory>

#include "app/common/program_cache.h"
#include "app/common/scene_files.h"
#include "app/judgement/start_gaps.h"
#include "collab/simulated/network/simulated_session.h"
#include "engine/base/units.h"
#include "engine/haptics/scripted_device.h"
#include "engine/realtime/clock.h"

namespace tandem {

Result<nlohmann::ordered_json> SimulateScene(const std::string& name, double most_seconds) {
  const Result<Scene> scene = LoadNamedScene(name);
  if (!scene) return scene.error();
  const Result<std::shared_ptr<const WorldModel>> loaded = LoadAndTell(*scene);
  if (!loaded) return loaded.error();
  const std::shared_ptr<const WorldModel>& model = *loaded;
  TellStart(FindStartGaps(*model));

  SimulatedSession session;
  double seconds = 0;
  for (const SceneHand& hand : scene->hands) {
    const Result<HandScript> script = LoadHandScript(hand.file);
    if (!script) return script.error();
    seconds = std::max(seconds, script->duration());
    const int object = scene->BodyNamed(hand.body);
    const int body = model->body_index[static_cast<std::size_t>(object)];
    if (body < 0) return Error{hand.body + " is fixed, so no hand can hold it"};
    NodeOptions options;
    options.peer.id = session.size() + 1;
    options.peer.held_object = object;
    options.peer.X_BD = script->X_BD;
    options.peer.wait_for = scene->hands.size() - 1;
    options.name = hand.body;
    options.conditions.delay_ms = 20;
    auto device = std::make_unique<ScriptedDevice>(
        *script, model->bodies[static_cast<std::size_t>(body)].X_WB0);
    session.Add(std::make_unique<PeerNode>(model, std::move(device), 1, options), options.peer.id);
  }
  if (session.size() == 0) return Error{scene->name + ": the scene has no hands"};

  seconds = std::min(seconds, most_seconds);
  LoopClock& clock = MachineClock();
  double cpu_s = 0;
  double contact_s = 0;
  double contact_cpu_s = 0;
  double points = 0;
  double pushing = 0;
  double peer_frames = 0;
  const auto frames = static_cast<int>(seconds / kFrame);
  for (int frame = 0; frame < frames; ++frame) {
    const std::int64_t began_ns = clock.ThreadCpuNs();
    session.Step();
    const double took_s = ToSeconds(clock.ThreadCpuNs() - began_ns);
    cpu_s += took_s;
    bool all_push = true;
    for (std::size_t p = 0; p < session.size(); ++p) {
      all_push = all_push && session.node(p).peer().report().pushing_points > 0;
    }
    if (!all_push) continue;
    contact_s += kFrame;
    contact_cpu_s += took_s;
    for (std::size_t p = 0; p < session.size(); ++p) {
      points += session.node(p).peer().report().contact_points;
      pushing += session.node(p).peer().report().pushing_points;
      peer_frames += 1;
    }
  }
  const double simulated_s = kFrame * frames;
  return nlohmann::ordered_json{
      {"scene", scene->name},
      {"peers", session.size()},
      {"simulated_s", simulated_s},
      {"cpu_s", cpu_s},
      {"speed", cpu_s > 0 ? simulated_s / cpu_s : 0.0},
      {"contact_s", contact_s},
      {"contact_cpu_s", contact_cpu_s},
      {"contact_speed", contact_cpu_s > 0 ? contact_s / contact_cpu_s : 0.0},
      {"contact_points", peer_frames > 0 ? points / peer_frames : 0.0},
      {"loaded_points", peer_frames > 0 ? pushing / peer_frames : 0.0}};
}

}  // namespace tandem
