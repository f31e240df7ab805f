#pragma once

#include <memory>
#include <span>
#include <vector>

#include "engine/base/thread_roles.h"
#include "engine/dynamics/coupled_step.h"
#include "engine/paging/resident_voxels.h"
#include "engine/world/step_inputs.h"
#include "engine/world/world_model.h"

namespace tandem {

inline constexpr double kFrame = 1e-3;  // s

/// The simulation of one peer, frame by frame (paper §2.1, §5, §6). Used by one thread, the haptic
/// one; nothing in Step() allocates, locks, throws or reads a clock, and the same inputs give the
/// same bits.
class World {
 public:
  /// `schedule`: which of the paper's savings are in use, all, but for comparisons; and the threads
  /// that help, if any.
  explicit World(std::shared_ptr<const WorldModel> model, const ScheduleOptions& schedule = {});

  const WorldModel& model() const noexcept { return *model_; }
  const RigidState& state(std::size_t body) const noexcept { return bodies_[body].state; }
  /// Puts a body somewhere, at rest: before the first frame, or for tests.
  void Place(std::size_t body, const Pose& X_WB);
  /// A pair as of the last frame.
  const BodyPair& pair(std::size_t number) const noexcept { return *pairs_[number].contact; }
  /// The same of a scene of the plain model, which is checked: with its schedule.
  const ContactPair& point_pair(std::size_t number) const;
  /// The same of a scene of the refined model, which is checked.
  const FieldPair& field_pair(std::size_t number) const;
  std::size_t pair_count() const noexcept { return first_pairs_; }
  /// Where others' second instance of a shared body is here (paper §6.1, mixed types): the body
  /// itself while there is only one.
  const RigidState& second_state(std::size_t body) const noexcept {
    return bodies_[bodies_[body].second >= 0 ? static_cast<std::size_t>(bodies_[body].second)
                                             : body]
        .state;
  }
  /// The bodies of a pair; a voxmap of -1 is the fixture's.
  int shell_of(std::size_t pair) const noexcept { return pairs_[pair].shell; }
  int voxmap_of(std::size_t pair) const noexcept { return pairs_[pair].map; }
  /// Tells whether the bodies of a pair pushed each other in the last frame.
  bool pushes(std::size_t pair) const noexcept { return pairs_[pair].pushes; }
  /// Whether a body that moves here and another moving one pushed each other in the last frame.
  bool Pushed(std::size_t body) const noexcept;
  /// Whether contact pushed a body in the last frame, whatever it met.
  bool Touched(std::size_t body) const noexcept;
  /// The same as Pushed() of a shared body's second instance.
  bool SecondPushed(std::size_t body) const noexcept {
    return bodies_[body].second >= 0 && Pushed(static_cast<std::size_t>(bodies_[body].second));
  }
  /// The fixed bodies' voxels, where they are in memory in part only; null where all are.
  const ResidentVoxels* resident_voxels() const noexcept { return resident_.get(); }
  /// Says why voxels that a frame waits for do not come, in a line.
  std::string WhyVoxelsLack() const;
  /// Waits until voxels are there that a frame waits for. For threads without deadlines.
  void WaitForVoxels();
  /// Bodies pass through one another: for comparison only.
  void SwitchContactOff() noexcept { contact_on_ = false; }

  /// One frame of kFrame seconds.
  const StepReport& Step(const StepInputs& in) noexcept TANDEM_RUNS_ON(kHapticThread);

 private:
  struct Body {
    RigidState state;
    Load load;
    BodyDrive drive = BodyDrive::kParked;  // in the last frame
    double max_travel = 0;                 // m, in this frame
    double displaced = 0;                  // m, the most that its points are, either way
    bool together = false;                 // its twist is that of together_
    std::size_t shape = 0;  // into the model's bodies; its own number, but of a second instance
    int second = -1;        // its second instance, of a shared body
  };
  struct Pair {
    std::unique_ptr<BodyPair> contact;
    int shell;            // body of the pointshell
    int map;              // body of the voxmap; -1: the fixture
    bool pushes = false;  // in this frame
  };

  /// A pair of bodies that both move, by number.
  void AddPair(std::size_t a, std::size_t b, const ScheduleOptions& schedule);
  ContactGains GainsFor(double mass) const;
  double ShiftOf(const Body& body) const;  // inward shift of its surface, voxels
  /// Brings each pair's clearance nearer to what it shall be.
  void GoToClearance(const StepInputs& in) noexcept;
  BodyDrive DriveOf(const StepInputs& in, std::size_t body) const noexcept;
  /// Whether forces move it here; of a body's number, or -1 for the fixture.
  bool IsSimulated(const StepInputs& in, int body) const noexcept;
  /// What was moved from outside has no momentum of its own, for it may have come a long way in a
  /// frame: it has what the inputs say.
  void BeginSimulated(const StepInputs& in) noexcept;
  void ShareTravel(const StepInputs& in) noexcept;
  /// Whether a pair can push anything in this frame.
  bool Tested(const Pair& pair, const StepInputs& in) const noexcept;
  /// Gives whether all could be tested.
  bool Collide(const StepInputs& in) noexcept;
  /// Says which voxels are read where bodies stand, and waits until they are there.
  void BringInVoxels();
  void Couple(const StepInputs& in) noexcept;
  /// What contact puts on the held body in the step that takes it from one twist to another.
  Wrench AppliedContact(const Twist& before, const Twist& after) const noexcept;
  /// The twists of simulated bodies that push one another, in one system.
  void SolveTogether(const StepInputs& in) noexcept;
  void Move(const StepInputs& in) noexcept;

  std::shared_ptr<const WorldModel> model_;
  std::unique_ptr<ResidentVoxels> resident_;  // outlives pairs_
  std::vector<Body> bodies_;
  std::vector<Pair> pairs_;
  std::size_t first_pairs_ = 0;  // the others are of second instances
  CoupledStep together_;
  Load hand_load_;
  Load contact_load_;                      // on the held body, at the frame's start
  Vec6 contact_of_others_ = Vec6::Zero();  // what it gains in the step as others move
  std::array<CentreLoad, kMaxLinkAnchors> link_loads_;
  bool contact_on_ = true;
  int waited_ = 0;  // frames on end for voxels
  FrameHelpers* helpers_;
  StepReport report_;
};

}  // namespace tandem
