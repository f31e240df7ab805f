#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "collab/simulated/hands/controller_site.h"
#include "collab/simulated/hands/hands_simulator.h"
#include "collab/simulated/hands/simulated_host.h"
#include "collab/simulated/session_checker.h"
#include "engine/base/hash.h"

namespace tandem {

/// A session of hands: who may come to it, and over which links. Those who come first are its first
/// peers; the others take the places of those who are killed.
FaultSchedule DrawHandsSchedule(std::uint64_t seed, SeedDice& dice);

/// One session of hands, millisecond by millisecond.
class HandsRun {
 public:
  HandsRun(std::uint64_t seed, double seconds, const std::shared_ptr<const WorldModel>& model,
           const SeedLog& log);
  ~HandsRun() { session_.network().SetWatch(nullptr); }
  HandsRun(const HandsRun&) = delete;
  HandsRun& operator=(const HandsRun&) = delete;

  SeedResult Go();

 private:
  struct Pause {  // of a controller, or of a device's process
    std::size_t site = 0;
    std::int64_t until_ms = 0;
  };

  // what happens (hands_events.cpp)
  void Happen();
  void Something();
  void Join(std::size_t peer);
  void SwitchLink(std::size_t from, std::size_t to, const LinkConditions& conditions);
  void Vanish(std::size_t site, bool kill);
  void PauseController(std::size_t site);
  void TroubleDevice(std::size_t site);
  void EndTroubles();
  void MoreHosts();
  void EndAll();
  std::size_t SomeSite();
  void Log(const std::string& line);

  // a frame
  void Frame();
  void Step();
  void SeeHolders();
  void Digest();
  bool AllAtRest();
  /// Of all bodies at all sites.
  std::vector<Pose> Poses() const;
  void LookAtEnd();

  std::int64_t now_ns() const { return session_.now_ns(); }

  SeedDice dice_;
  FaultSchedule schedule_;
  std::shared_ptr<const WorldModel> model_;
  SeedLog log_;
  std::int64_t events_end_ms_;
  std::int64_t ms_ = 0;
  Tally tally_;
  SessionChecker checker_;
  Viewer viewer_;
  // nodes end before what their devices share with them
  std::vector<std::unique_ptr<ControllerSite>> sites_;
  SimulatedSession session_;
  std::unique_ptr<Transport> viewer_link_;
  std::vector<int> member_;  // of the session, for each scheduled peer; -1: not yet there
  std::vector<std::unique_ptr<SimulatedHost>> hosts_;
  std::vector<Pause> pauses_;
  std::map<std::size_t, std::int64_t> trouble_until_ms_;  // by site: of its device
  std::size_t next_peer_ = 0;
  std::vector<std::int64_t> joins_ms_;  // of those who replace others
  std::int64_t next_event_ms_ = 1500;
  HostId next_host_ = 1;
  TrueHolders holders_;
  std::vector<bool> running_;  // sites, a frame ago
  std::vector<Pose> last_poses_;
  std::size_t told_ = 0;
  Hash64 digest_;
  double peer_seconds_ = 0;
};

}  // namespace tandem
