#pragma once

#include <optional>
#include <string>
#include <vector>

#include "app/view/model/picture_composer.h"
#include "app/view/model/triad.h"
#include "collab/controller/snapshot.h"
#include "collab/viewer.h"

namespace tandem {

Pose ToPose(const PlainPose& X);
PlainPose ToPlain(const Pose& X);

/// A band from the grabbed point of a part to where a hand wants that point: the force of a hand
/// without force feedback, for the eye.
struct Tether {
  Vec3 from_W = Vec3::Zero();  // at the part
  Vec3 to_W = Vec3::Zero();    // the goal
  double force_N = 0;
  bool operator==(const Tether&) const = default;
};

/// A contact of the part in hand.
struct ContactMark {
  Vec3 p_W = Vec3::Zero();
  Vec3 n_W = Vec3::Zero();  // away from the surface that is met
  double force_N = 0;
  bool operator==(const ContactMark&) const = default;
};

/// What is drawn of the user's own hand, beside the bodies.
struct HandPicture {
  std::optional<Tether> tether;
  std::vector<ContactMark> contacts;
  std::optional<Pose> X_WT;                            // of the triad
  std::optional<TriadHandle> hot;                      // the handle under the cursor, or in use
  std::optional<std::pair<Vec3, Vec3>> locked_line_W;  // a point of it and its direction
  bool figures = true;                                 // the force stands beside the tether
  bool operator==(const HandPicture& other) const;
};

/// The controller's view of the session, in the words of a viewer: this user first, as the owner of
/// the bodies that nobody else has alone. `name` is the user's.
ViewerPicture PictureOf(const ControllerSnapshot& snapshot, const std::string& name);

/// Adds this user's goal as a faint ghost of the part in hand, puts the part where the newest
/// snapshot has it, and tints it while it is in contact. `goal`: the newest one, which the
/// controller may not have heard yet.
void AddGoal(const ControllerSnapshot& snapshot, const Pose& goal,
             const std::vector<BodyLook>& bodies, DrawList& list);

/// The tether to `goal`, and the contacts. Nothing in hand: empty.
HandPicture HandPictureOf(const ControllerSnapshot& snapshot, const Pose& goal);

/// From green, without force, by amber to red at `kTetherFullForce` and beyond.
Colour ForceColour(double force_N);
inline constexpr double kTetherFullForce = 10;  // N

}  // namespace tandem
