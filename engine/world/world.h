#pragma once

#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "engine/base/thread_roles.h"
#include "engine/dynamics/coupled_step.h"
#include "engine/paging/resident_voxels.h"
#include "engine/world/applied_force_report.h"
#include "engine/world/body_radii.h"
#include "engine/world/instances.h"
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
  std::size_t instance_count() const noexcept { return instances_.size(); }
  /// Returns the body of an instance, as an index into the model's bodies.
  std::size_t shape_of(InstanceIndex instance) const noexcept { return instances_[instance].shape; }
  /// Returns the state of an instance. A body's own index is that of its first instance.
  const RigidState& state(InstanceIndex instance) const noexcept {
    return instances_[instance].state;
  }
  /// Puts an instance somewhere, at rest: before the first frame, or for tests.
  void Place(InstanceIndex instance, const Pose& X_WB);
  /// Returns a pair as of the last frame.
  const BodyPair& pair(std::size_t number) const noexcept { return *pairs_[number].contact; }
  /// Returns a pair of a scene of the plain model, which is checked, with its schedule.
  const ContactPair& point_pair(std::size_t number) const;
  /// Returns a pair of a scene of the refined model, which is checked.
  const FieldPair& field_pair(std::size_t number) const;
  /// Returns the number of pairs of first instances. Pairs of second instances come after these.
  std::size_t pair_count() const noexcept { return first_pairs_; }
  /// Return the instances of a pair; the voxmap's may be kFixture.
  InstanceIndex shell_of(std::size_t pair) const noexcept { return pairs_[pair].shell; }
  InstanceIndex voxmap_of(std::size_t pair) const noexcept { return pairs_[pair].map; }
  /// Tells whether the two of a pair pushed each other in the last frame.
  bool pushes(std::size_t pair) const noexcept { return pairs_[pair].pushes; }
  /// Tells whether an instance and another moving body pushed each other in the last frame.
  bool Pushed(InstanceIndex instance) const noexcept;
  /// Tells whether contact pushed an instance in the last frame, whatever it met.
  bool Touched(InstanceIndex instance) const noexcept;
  /// Returns the fixed bodies' voxels if they are in memory in part only; null if all are.
  const ResidentVoxels* resident_voxels() const noexcept { return resident_.get(); }
  /// Returns a line that says why voxels that a frame waits for do not come.
  std::string MissingVoxelsReason() const;
  /// Waits until the voxels that a frame waits for are in memory. For threads without deadlines.
  void WaitForVoxels();

  /// Simulates one frame of kFrame seconds.
  const StepReport& Step(const StepInputs& in) noexcept TANDEM_RUNS_ON(kHapticThread);

 private:
  struct Instance {
    std::size_t shape = 0;  // index into the model's bodies
    AxisRadii radii;
    RigidState state;
    LinearizedForce load;
    BodyDrive drive = BodyDrive::kInactive;  // drive in this frame
    double max_travel = 0;                   // greatest travel in this frame, m
    bool pushed = false;                     // contact pushes it in this frame
    double displaced = 0;   // greatest displacement of its points in either direction, m
    bool together = false;  // its twist is that of together_
    Twist before;           // its twist at the frame's start, if it is simulated
    Twist desired;          // the twist to which forces bring it, without the travel limit

    /// Tells whether forces move it at this peer.
    bool IsSimulated() const noexcept {
      return drive == BodyDrive::kSimulated || drive == BodyDrive::kCompliant;
    }
  };
  struct Pair {
    std::unique_ptr<BodyPair> contact;
    InstanceIndex shell;  // instance of the pointshell
    InstanceIndex map;    // instance of the voxmap, or kFixture
    bool pushes = false;  // pushed in this frame

    bool Has(InstanceIndex instance) const noexcept { return shell == instance || map == instance; }
  };

  static std::vector<Instance> MakeInstances(const WorldModel& model);
  void AddFixturePair(InstanceIndex instance, const ScheduleOptions& schedule);
  /// Adds a pair of two instances of different bodies.
  void AddPair(InstanceIndex a, InstanceIndex b, const ScheduleOptions& schedule);
  /// Announces the voxels that are read where bodies stand, and waits until they are in memory.
  void LoadPendingVoxels();

  // the phases of a frame
  /// Clears what the last frame found, and takes the drives of the inputs.
  void BeginFrame(const StepInputs& in) noexcept;
  /// Brings each pair's clearance nearer to its target.
  void UpdateClearances(const StepInputs& in) noexcept;
  /// Tells whether forces move an instance that no hand turns.
  bool Rolls(InstanceIndex index) const noexcept {
    return instances_[index].drive == BodyDrive::kSimulated && held_ != index;
  }
  /// Returns the pose and motion of an instance, for contact.
  BodyMotion MotionOf(InstanceIndex index) const noexcept;
  /// Tests all pairs; returns whether all could be tested.
  bool ComputeContactForces() noexcept;
  /// Finds how far each instance may go in the frame (MaxTravel).
  void LimitTravel(const StepInputs& in) noexcept;
  /// Adds the loads of mirrors that give way, of the hand and its links, and of gravity.
  void ApplyCouplings(const StepInputs& in) noexcept;
  /// Finds the twists of simulated instances at the frame's end.
  void SolveVelocities() noexcept;
  /// Moves all instances: by their twists, after their mirrors, or not at all.
  void Integrate(const StepInputs& in) noexcept;
  /// Reports the wrenches that the held body received.
  void ReportAppliedForces(const StepInputs& in) noexcept;
  const StepReport& EndFrame() noexcept;
  /// Ends a frame in which voxels lack: nothing moves.
  const StepReport& EndWaitingFrame() noexcept;

  /// Gives instances that begin to be simulated the twist of the inputs. A body that was moved from
  /// outside has no momentum of its own, because it may have gone a long way in a frame.
  void BeginSimulated(const StepInputs& in) noexcept;
  /// Tells whether forces move the instance of a pair at this peer; they never move the fixture.
  bool IsSimulated(InstanceIndex instance) const noexcept {
    return instance != kFixture && instances_[instance].IsSimulated();
  }
  bool IsActive(InstanceIndex instance) const noexcept {
    return instance == kFixture || instances_[instance].drive != BodyDrive::kInactive;
  }
  /// Tells whether a pair can push anything in this frame.
  bool Tested(const Pair& pair) const noexcept;
  /// Tells whether a pair pushes two instances that forces move.
  bool Couples(const Pair& pair) const noexcept;
  /// Solves for the twists of simulated instances that push one another, in one system.
  void SolveTogether() noexcept;
  /// Finds how the load on the held instance changes as the instances that it pushes move.
  void SumContactOfOthers() noexcept;

  std::shared_ptr<const WorldModel> model_;
  std::unique_ptr<ResidentVoxels> resident_;  // outlives pairs_
  std::vector<Instance> instances_;
  std::vector<Pair> pairs_;
  std::size_t first_pairs_ = 0;        // number of pairs of first instances, which come first
  std::optional<InstanceIndex> held_;  // instance in the hand in this frame
  CoupledStep together_;
  AppliedForceReport applied_forces_;
  bool contact_on_;  // experiments: off, bodies pass through one another
  int waited_ = 0;   // consecutive frames that waited for voxels
  WorkerPool* workers_;
  StepReport report_;
};

}  // namespace tandem
