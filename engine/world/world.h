#pragma once

#include <memory>
#include <span>
#include <vector>

#include "engine/base/thread_roles.h"
#include "engine/dynamics/coupled_step.h"
#include "engine/paging/resident_voxels.h"
#include "engine/world/held_loads.h"
#include "engine/world/step_inputs.h"
#include "engine/world/world_model.h"

namespace tandem {

/// Simulates the scene of one peer, frame by frame (paper §2.1, §5, §6). Used by one thread, the
/// haptic thread. Nothing in Step() allocates, locks, throws or reads a clock, and the same inputs
/// give the same bits.
class World {
 public:
  /// `schedule`: the paper's savings that are in use (all, except in comparisons), and the threads
  /// that help, if any.
  explicit World(std::shared_ptr<const WorldModel> model, const ScheduleOptions& schedule = {});

  const WorldModel& model() const noexcept { return *model_; }
  const RigidState& state(std::size_t body) const noexcept { return bodies_[body].state; }
  /// Puts a body somewhere, at rest: before the first frame, or for tests.
  void Place(std::size_t body, const Pose& X_WB);
  /// Returns a pair as of the last frame.
  const BodyPair& pair(std::size_t number) const noexcept { return *pairs_[number].contact; }
  /// Returns a pair of a scene of the plain model, which is checked, with its schedule.
  const ContactPair& point_pair(std::size_t number) const;
  /// Returns a pair of a scene of the refined model, which is checked.
  const FieldPair& field_pair(std::size_t number) const;
  std::size_t pair_count() const noexcept { return first_pairs_; }
  /// Returns the state of the second instance of a shared body (paper §6.1, mixed types): of the
  /// body itself while it has only one.
  const RigidState& second_state(std::size_t body) const noexcept {
    return bodies_[bodies_[body].second >= 0 ? static_cast<std::size_t>(bodies_[body].second)
                                             : body]
        .state;
  }
  /// Return the bodies of a pair; a voxmap of -1 is the fixture's.
  int shell_of(std::size_t pair) const noexcept { return pairs_[pair].shell; }
  int voxmap_of(std::size_t pair) const noexcept { return pairs_[pair].map; }
  /// Tells whether the bodies of a pair pushed each other in the last frame.
  bool pushes(std::size_t pair) const noexcept { return pairs_[pair].pushes; }
  /// Tells whether a body and another moving body pushed each other in the last frame.
  bool Pushed(std::size_t body) const noexcept;
  /// Tells whether contact pushed a body in the last frame, whatever it met.
  bool Touched(std::size_t body) const noexcept;
  /// Tells the same as Pushed() for a shared body's second instance.
  bool SecondPushed(std::size_t body) const noexcept {
    return bodies_[body].second >= 0 && Pushed(static_cast<std::size_t>(bodies_[body].second));
  }
  /// Returns the fixed bodies' voxels if they are in memory in part only; null if all are.
  const ResidentVoxels* resident_voxels() const noexcept { return resident_.get(); }
  /// Returns a line that says why voxels that a frame waits for do not come.
  std::string WhyVoxelsLack() const;
  /// Waits until the voxels that a frame waits for are in memory. For threads without deadlines.
  void WaitForVoxels();
  /// Lets bodies pass through one another: for comparison only.
  void SwitchContactOff() noexcept { contact_on_ = false; }

  /// Simulates one frame of kFrame seconds.
  const StepReport& Step(const StepInputs& in) noexcept TANDEM_RUNS_ON(kHapticThread);

 private:
  struct Body {
    RigidState state;
    Load load;
    BodyDrive drive = BodyDrive::kParked;  // drive in the last frame
    double max_travel = 0;                 // greatest travel in this frame, m
    double displaced = 0;   // greatest displacement of its points in either direction, m
    bool together = false;  // its twist is that of together_
    Twist before;           // its twist at the frame's start, if it is simulated
    Twist wanted;           // the twist to which forces bring it, without the travel limit
    /// Index into the model's bodies; differs from its own only for a second instance.
    std::size_t shape = 0;
    int second = -1;  // its second instance, for a shared body
  };
  struct Pair {
    std::unique_ptr<BodyPair> contact;
    int shell;            // body of the pointshell
    int map;              // body of the voxmap; -1: the fixture
    bool pushes = false;  // pushed in this frame
  };

  void AddFixturePair(std::size_t body, const ScheduleOptions& schedule);
  /// Adds a pair of bodies that both move, by number.
  void AddPair(std::size_t a, std::size_t b, const ScheduleOptions& schedule);
  void AddSecondInstance(std::size_t body, const ScheduleOptions& schedule);
  /// Announces the voxels that are read where bodies stand, and waits until they are in memory.
  void BringInVoxels();

  // the phases of a frame
  /// Clears what the last frame found, and takes over what begins to be simulated.
  void BeginFrame(const StepInputs& in) noexcept;
  /// Brings each pair's clearance nearer to its target.
  void UpdateClearances(const StepInputs& in) noexcept;
  /// Tests all pairs; returns whether all could be tested.
  bool ComputeContactForces(const StepInputs& in) noexcept;
  /// Finds how far each body may go in the frame (MaxTravel).
  void LimitTravel(const StepInputs& in) noexcept;
  /// Adds the loads of mirrors that give way, of the hand and its links, and of gravity.
  void ApplyCouplings(const StepInputs& in) noexcept;
  /// Finds the twists of simulated bodies at the frame's end.
  void SolveVelocities(const StepInputs& in) noexcept;
  /// Moves all bodies: by their twists, after their mirrors, or not at all.
  void Integrate(const StepInputs& in) noexcept;
  /// Reports the wrenches that the held body received.
  void ReportAppliedForces(const StepInputs& in) noexcept;
  const StepReport& EndFrame() noexcept;
  /// Ends a frame in which voxels lack: nothing moves.
  const StepReport& EndFrameThatWaits() noexcept;

  BodyDrive DriveOf(const StepInputs& in, std::size_t body) const noexcept;
  /// Tells whether forces move a body at this peer. `body`: its number, or -1 for the fixture.
  bool IsSimulated(const StepInputs& in, int body) const noexcept;
  /// Gives bodies that begin to be simulated the twist of the inputs. A body that was moved from
  /// outside has no momentum of its own, because it may have gone a long way in a frame.
  void BeginSimulated(const StepInputs& in) noexcept;
  /// Tells whether a pair can push anything in this frame.
  bool Tested(const Pair& pair, const StepInputs& in) const noexcept;
  /// Solves for the twists of simulated bodies that push one another, in one system.
  void SolveTogether(const StepInputs& in) noexcept;
  void SumContactOfOthers(const StepInputs& in) noexcept;

  std::shared_ptr<const WorldModel> model_;
  std::unique_ptr<ResidentVoxels> resident_;  // outlives pairs_
  std::vector<Body> bodies_;
  std::vector<Pair> pairs_;
  /// Number of pairs of first instances; the others belong to second instances.
  std::size_t first_pairs_ = 0;
  CoupledStep together_;
  HeldLoads held_loads_;
  bool contact_on_ = true;
  int waited_ = 0;  // consecutive frames that waited for voxels
  FrameHelpers* helpers_;
  StepReport report_;
};

}  // namespace tandem
