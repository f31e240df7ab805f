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

#include "app/cli/distance_meter.h"
#include "app/cli/joining.h"
#include "app/cli/peer_options.h"
#include "app/cli/scene_as_it_stands.h"
#include "collab/controller/control_server.h"
#include "collab/dds/control_port.h"
#include "engine/realtime/triple_buffer.h"

namespace tandem {

/// A peer as a controller (paper §6): what `tandem peer --control NAME` adds. It outlives the
/// scenes that are loaded one after the other.
///
/// The server and the door to the hosts belong to a thread of their own; files are read and written
/// on another one. The haptic thread gives
/// facts and takes goals through triple buffers; the control thread looks in 50 times a second.
class PeerControl : private ControlledPeer {
 public:
  /// Errors: those of ControlPort::Open().
  static Result<std::unique_ptr<PeerControl>> Open(PeerArguments& arguments);
  ~PeerControl() override;
  PeerControl(const PeerControl&) = delete;
  PeerControl& operator=(const PeerControl&) = delete;

  /// A session has been joined, and is about to be left.
  void Begin(const PeerArguments& arguments, Joining& joining);
  void End();

  /// The haptic thread's, before and after each frame.
  void BeforeFrame() noexcept TANDEM_RUNS_ON(kHapticThread);
  void AfterFrame(std::int64_t now_ns) noexcept TANDEM_RUNS_ON(kHapticThread);

  /// The control thread's.
  enum class Wish : std::uint8_t { kGoOn, kQuit, kJoinAgain };
  Wish Turn(PeerTable& table);
  PeerNode::OnHand on_hand();
  void OnLine(const std::string& line);
  /// The same as the node's queue; for orders that are typed.
  bool Order(const Command& command) override;
  /// Puts the scene that a host asked for into the arguments, if one did. Where that could not be joined,
  /// RevertLoad() has the one before, once, and the host is told why.
  bool TakeLoad(PeerArguments& arguments);
  bool RevertLoad(PeerArguments& arguments, const std::string& why);

 private:
  struct Load {
    std::uint64_t job = 0;
    std::string file;
    std::string before;
    std::string fault;  // why the scene is the one before all the same
    bool begun = false;
  };

  PeerControl(std::unique_ptr<ControlPort> port, const PeerArguments& arguments, bool device_hand);
  void Run();
  void RunJobs();
  void KeepPoses(const SimulationFacts& facts);
  /// To the server's thread.
  void Post(std::function<void(ControlServer&)> what);
  bool Push(const Command& command);
  void TellStop();
  std::vector<SnapshotPeer> Peers(const PeerTable& table) const;
  std::shared_ptr<const WorldModel> Model();

  // ControlledPeer, called by the server's thread
  void Tell(const GoalOrder& order) override;
  void Begin(std::uint64_t job, const ControlRequest& request) override;
  void StopDevice(bool stop) override;
  bool ChangeWorkspace(const WorkspaceChange& change) override { return space_->Change(change); }
  void Quit() override {
    quit_ = true;
    stop_loading_.request_stop();
  }
  // on the jobs' thread; nothing: the answer comes when the scene is there
  std::optional<Answer> AddMesh(std::uint64_t job, const LoadMeshRequest& mesh);
  std::optional<Answer> AskForScene(std::uint64_t job, const std::string& file);
  /// Writes the scene as it stands, with one body more if there is one to add.
  Answer Write(const std::filesystem::path& file, const std::optional<AddedBody>& added,
               bool overwrite);
  Answer MeasureDistances(bool on);
  Answer Voxelize(const VoxelizeRequest& request);
  /// Where the moving bodies of that scene are; nothing: it has just been loaded.
  std::optional<std::vector<Pose>> PosesOf(const WorldModel& model);

  std::unique_ptr<ControlPort> port_;
  const std::string session_;
  const std::string control_;
  ControlServer server_;
  std::shared_ptr<GoalDevice::Orders> goals_;
  std::shared_ptr<DeviceSpace> space_;
  GoalDevice* device_ = nullptr;  // of the node; null: another kind
  std::mutex stop_mutex_;
  bool device_stopped_ = false;
  bool stop_untold_ = false;  // the node has not heard of that yet
  bool flood_told_ = false;   // the control thread's
  std::atomic<bool> quit_{false};
  std::stop_source stop_loading_;
  std::atomic<bool> stop_{false};
  std::uint64_t frame_ = 0;                      // the haptic thread's, over all scenes
  std::atomic<std::uint32_t> facts_period_{50};  // frames
  TripleBuffer<SimulationFacts> facts_;
  std::mutex node_mutex_;  // whoever orders, or reads the directory
  PeerNode* node_ = nullptr;
  std::shared_ptr<const WorldModel> model_;
  std::mutex posted_mutex_;
  std::vector<std::function<void(ControlServer&)>> posted_;
  std::vector<std::string> lines_;  // for the control thread to say
  std::optional<Load> load_;
  std::deque<std::pair<std::uint64_t, std::function<std::optional<Answer>()>>> jobs_;
  std::condition_variable job_came_;
  std::shared_ptr<DistanceMeter> meter_;     // null: nobody has asked for distances
  const WorldModel* measures_of_ = nullptr;  // of that scene
  std::vector<Pose> poses_;                  // of the moving bodies, not long ago
  const WorldModel* poses_of_ = nullptr;
  std::int64_t poses_ns_ = 0;
  std::uint64_t scene_number_ = 0;
  std::uint64_t scene_shown_ = 0;  // the server's thread's
  int turns_ = 0;
  std::thread jobs_thread_;  // for what takes long
  std::thread thread_;       // the server's
};

}  // namespace tandem
