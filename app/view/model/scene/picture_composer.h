#pragma once

#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "app/view/model/scene/dead_reckoning.h"
#include "app/view/model/scene/peer_palette.h"
#include "collab/session/viewer.h"

namespace tandem {

/// An instance of a body. `X_W` is its displacement from the body's first place (as in ViewBody).
struct BodyInstance {
  std::size_t body = 0;
  Pose X_W;
  Colour colour{};  // peer's colour for a ghost
  float opacity = 1;
};

/// A peer's name beside an instance.
struct InstanceLabel {
  std::string text;
  Colour colour{};
  std::size_t body = 0;
  Pose X_W;
  float opacity = 1;
};

/// The content of a picture.
struct DrawList {
  std::vector<BodyInstance> solids;  // one for each body, by body
  std::vector<BodyInstance> ghosts;  // other peers' instances of the same bodies
  std::vector<InstanceLabel> labels;
  std::vector<Pose> reported;     // poses of the solids as received; not compared
  std::vector<std::size_t> held;  // bodies in the hands of peers that are here; not compared
};
bool operator==(const BodyInstance& a, const BodyInstance& b);
bool operator==(const InstanceLabel& a, const InstanceLabel& b);
bool operator==(const DrawList& a, const DrawList& b);

/// The facts about a scene's body that the composer needs.
struct BodyLook {
  bool fixed = false;
  Colour colour{};
  std::optional<std::size_t> part_of = std::nullopt;  // body that it is merged with
  Vec3 middle_W = Vec3::Zero();                       // middle in the first place
};

/// Decides how a session is drawn. Each moving body is solid where its owner has it, and the other
/// peers' instances are ghosts in their users' colours (PeerInfo::colour).
///
/// If several peers here claim a body, the claim that most others name counts, then the greatest
/// claim. If none does, the first peer here that has the body (lowest id) is taken as the owner.
/// Where a body has ghosts, the names say which instance is solid.
///
/// A peer that left or fell silent fades. A body that no peer moves stays where it was last seen,
/// and a body that no peer sent stays in its first place. A part moves with the body that it is
/// merged with, in its own colour. A body that a hand moves freely is drawn a little ahead
/// (DeadReckoning), a body in contact as it was received.
class PictureComposer {
 public:
  static constexpr double kFadeSeconds = 1.5;
  static constexpr float kGhostOpacity = 0.45F;

  /// Makes the content of a picture. `now_s`: any steady clock, in seconds.
  DrawList Compose(const ViewerPicture& picture, const std::vector<BodyLook>& bodies, double now_s);

 private:
  struct Known {
    ViewedPeer::Presence presence = ViewedPeer::Presence::kHere;
    double since_s = 0;
  };
  /// Forgets peers that the picture does not have.
  void Forget(const ViewerPicture& picture);
  float Opacity(const ViewedPeer& peer, double now_s);  // 1 while here

  /// Returns the pose at which a peer's instance is drawn.
  Pose Shown(const ViewedPeer& peer, const ViewBody& body, const std::vector<BodyLook>& bodies,
             double now_s);

  std::map<PeerId, Known> known_;
  std::map<std::pair<PeerId, std::size_t>, DeadReckoning> ahead_;
};

/// Returns a peer's name, or "peer 1f03" while it is unknown.
std::string DisplayName(const ViewedPeer& peer);
/// Returns whether a fixed body keeps the peer's instance of a body from another instance.
bool IsTrapped(const ViewedPeer& peer);

}  // namespace tandem
