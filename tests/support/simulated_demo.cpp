#include "tests/support/simulated_demo.h"

#include "engine/haptics/scripted_device.h"

namespace tandem::testing {

Result<Scene> GeneratedScene(const std::string& name) {
  return LoadScene(std::filesystem::path(TANDEM_SCENES) / (name + ".json"));
}

std::unique_ptr<PeerNode> MakeNode(const std::shared_ptr<const WorldModel>& model, PeerId id,
                                   int object, const HandScript& script, NodeOptions options) {
  options.peer.id = id;
  options.peer.held_object = object;
  options.peer.X_BD = script.X_BD;
  if (options.name.empty()) options.name = "peer " + std::to_string(id);
  const auto body = static_cast<std::size_t>(model->body_index[static_cast<std::size_t>(object)]);
  return std::make_unique<PeerNode>(
      model, std::make_unique<ScriptedDevice>(script, model->bodies[body].X_WB0), 1, options);
}

namespace {

/// Returns the same hand, which waits for so long before it begins.
HandScript BegunLater(HandScript script, double seconds) {
  if (seconds <= 0) return script;
  for (Waypoint& waypoint : script.waypoints) waypoint.t += seconds;
  for (Push& push : script.pushes) push.t += seconds;
  script.waypoints.insert(script.waypoints.begin(), Waypoint{});
  return script;
}

}  // namespace

Result<SimulatedDemo> RunSimulatedDemo(const std::string& name,
                                       const SimulatedDemoOptions& options) {
  const Result<Scene> scene = GeneratedScene(name);
  if (!scene) return scene.error();
  const Result<std::shared_ptr<const WorldModel>> model = LoadWorld(*scene);
  if (!model) return model.error();
  SimulatedDemo demo;
  demo.model = *model;
  const auto frames = static_cast<std::size_t>(1000.0 * options.seconds);
  SimulatedSession session;
  for (std::size_t h = 0; h < scene->hands.size(); ++h) {
    const Result<HandScript> script = LoadHandScript(scene->hands[h].file);
    if (!script) return script.error();
    const double waits = h == 0   ? -options.second_begins_later_s
                         : h == 1 ? options.second_begins_later_s
                                  : 0.0;
    NodeOptions node;
    node.peer.wait_for = scene->hands.size() - 1;
    node.peer.trace_frames = frames;
    node.peer.law = options.law;
    node.peer.experiments.contact = options.contact;
    node.conditions = options.conditions;
    node.conditions.seed += h;
    const PeerId id = 1 + h;
    session.Add(MakeNode(*model, id, scene->BodyNamed(scene->hands[h].body),
                         BegunLater(*script, waits), node),
                id);
  }
  const auto all_recorded = [&] {
    for (std::size_t h = 0; h < scene->hands.size(); ++h) {
      if (session.node(h).peer().telemetry().trace().size() < frames) return false;
    }
    return true;
  };
  for (std::size_t frame = 0; frame < frames + 5000 && !all_recorded(); ++frame) session.Step();
  for (std::size_t h = 0; h < scene->hands.size(); ++h) {
    const std::span<const TraceSample> trace = session.node(h).peer().telemetry().trace();
    demo.traces.emplace_back(trace.begin(), trace.end());
    demo.mean_delay_s.push_back(session.node(h).peer().mean_delay_s());
  }
  return demo;
}

}  // namespace tandem::testing
