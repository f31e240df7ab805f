#pragma once

#include <cstdint>
#include <deque>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "collab/controller/control_server.h"
#include "collab/simulated/hands/checkers/goal_hand_checker.h"
#include "collab/simulated/hands/checkers/host_checker.h"
#include "collab/simulated/hands/checkers/return_checker.h"
#include "collab/simulated/hands/checkers/view_checker.h"
#include "collab/simulated/hands/simulated_device_process.h"
#include "collab/simulated/network/simulated_session.h"
#include "collab/simulated/simulator.h"
#include "engine/haptics/workspace.h"

namespace tandem {

/// A message of a host to its controller, which gets it at `due_ns`.
struct HostMessage {
  std::int64_t due_ns = 0;  // true time
  HostId host = 0;
  std::string name;
  bool is_goal = false;
  HostGoal goal;
  std::uint64_t number = 0;
  ControlRequest request = ReleaseRequest{};
};

/// The answers and the newest snapshot that a controller has sent, for a host to fetch.
struct HostMail {
  std::vector<HostAnswer> answers;
  std::shared_ptr<const ControllerSnapshot> snapshot;  // newest; null: none since the host last
                                                       // looked
};

/// A controller in virtual time: a peer of the simulated session, the hand that hosts or a device
/// move, and the server of the hosts. The server gets its inputs as `tandem peer --control` gives
/// them. Facts come by the haptic thread as often as hosts want snapshots, requests come reliably,
/// and of goals the newest comes. The site shows all inputs and outputs to the checkers.
class SimulatedController : private ControlledPeer {
 public:
  struct Options {
    PeerId id = 0;
    std::string name;
    PeerClock clock;
    bool device = false;  // a device moves the hand
    std::size_t waiting = 0;
    std::uint64_t seed = 0;
    SeedLog log;  // requests, answers, and messages to the user
  };

  SimulatedController(SimulatedSession& session, const std::shared_ptr<const WorldModel>& model,
                      const Options& options, Violations& violations);

  PeerId id() const { return options_.id; }
  const std::string& name() const { return options_.name; }
  std::size_t member() const { return member_; }
  bool present() const { return session_->present(member_); }
  bool running() const { return present() && !session_->halted(member_); }
  PeerNode& node() const { return session_->node(member_); }
  SimulatedDeviceProcess* rig() const { return rig_.get(); }
  bool stopped() const { return server_.stopped(); }
  bool quits() const { return quits_; }
  /// Returns whether nothing is in hand or asked for and no answer is due.
  bool at_rest() const;

  /// BeforeFrame() and AfterFrame() enclose each frame of the session.
  void BeforeFrame();
  void AfterFrame(const TrueHolders& holders);

  void Send(HostMessage message);
  /// Opens a host's mail, which is then empty.
  void Attach(HostId host);
  void Detach(HostId host);
  HostMail TakeMail(HostId host);
  void HostWoken(HostId host) { view_.OnWoken(host, session_->now_ns()); }

  /// Types 'stop' or 'resume' at the controller.
  void Type(bool stop);
  void Halt(bool halted);

 private:
  // ControlledPeer
  bool Order(const Command& command) override;
  void Tell(const GoalOrder& order) override;
  void Begin(std::uint64_t job, const ControlRequest& request) override;
  void StopDevice(bool stop) override;
  bool ChangeWorkspace(const WorkspaceChange& change) override;
  void Quit() override { quits_ = true; }

  void TellPeers();
  void Tick(const TrueHolders& holders);
  void Deliver(HostMessage& message);
  void DeliverRequest(HostMessage& message);
  void GiveAnswers();
  void GiveAnswer(const HostAnswer& answer);
  void GiveSnapshot(const TrueHolders& holders);
  HandObservation See() const;
  void Log(const std::string& line) const;
  void LookOn();
  std::int64_t LocalNow() const { return session_->network().LocalNow(options_.id); }

  SimulatedSession* session_;
  std::shared_ptr<const WorldModel> model_;
  Options options_;
  Violations* violations_;
  std::unique_ptr<SimulatedDeviceProcess> rig_;  // null: hosts move the hand
  std::unique_ptr<Device> handle_;  // the controller's end of the device, which the workspace maps
                                    // into the scene
  Workspace* space_ = nullptr;      // workspace of the node
  WorkspaceOrder space_order_;
  std::shared_ptr<GoalDevice::Orders> goals_;
  GoalDevice* device_ = nullptr;
  std::size_t member_ = 0;
  ControlServer server_;
  GoalOrder reported_;
  SimulationFacts facts_;
  bool fresh_ = false;
  std::uint64_t frame_ = 0;
  std::int64_t next_snapshot_ns_ = 0;
  std::uint32_t facts_period_ = 50;
  std::deque<HostMessage> coming_;
  std::map<HostId, HostMail> mail_;
  struct Job {
    std::uint64_t number = 0;
    std::int64_t due_ns = 0;
    bool ok = true;
  };
  std::vector<Job> jobs_;
  SeededRandom rng_;
  bool quits_ = false;
  std::int64_t halted_ns_ = 0;  // time since which it is halted; 0: it runs
  std::map<std::pair<HostId, std::uint64_t>, SetParameterRequest> parameters_;

  GoalHandChecker hand_;
  HostChecker hosts_;
  ReturnChecker ways_;
  ViewChecker view_;
};

}  // namespace tandem
