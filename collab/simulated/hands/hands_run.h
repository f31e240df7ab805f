#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "collab/simulated/checkers/session_checker.h"
#include "collab/simulated/hands/hands_simulator.h"
#include "collab/simulated/hands/simulated_controller.h"
#include "collab/simulated/hands/simulated_host.h"
#include "engine/base/hash.h"

namespace tandem {

/// Draws the peers and links of a session of hands. The first peers of the schedule begin it; the
/// others replace peers that are killed or leave.
FaultSchedule DrawHandsSchedule(std::uint64_t seed, SeededRandom& rng);

/// A session of hands, millisecond by millisecond.
class HandsRun {
 public:
  HandsRun(std::uint64_t seed, double seconds, const std::shared_ptr<const WorldModel>& model,
           const SeedLog& log);
  ~HandsRun() { session_.network().SetWatch(nullptr); }
  HandsRun(const HandsRun&) = delete;
  HandsRun& operator=(const HandsRun&) = delete;

  SeedResult Run();

 private:
  struct Pause {  // pause of a controller
    std::size_t site = 0;
    std::int64_t until_ms = 0;
  };

  // events (hands_events.cpp)
  void RunDueEvents();
  void RandomEvent();
  void Join(std::size_t peer);
  void SwitchLink(std::size_t from, std::size_t to, const LinkConditions& conditions);
  void RemoveSite(std::size_t site, bool kill);
  void PauseController(std::size_t site);
  void FailDevice(std::size_t site);
  void EndDeviceFailures();
  void AddHosts();
  void EndAll();
  std::size_t SomeSite();
  void Log(const std::string& line);

  // the parts of a frame
  void Frame();
  void Step();
  void SeeHolders();
  void Digest();
  bool AllAtRest();
  /// Returns the poses of all bodies at all sites.
  std::vector<Pose> Poses() const;
  void CheckEnd();

  std::int64_t now_ns() const { return session_.now_ns(); }

  SeededRandom rng_;
  FaultSchedule schedule_;
  std::shared_ptr<const WorldModel> model_;
  SeedLog log_;
  std::int64_t events_end_ms_;
  std::int64_t ms_ = 0;
  Tally tally_;
  SessionChecker checker_;
  Viewer viewer_;
  // nodes must end before the memory that their devices share with them
  std::vector<std::unique_ptr<SimulatedController>> sites_;
  SimulatedSession session_;
  std::unique_ptr<Transport> viewer_link_;
  std::vector<int> member_;  // number in the session of each scheduled peer; -1: not there yet
  std::vector<std::unique_ptr<SimulatedHost>> hosts_;
  std::vector<Pause> pauses_;
  std::map<std::size_t, std::int64_t> trouble_until_ms_;  // per site: end of its device's trouble
  std::size_t next_peer_ = 0;
  std::vector<std::int64_t> joins_ms_;  // times at which replacements join
  std::int64_t next_event_ms_ = 1500;
  HostId next_host_ = 1;
  TrueHolders holders_;
  std::vector<bool> running_;  // per site: running a frame ago
  std::vector<Pose> last_poses_;
  std::size_t reported_ = 0;
  Hash64 digest_;
  double peer_seconds_ = 0;
};

}  // namespace tandem
