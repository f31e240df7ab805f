#pragma once

#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <deque>
#include <filesystem>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <stop_token>
#include <string>
#include <thread>
#include <vector>

#include "app/judgement/distance_meter.h"
#include "app/peer/current_scene.h"
#include "app/peer/peer_options.h"
#include "app/peer/session_setup.h"
#include "collab/controller/control_server.h"
#include "collab/dds/control/control_port.h"
#include "engine/realtime/triple_buffer.h"

namespace tandem {

/// A peer as a controller (paper §6): what `tandem peer --control NAME` adds. It outlives the
/// scenes that are loaded one after the other.
///
/// The server and the port to the hosts belong to a thread of their own. Another thread reads and
/// writes files. The haptic thread gives facts and takes goals through triple buffers. The control
/// thread calls Tick() 50 times a second.
class PeerControl : private ControlledPeer {
 public:
  /// Errors: those of ControlPort::Open().
  static Result<std::unique_ptr<PeerControl>> Open(PeerArguments& arguments);
  ~PeerControl() override;
  PeerControl(const PeerControl&) = delete;
  PeerControl& operator=(const PeerControl&) = delete;

  /// Begin() tells that a session has been joined, End() that it is about to be left.
  void Begin(const PeerArguments& arguments, SessionSetup& setup);
  void End();

  /// The haptic thread calls these before and after each frame.
  void BeforeFrame() noexcept TANDEM_RUNS_ON(kHapticThread);
  void AfterFrame(std::int64_t now_ns) noexcept TANDEM_RUNS_ON(kHapticThread);

  /// The functions below are the control thread's.
  enum class Wish : std::uint8_t { kGoOn, kQuit, kJoinAgain };
  Wish Tick(PeerTable& table);
  PeerNode::OnHand on_hand();
  void OnLine(const std::string& line);
  /// Gives a typed order, as the node's queue does.
  bool Order(const Command& command) override;
  /// Puts the scene that a host asked for into the arguments, if there is one. If that scene cannot
  /// be joined, RevertLoad() restores the previous one, once, and the host gets the reason.
  bool TakeLoad(PeerArguments& arguments);
  bool RevertLoad(PeerArguments& arguments, const std::string& why);

 private:
  struct Load {
    std::uint64_t job = 0;
    std::string file;
    std::string before;
    std::string fault;  // reason why the previous scene came back; empty: it did not
    bool begun = false;
  };

  PeerControl(std::unique_ptr<ControlPort> port, const PeerArguments& arguments, bool device_hand);
  void Run();
  void RunJobs();
  void KeepPoses(const SimulationFacts& facts);
  /// Hands work to the server's thread.
  void Post(std::function<void(ControlServer&)> what);
  bool Push(const Command& command);
  void TellStop();
  std::vector<SnapshotPeer> Peers(const PeerTable& table) const;
  std::shared_ptr<const WorldModel> Model();

  // ControlledPeer; the server's thread calls these
  void Tell(const GoalOrder& order) override;
  void Begin(std::uint64_t job, const ControlRequest& request) override;
  void StopDevice(bool stop) override;
  bool ChangeWorkspace(const WorkspaceChange& change) override { return space_->Change(change); }
  void Quit() override {
    quit_ = true;
    stop_loading_.request_stop();
  }
  // The jobs' thread calls these. Nothing: the answer comes when the scene is there.
  std::optional<Answer> AddMesh(std::uint64_t job, const LoadMeshRequest& mesh);
  std::optional<Answer> AskForScene(std::uint64_t job, const std::string& file);
  /// Writes the scene as it stands, with one more body if there is one to add.
  Answer Write(const std::filesystem::path& file, const std::optional<AddedBody>& added,
               bool overwrite);
  Answer MeasureDistances(bool on);
  Answer Voxelize(const VoxelizeRequest& request);
  /// Returns the poses of that scene's moving bodies; nothing: the scene has just been loaded.
  std::optional<std::vector<Pose>> PosesOf(const WorldModel& model);

  std::unique_ptr<ControlPort> port_;
  const std::string session_;
  const std::string control_;
  ControlServer server_;
  std::shared_ptr<GoalDevice::Orders> goals_;
  std::shared_ptr<DeviceSpace> space_;
  GoalDevice* device_ = nullptr;  // device of the node; null: another kind
  std::mutex stop_mutex_;
  bool device_stopped_ = false;
  bool stop_untold_ = false;  // the node has not got the last stop or resume yet
  bool flood_told_ = false;   // used by the control thread
  std::atomic<bool> quit_{false};
  std::stop_source stop_loading_;
  std::atomic<bool> stop_{false};
  std::uint64_t frame_ = 0;  // number over all scenes; used by the haptic thread
  std::atomic<std::uint32_t> facts_period_{50};  // frames
  TripleBuffer<SimulationFacts> facts_;
  std::mutex node_mutex_;  // guards node_ and model_
  PeerNode* node_ = nullptr;
  std::shared_ptr<const WorldModel> model_;
  std::mutex posted_mutex_;
  std::vector<std::function<void(ControlServer&)>> posted_;
  std::vector<std::string> lines_;  // lines that the control thread is to say
  std::optional<Load> load_;
  std::deque<std::pair<std::uint64_t, std::function<std::optional<Answer>()>>> jobs_;
  std::condition_variable job_came_;
  std::shared_ptr<DistanceMeter> meter_;     // null: nobody has asked for distances
  const WorldModel* measures_of_ = nullptr;  // scene that meter_ measures
  std::vector<Pose> poses_;                  // recent poses of the moving bodies
  const WorldModel* poses_of_ = nullptr;
  std::int64_t poses_ns_ = 0;
  std::uint64_t scene_number_ = 0;
  std::uint64_t scene_shown_ = 0;  // used by the server's thread
  int turns_ = 0;
  std::thread jobs_thread_;  // runs what takes long
  std::thread thread_;       // runs the server
};

}  // namespace tandem
