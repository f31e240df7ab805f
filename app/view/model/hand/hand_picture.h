#pragma once

#include <optional>
#include <string>
#include <vector>

#include "app/view/model/hand/triad.h"
#include "app/view/model/scene/picture_composer.h"
#include "collab/controller/snapshot.h"
#include "collab/session/viewer.h"

namespace tandem {

Pose ToPose(const PlainPose& X);
PlainPose ToPlain(const Pose& X);

/// A line from the grabbed point of a part to the hand's goal for that point. It shows the force of
/// a hand without force feedback.
struct Tether {
  Vec3 from_W = Vec3::Zero();  // grabbed point of the part
  Vec3 to_W = Vec3::Zero();    // goal
  double force_N = 0;
  bool operator==(const Tether&) const = default;
};

/// A contact of the part in hand.
struct ContactMark {
  Vec3 p_W = Vec3::Zero();
  Vec3 n_W = Vec3::Zero();  // normal, away from the other surface
  double force_N = 0;
  bool operator==(const ContactMark&) const = default;
};

/// The drawing of the user's own hand, beside the bodies.
struct HandPicture {
  std::optional<Tether> tether;
  std::vector<ContactMark> contacts;
  std::optional<Pose> X_WT;                            // pose of the triad
  std::optional<TriadHandle> hot;                      // handle under the cursor, or in use
  std::optional<std::pair<Vec3, Vec3>> locked_line_W;  // point and direction of the locked axis
  bool figures = true;                                 // true: the force stands beside the tether
  bool operator==(const HandPicture& other) const;
};

/// Converts a controller's snapshot to a viewer's picture. This user comes first, as the owner of
/// all bodies that no other user has alone. `name` is the user's. `alive`: the controller answers;
/// else its user is lost, and of the others nothing is known.
ViewerPicture PictureOf(const ControllerSnapshot& snapshot, const std::string& name,
                        bool alive = true);

/// Returns a snapshot of a controller that is gone: the bodies where they were, and no hand.
ControllerSnapshot WithoutHand(const ControllerSnapshot& last);

/// Adds this user's goal as a faint ghost of the part in hand. Puts the part where the newest
/// snapshot has it, and tints it while it is in contact. `goal`: the newest goal, which the
/// controller may not have received yet.
void AddGoal(const ControllerSnapshot& snapshot, const Pose& goal,
             const std::vector<BodyLook>& bodies, DrawList& list);

/// Makes the tether to `goal` and the contacts; empty: the hand is empty.
HandPicture HandPictureOf(const ControllerSnapshot& snapshot, const Pose& goal);

/// Returns a colour from green (no force) by amber to red (`kTetherFullForce` or more).
Colour ForceColour(double force_N);
inline constexpr double kTetherFullForce = 10;  // N

}  // namespace tandem
