#include "app/study/run/study_trial.h"

#include <algorithm>
#include <array>
#include <csignal>
#include <fstream>
#include <memory>
#include <optional>
#include <random>
#include <thread>
#include <utility>

#include <nlohmann/json.hpp>
#include <unistd.h>

#include "app/capacity/capacity_follower.h"
#include "app/common/console.h"
#include "app/common/exit_codes.h"
#include "app/common/scene_files.h"
#include "app/judgement/demo_judgement.h"
#include "app/process/peer_command_line.h"
#include "app/recording/recording_trace.h"
#include "app/recording/trace_file.h"
#include "app/stability/live/case_peers.h"
#include "app/stability/live/lab_scenes.h"
#include "app/study/trial_case.h"
#include "collab/lab/case/case_parts.h"
#include "collab/lab/metrics/series_file.h"
#include "collab/lab/run/case_run.h"
#include "engine/base/units.h"

namespace tandem {

namespace {

namespace fs = std::filesystem;

constexpr int kSeriesFrames = 10;            // from one line of series.csv to the next
constexpr double kTrialMeetingSeconds = 60;  // for loading and meeting, at the most
constexpr std::chrono::milliseconds kTrialPeriod{50};
// time that children have to write their reports and end, once they are asked to
constexpr std::chrono::milliseconds kTrialEnds{10'000};
constexpr std::chrono::milliseconds kExportTakes{300'000};
constexpr std::array kLabScenes{"free", "wall", "slot", "ball", "off_centre"};

/// Returns a command that reads nothing, and whose output goes to a file, hidden from the
/// participant.
std::vector<std::string> Quietly(const std::vector<std::string>& command, const fs::path& log) {
  std::vector<std::string> words{
      "/bin/sh", "-c", "log=$1; shift; exec \"$@\" </dev/null >\"$log\" 2>&1", "sh", log.string()};
  words.insert(words.end(), command.begin(), command.end());
  return words;
}

/// Asks the children to end, and waits until they have.
void EndAll(std::vector<ChildProcess>& children) {
  for (const ChildProcess& child : children) child.Signal(SIGTERM);
  for (ChildProcess& child : children) child.Wait(kTrialEnds);
}

/// Sets `ended` to whether all peers have ended. Returns an error if a peer has not ended well.
std::optional<Error> EndOf(std::vector<ChildProcess>& peers, bool& ended) {
  ended = true;
  for (ChildProcess& peer : peers) {
    const std::optional<int> code = peer.Poll();
    ended = ended && code.has_value();
    if (code && *code != kExitOk) {
      return Error{"a peer ended with exit code " + std::to_string(*code) +
                   "; its output is in the trial's folder"};
    }
  }
  return std::nullopt;
}

/// Returns whether the peer that writes this log has told that the other peer left.
bool ToldThatLeft(const fs::path& log, const std::string& other) {
  std::ifstream stream(log);
  const std::string expected = "tandem: " + other + " left";
  for (std::string line; std::getline(stream, line);) {
    if (line == expected) return true;
  }
  return false;
}

TrialFrame FrameOf(const TraceSample& sample, std::int64_t began_ns) {
  return {ToSeconds(sample.time_ns - began_ns), sample.X_WB, sample.hand_force, sample.pushing};
}

}  // namespace

TrialRunner::TrialRunner(const Study& study, TrialSetup setup)
    : study_(study), setup_(std::move(setup)) {}

const std::string& TrialRunner::SceneNameOf(const PlannedTrial& plan) const {
  const std::string& own = study_.conditions[plan.condition].scene;
  return own.empty() ? study_.tasks[study_.blocks[plan.block].task].scene : own;
}

Result<const LabScene*> TrialRunner::SceneOf(const PlannedTrial& plan) {
  const StudyTask& task = study_.tasks[study_.blocks[plan.block].task];
  const std::string& name = SceneNameOf(plan);
  const std::string key = name + "\n" + task.body;
  const auto known = scenes_.find(key);
  if (known != scenes_.end()) return &known->second;
  LabCase test;
  const bool of_the_lab = std::ranges::find(kLabScenes, name) != kLabScenes.end();
  test.scene = of_the_lab ? name : SceneFile(name).string();
  test.body = task.body;
  Result<LabScene> scene = LoadLabScene(test, LabSceneFolder());
  if (!scene) return scene.error();
  if (task.success.out && !scene->model->has_fixture) {
    return Error{"task " + task.name + ": the scene " + name +
                 " has no fixed body that the task's body could come out of"};
  }
  return &scenes_.emplace(key, *std::move(scene)).first->second;
}

std::optional<Error> TrialRunner::LoadScenes() {
  for (const PlannedTrial& plan : TrialsOf(study_, 0)) {
    const Result<const LabScene*> scene = SceneOf(plan);
    if (!scene) return scene.error();
  }
  return std::nullopt;
}

TrialMeter TrialRunner::MeterOf(const PlannedTrial& plan, const LabScene& scene) const {
  const auto body = static_cast<std::size_t>(scene.model->body_index[scene.object]);
  TrialMeter::IsOut is_out;
  if (scene.model->has_fixture) {
    is_out = [model = scene.model, body](const Pose& X_WB) {
      return OutcomeOf(*model, body, X_WB).out;
    };
  }
  return {study_.tasks[study_.blocks[plan.block].task].success, scene.model->bodies[body].X_WB0,
          std::move(is_out)};
}

Result<TrialMeasures> TrialRunner::Run(const TrialOfParticipant& trial, const fs::path& folder,
                                       Interview& interview) {
  const Result<const LabScene*> scene = SceneOf(trial.plan);
  if (!scene) return scene.error();
  const std::string& name = SceneNameOf(trial.plan);
  const bool of_the_lab = std::ranges::find(kLabScenes, name) != kLabScenes.end();
  std::error_code unknown;
  const TrialPlace place{
      of_the_lab ? name : fs::absolute((*scene)->model->scene.file, unknown).string(), folder};
  const Result<LabCase> test = MakeTrialCase(study_, trial.participant, trial.plan, **scene, place);
  if (!test) return test.error();
  return setup_.real_peers ? RunReal(trial, *test, **scene, folder, interview)
                           : RunVirtual(trial.plan, *test, **scene, folder);
}

Result<TrialMeasures> TrialRunner::RunVirtual(const PlannedTrial& plan, const LabCase& test,
                                              const LabScene& scene, const fs::path& folder) {
  Result<SeriesFile> series = SeriesFile::Create(folder / "series.csv", test.users, kSeriesFrames);
  if (!series) return series.error();
  TrialMeter meter = MeterOf(plan, scene);
  const CaseResult result = RunCase(test, scene, [&](double t_s, std::span<const UserFrame> users) {
    series->Add(t_s, users);
    const UserFrame& own = users.front();
    if (!own.present || meter.ended()) return;
    meter.See({t_s, own.state.X_WB, own.felt_W.f.norm(), own.pushing});
    if (users[1].present) meter.SeeApart((own.state.X_WB.p - users[1].state.X_WB.p).norm());
  });
  if (result.fault) return *result.fault;
  if (const auto fault = series->Close()) return *fault;
  TrialMeasures measures = meter.Finish();
  measures.delay_ms = 0.5e3 * result.metrics.loop_age_s;
  measures.missed_share = 0;
  return measures;
}

std::vector<std::string> TrialRunner::CommandLineOfUser(const TrialPeers& peers,
                                                        std::size_t user) const {
  const std::string name = NameOfUser(user);
  LocalPeer peer{.session = peers.session,
                 .scene = peers.scene.model->scene.file,
                 .name = name,
                 .hand = {},
                 .wait_for = 1,
                 .seconds = peers.seconds,
                 .report = peers.folder / (name + ".report.json")};
  std::vector<std::string> more{"--record",       peers.folder / (name + ".recording"),
                                "--network",      peers.folder / (name + ".plan.json"),
                                "--wait-seconds", std::to_string(setup_.wait_seconds)};
  const std::string& body = peers.scene.model->scene.bodies[peers.scene.object].name;
  if (!setup_.persons || user != peers.own) {
    peer.hand = SceneHand{.body = body, .file = peers.folder / (name + ".played.json")};
    more.insert(more.end(), {"--capacity", std::to_string(kDefaultCapacity)});
  } else if (setup_.device.empty()) {
    more.insert(more.end(), {"--hold", body, "--control", peers.control});
  } else {
    more.insert(more.end(), {"--hold", body, "--device", setup_.device});
  }
  const std::vector<std::string> law = LawArguments(peers.test);
  more.insert(more.end(), law.begin(), law.end());
  std::vector<std::string> words = CommandLineOf(peer, more);
  if (peers.all_here) return words;
  // the interface is in the reach, and is not the loopback
  const auto interface = std::ranges::find(words, "--interface");
  words.erase(interface, interface + 2);
  words.insert(words.end(), setup_.connection.begin(), setup_.connection.end());
  return words;
}

Result<std::vector<ChildProcess>> TrialRunner::StartPeers(const TrialPeers& peers) const {
  std::vector<ChildProcess> children;
  for (std::size_t user = 0; user < peers.test.users; ++user) {
    if (!peers.all_here && user != peers.own) continue;
    const std::string name = NameOfUser(user);
    if (const auto fault = WriteCasePlan(peers.test, user, peers.folder / (name + ".plan.json"))) {
      return *fault;
    }
    if (const auto fault =
            WriteCaseHand(peers.test, user, peers.folder / (name + ".played.json"))) {
      return *fault;
    }
    Result<ChildProcess> started = ChildProcess::Start(
        Quietly(CommandLineOfUser(peers, user), peers.folder / (name + ".log")));
    if (!started) return started.error();
    children.push_back(*std::move(started));
  }
  return children;
}

Result<TrialMeasures> TrialRunner::RunReal(const TrialOfParticipant& trial, const LabCase& given,
                                           const LabScene& scene, const fs::path& folder,
                                           Interview& interview) {
  const LabCase test = FittedTo(scene.inertia(), given);
  const bool all_here = study_.modelled_partner || !setup_.persons;
  const std::string pid = std::to_string(getpid());
  const TrialPeers peers{
      .test = test,
      .scene = scene,
      .folder = folder,
      .session = all_here ? "study-" + pid + "-" + std::to_string(std::random_device{}())
                          : "study-" + study_.name + "-" + trial.pseudonym + "-" +
                                std::to_string(trial.plan.number),
      .control = "study-" + pid,
      .own = setup_.partner_site ? 1U : 0U,
      .all_here = all_here,
      .seconds = setup_.persons ? test.seconds : test.seconds + 2.0 * LongestDelay(test) + 0.5};
  Result<std::vector<ChildProcess>> children = StartPeers(peers);
  if (!children) return children.error();
  std::optional<ChildProcess> window;
  if (setup_.persons && setup_.device.empty()) {
    Result<ChildProcess> started = ChildProcess::Start(
        Quietly({(ProgramFolder() / "tandem-view").string(), "--attach", "--control", peers.control,
                 "--name", NameOfUser(peers.own), "--blind"},
                folder / "window.log"));
    if (!started) return started.error();
    window.emplace(*std::move(started));
  }
  const double most = peers.seconds + kTrialMeetingSeconds + setup_.wait_seconds;
  const auto until = std::chrono::steady_clock::now() + std::chrono::duration<double>(most);
  TrialMeter meter = MeterOf(trial.plan, scene);
  TraceTail tail(folder / (NameOfUser(peers.own) + ".report.json.trace"));
  std::optional<std::int64_t> began_ns;
  bool ending = false;
  while (std::chrono::steady_clock::now() < until) {
    bool ended = false;
    if (const auto fault = EndOf(*children, ended); fault && !ending) return *fault;
    if (ended) {
      window.reset();
      return Measure(trial.plan, scene, folder);
    }
    const bool closed = window && window->Poll();
    // Enter counts once the hand has begun: a line that is typed while the scene loads ends
    // nothing. The trace is read after the line, so that a hand that began before the line is
    // known.
    const bool line = setup_.persons && interview.LineWithin(kTrialPeriod);
    if (!setup_.persons) std::this_thread::sleep_for(kTrialPeriod);
    for (const TraceSample& sample : tail.ReadNew()) {
      if (!began_ns) began_ns = sample.time_ns;
      meter.See(FrameOf(sample, *began_ns));
    }
    // one peer alone measures nothing: the trial ends at both sites
    const bool alone =
        !all_here && began_ns &&
        ToldThatLeft(folder / (NameOfUser(peers.own) + ".log"), NameOfUser(1 - peers.own));
    if (!closed && !alone && !meter.ended() && !(line && began_ns)) continue;
    ending = true;
    EndAll(*children);
  }
  EndAll(*children);
  return Error{"the trial did not end in time"};
}

Result<TrialMeasures> TrialRunner::Measure(const PlannedTrial& plan, const LabScene& scene,
                                           const fs::path& folder) const {
  const std::size_t own = setup_.partner_site ? 1 : 0;
  const fs::path file = folder / (NameOfUser(own) + ".report.json");
  std::ifstream stream(file);
  const nlohmann::json report = nlohmann::json::parse(stream, nullptr, false);
  if (report.is_discarded()) return Error{NameOfUser(own) + " left no report"};
  Result<std::vector<TraceSample>> trace = ReadTrace(file.string() + ".trace");
  if (!trace) return trace.error();
  if (trace->empty()) return Error{"the participant's hand never held the body"};
  const double limit_s = study_.tasks[study_.blocks[plan.block].task].time_limit_s;
  TrialMeter meter = MeterOf(plan, scene);
  std::size_t counted = 0;
  for (; counted < trace->size() && !meter.ended(); ++counted) {
    const TrialFrame frame = FrameOf((*trace)[counted], trace->front().time_ns);
    if (frame.t_s > limit_s) break;
    meter.See(frame);
  }
  trace->resize(counted);
  const fs::path recording = folder / (NameOfUser(own) + ".recording");
  const fs::path other = folder / (NameOfUser(1 - own) + ".report.json.trace");
  std::error_code none;
  const Result<std::vector<TraceSample>> partner =
      fs::exists(other, none) ? ReadTrace(other) : TraceOfRecording(recording, scene.object);
  if (!partner) return partner.error();
  if (!partner->empty()) meter.SeeApart(DivergenceOf(*trace, *partner).peak);
  TrialMeasures measures = meter.Finish();
  const double frames = report.value("frames", 0.0);
  const double missed = report.value("missed", 0.0);
  measures.delay_ms = report.value("delay_ms", TrialMeasures::kNone);
  measures.missed_share = missed / std::max(frames + missed, 1.0);
  // the export is for other programs; the recording itself stays
  Result<ChildProcess> exporting = ChildProcess::Start(
      Quietly({(ProgramFolder() / "tandem").string(), "replay", recording.string(), "--export",
               (folder / "trial.mcap").string()},
              folder / "export.log"));
  if (!exporting) return exporting.error();
  if (exporting->Wait(kExportTakes) != kExitOk) {
    Say("trial " + std::to_string(plan.number) +
        ": trial.mcap could not be written; its recording "
        "is whole");
  }
  return measures;
}

}  // namespace tandem
