#pragma once

#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "app/view/model/dead_reckoning.h"
#include "app/view/model/peer_palette.h"
#include "collab/viewer.h"

namespace tandem {

/// A body at some place. `X_W` is its displacement from where it stands at first (as in ViewBody).
struct BodyInstance {
  std::size_t body = 0;
  Pose X_W;
  Colour colour{};  // of ghosts: their peer's
  float opacity = 1;
};

/// A peer's name, to be written beside an instance.
struct InstanceLabel {
  std::string text;
  Colour colour{};
  std::size_t body = 0;
  Pose X_W;
  float opacity = 1;
};

/// What one picture shows.
struct DrawList {
  std::vector<BodyInstance> solids;  // one a body, by body
  std::vector<BodyInstance> ghosts;  // other peers' instances of the same bodies
  std::vector<InstanceLabel> labels;
  std::vector<Pose> told;         // of the solids, as received; not compared
  std::vector<std::size_t> held;  // bodies in the hand of somebody who is here; not compared
};
bool operator==(const BodyInstance& a, const BodyInstance& b);
bool operator==(const InstanceLabel& a, const InstanceLabel& b);
bool operator==(const DrawList& a, const DrawList& b);

/// What the composer must know of a body of the scene.
struct BodyLook {
  bool fixed = false;
  Colour colour{};
  std::optional<std::size_t> part_of = std::nullopt;  // the body that it is merged with
  Vec3 middle_W = Vec3::Zero();                       // where it stands at first
};

/// Decides what is drawn of a session: of each moving body the instance of the peer that answers
/// for it, solid; the other peers' instances as ghosts in the peers' colours. Where several here
/// claim a body, the claim counts that most others go by, then the greatest; where nobody does, the
/// solid one is that of the first peer (lowest id) that is here. Where a body has ghosts, the names
/// say which instance is solid and which are ghosts. A peer that left or fell silent fades; a body
/// that nobody moves any more stays where it was last seen, one that nobody ever sent where it
/// stands at first. A part goes where the body goes that it is merged with, in its own colour. What
/// a hand moves freely is drawn a little ahead (DeadReckoning); what is in contact, as it was told.
class PictureComposer {
 public:
  static constexpr double kFadeSeconds = 1.5;
  static constexpr float kGhostOpacity = 0.45F;

  /// `now_s`: any clock that runs on, in seconds.
  DrawList Compose(const ViewerPicture& picture, const std::vector<BodyLook>& bodies, double now_s,
                   PeerPalette& palette);

 private:
  struct Known {
    ViewedPeer::Presence presence = ViewedPeer::Presence::kHere;
    double since_s = 0;
  };
  /// Nothing is kept of peers that the picture does not have.
  void Forget(const ViewerPicture& picture);
  float Opacity(const ViewedPeer& peer, double now_s);  // 1 while here

  /// Where a peer's instance is drawn.
  Pose Shown(const ViewedPeer& peer, const ViewBody& body, const std::vector<BodyLook>& bodies,
             double now_s);

  std::map<PeerId, Known> known_;
  std::map<std::pair<PeerId, std::size_t>, DeadReckoning> ahead_;
};

/// "Anna" or, as long as its name is not known, "peer 1f03".
std::string DisplayName(const ViewedPeer& peer);
/// Whether something fixed keeps its instance of a body from another's.
bool IsTrapped(const ViewedPeer& peer);

}  // namespace tandem
