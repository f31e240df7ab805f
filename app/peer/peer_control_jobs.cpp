#include <exception>
#include <system_error>
#include <utility>

#include <pthread.h>

#include "app/common/program_cache.h"
#include "app/common/scene_files.h"
#include "app/peer/peer_control.h"
#include "collab/dds/control/control_folder.h"

// Does the requests of hosts that take long: files, meshes, voxels and other scenes.

namespace tandem {

namespace {

/// Returns what a host is told of the voxels of a mesh.
Answer VoxelsOf(const Scene& scene, const std::stop_token& stop) {
  const Result<std::shared_ptr<const WorldModel>> model = LoadCached(scene, {.stop = stop});
  if (!model) return {false, WithoutQuotedText(model.error().what)};
  const BodyModel& body = (*model)->bodies.front();
  Result<Voxmap> map = Voxmap{};
  const LoadOptions options{.stop = stop, .cache = ProgramCache()};
  if (const auto fault = MakeMap(scene, (*model)->meshes_W.front(), *map, options)) {
    return {false, WithoutQuotedText(fault->what)};
  }
  const Result<Pointshell> points = MakePoints(scene, (*model)->meshes_W.front(), body.X_WB0, 0);
  if (!points) return {false, WithoutQuotedText(points.error().what)};
  return {true, std::to_string(map->Count().total()) + " voxels, " +
                    std::to_string(points->size()) + " points"};
}

}  // namespace

void PeerControl::RunJobs() {
  pthread_setname_np(pthread_self(), "control-jobs");
  for (;;) {
    std::function<std::optional<Answer>()> what;
    std::uint64_t job = 0;
    {
      std::unique_lock lock(posted_mutex_);
      job_came_.wait(lock, [this] {
        return stop_.load() || !jobs_.empty();
      });
      if (stop_) return;
      job = jobs_.front().first;
      what = std::move(jobs_.front().second);
      jobs_.pop_front();
    }
    std::optional<Answer> answer;
    try {
      answer = what();
    } catch (const std::exception& fault) {
      answer = Answer{false, fault.what()};
    }
    if (!answer) continue;  // the answer comes when the scene is loaded
    Post([job, answer](ControlServer& server) {
      server.OnDone(job, *answer);
    });
  }
}

void PeerControl::Begin(std::uint64_t job, const ControlRequest& request) {
  const auto later = [this, job](std::function<std::optional<Answer>()> what) {
    {
      const std::lock_guard lock(posted_mutex_);
      jobs_.emplace_back(job, std::move(what));
    }
    job_came_.notify_all();
  };
  if (const auto* voxelize = std::get_if<VoxelizeRequest>(&request)) {
    later([this, order = *voxelize] {
      return Voxelize(order);
    });
  } else if (const auto* save = std::get_if<SaveRequest>(&request)) {
    later([this, file = save->file]() -> std::optional<Answer> {
      const std::shared_ptr<const WorldModel> model = Model();
      if (!model) return Answer{false, "the scene is being loaded"};
      const std::optional<Error> why = WhyNoPlaceForScene(file, model->scene.file);
      return why ? Answer{false, why->what} : Write(file, std::nullopt, false);
    });
  } else if (const auto* mesh = std::get_if<LoadMeshRequest>(&request)) {
    later([this, job, order = *mesh] {
      return AddMesh(job, order);
    });
  } else if (const auto* load = std::get_if<LoadSceneRequest>(&request)) {
    later([this, job, file = load->file] {
      return AskForScene(job, file);
    });
  } else if (const auto* measure = std::get_if<MeasureDistancesRequest>(&request)) {
    later([this, on = measure->on] {
      return MeasureDistances(on);
    });
  }
}

Answer PeerControl::MeasureDistances(bool on) {
  const std::shared_ptr<const WorldModel> model = on ? Model() : nullptr;
  std::shared_ptr<DistanceMeter> meter;
  if (on && !model) return {false, "the scene is being loaded"};
  if (on) {
    Result<std::unique_ptr<DistanceMeter>> made =
        DistanceMeter::Make(*model, stop_, [this](int held, const SnapshotDistance& measured) {
          Post([held, measured](ControlServer& server) {
            server.OnDistance(held, measured);
          });
        });
    if (!made) return {false, made.error().what};
    meter = *std::move(made);
  }
  const std::lock_guard lock(posted_mutex_);
  measures_of_ = model.get();
  std::swap(meter, meter_);
  return {true, ""};
}

std::optional<Answer> PeerControl::AddMesh(std::uint64_t job, const LoadMeshRequest& mesh) {
  const std::filesystem::path file = mesh.file;
  std::error_code unknown;
  if (!file.is_absolute()) return Answer{false, "'" + mesh.file + "': expected an absolute path"};
  if (!std::filesystem::is_regular_file(file, unknown)) {
    return Answer{false, mesh.file + ": there is no such file"};
  }
  const Result<std::filesystem::path> folder = ControlFolder();
  if (!folder) return Answer{false, folder.error().what};
  const std::filesystem::path scenes = *folder / ScenesFolderOf(control_);
  std::error_code failed;
  std::filesystem::create_directory(scenes, failed);
  if (failed) return Answer{false, scenes.string() + ": " + failed.message()};
  const std::filesystem::path scene = scenes / ("with-" + std::to_string(job) + ".json");
  const Answer written = Write(scene,
                               AddedBody{.name = mesh.body,
                                         .mesh = file,
                                         .fixed = mesh.fixed,
                                         .shared = mesh.shared,
                                         .mass_kg = mesh.mass_kg},
                               true);
  if (!written.ok) return written;
  return AskForScene(job, scene);
}

std::optional<Answer> PeerControl::AskForScene(std::uint64_t job, const std::string& file) {
  {
    const std::lock_guard lock(posted_mutex_);
    if (load_) return Answer{false, "another scene is being loaded"};
  }
  // faults that can be seen at once are told before the present scene is left
  if (const Result<Scene> scene = LoadNamedScene(file); !scene) {
    return Answer{false, ReasonWithoutContent(SceneFile(file), scene.error().what)};
  }
  {
    const std::lock_guard lock(node_mutex_);
    if (node_ == nullptr) return Answer{false, "the scene is being loaded"};
    for (const PeerDirectory::Entry& entry : node_->directory().Entries()) {
      if (entry.presence == PeerDirectory::Presence::kHere && entry.refused.empty() &&
          entry.info.role == Role::kActive) {
        return Answer{false, "others take part in session " + session_ +
                                 " with this scene: open another scene in a session of its own"};
      }
    }
  }
  const std::lock_guard lock(posted_mutex_);
  load_ = Load{.job = job, .file = file, .before = {}, .fault = {}, .begun = false};
  return std::nullopt;
}

bool PeerControl::TakeLoad(PeerArguments& arguments) {
  const std::lock_guard lock(posted_mutex_);
  if (!load_ || load_->begun) return false;
  load_->begun = true;
  load_->before = arguments.scene;
  arguments.scene = load_->file;
  arguments.hold.clear();  // body of the previous scene
  return true;
}

bool PeerControl::RevertLoad(PeerArguments& arguments, const std::string& why) {
  const std::lock_guard lock(posted_mutex_);
  if (!load_ || !load_->begun || !load_->fault.empty()) return false;
  load_->fault = WithoutQuotedText(why);
  arguments.scene = load_->before;
  return true;
}

Answer PeerControl::Write(const std::filesystem::path& file, const std::optional<AddedBody>& added,
                          bool overwrite) {
  if (!file.is_absolute()) return {false, "'" + file.string() + "': expected an absolute path"};
  const std::shared_ptr<const WorldModel> kept = Model();
  if (!kept) return {false, "the scene is being loaded"};
  const WorldModel& model = *kept;
  // poses as the server saw them last, where that was this scene
  std::optional<std::vector<Pose>> poses = PosesOf(model);
  if (!poses) return {false, "the scene is being loaded"};
  std::vector<Pose> displaced(model.scene.bodies.size());
  for (std::size_t i = 0; i < displaced.size(); ++i) {
    const int moving = model.body_index[i];
    if (moving < 0 || static_cast<std::size_t>(moving) >= poses->size()) continue;
    const auto b = static_cast<std::size_t>(moving);
    displaced[i] = (*poses)[b] * model.bodies[b].X_WB0.Inverse();
  }
  const Result<bool> written = WriteCurrentScene(model.scene, displaced, added, file, overwrite);
  return written ? Answer{true, file.string()} : Answer{false, written.error().what};
}

std::optional<std::vector<Pose>> PeerControl::PosesOf(const WorldModel& model) {
  const std::lock_guard lock(posted_mutex_);
  if (poses_of_ != &model) return std::nullopt;
  return poses_;
}

Answer PeerControl::Voxelize(const VoxelizeRequest& request) {
  const std::shared_ptr<const WorldModel> model = Model();
  if (!model) return {false, "the scene is being loaded"};
  Scene scene = model->scene;
  if (request.voxel_size_m > 0) scene.voxel_size = request.voxel_size_m;
  scene.pairs.clear();
  scene.hands.clear();
  scene.bodies = {SceneBody{}};
  scene.bodies.front().name = "mesh";
  scene.bodies.front().mesh = request.file;
  scene.bodies.front().mass = 1;
  return VoxelsOf(scene, stop_loading_.get_token());
}

}  // namespace tandem
