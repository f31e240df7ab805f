#pragma once

#include <set>
#include <string>
#include <vector>

#include "collab/messages.h"
#include "engine/world/force_parameters.h"
#include "engine/world/scene_hash.h"

namespace tandem {

/// Whether two mean the same scene, and by what parameters they simulate it (paper §6.1). Content
/// must be equal. Who joins adopts the session's force parameters, or insists on its own: then it
/// and the others push unequally, and shared bodies are not held together.
/// docs/decisions/0022-agreement.md

/// Why a scene is too large for a session, in a line; empty: it is not. One peer may come to answer
/// for all that moves, and says of at most kMaxClaims bodies that it does.
std::string BeyondLimits(const Scene& scene);

/// What a peer that loads this scene offers to the session.
SceneManifest ManifestOf(const Scene& scene, const SceneHash& hash, PeerId by);

/// Which of two manifests the session goes by: that of the higher revision, then of the lower peer.
bool Precedes(const SceneManifest& a, const SceneManifest& b);

ForceParameters ParametersOf(const SceneManifest& manifest);

/// In what a scene's content differs from the session's, in one line that names the body and the
/// file; empty: in nothing.
std::string ContentDifference(const Scene& scene, const SceneHash& hash,
                              const SceneManifest& session);

/// Who pushes harder and by how much, where `who` goes by `theirs` and we by `ours`. `mass` (kg):
/// of the heaviest moving body.
std::string PushWarning(const ForceParameters& ours, const ForceParameters& theirs, double mass,
                        const std::string& who);

/// Whether one may go by the session's voxels unasked: within a factor of four of one's own, so that
/// nobody can make others load until their memory is full.
bool MayBeAdopted(const ForceParameters& session, const ForceParameters& ours);

/// The manifests on offer, by who offers them, and which of them is the session's. An offer counts
/// while its author offers it and is not gone; as under way only if the author takes part. Of those
/// under way the one that most of those here go by counts, then that of the lowest id; of the others
/// that of the highest revision, then of the lowest id. Keeps at most kMost, so that forged ones
/// cost nothing.
class SceneOffers {
 public:
  static constexpr std::size_t kMost = 4 * kMaxPeers;

  /// `remembers`: what those who have gone offered counts when nobody here offers anything.
  explicit SceneOffers(bool remembers = false) : remembers_(remembers) {}

  void OnScene(const SceneManifest& manifest);
  void OnWithdrawn(PeerId peer);
  void OnPresence(PeerId peer, bool here);

  /// Null: nothing is on offer.
  const SceneManifest* session() const;
  const SceneManifest* From(PeerId peer) const;
  std::vector<SceneManifest> All() const;
  std::size_t size() const noexcept { return offers_.size(); }

 private:
  struct Offer {
    SceneManifest manifest;
    bool here = true;  // offered, by somebody who is not gone
  };
  struct Rank {
    bool here = false;
    std::uint32_t revision = 0;
    std::size_t followers = 0;  // of what is under way
    PeerId by = 0;

    bool operator<(const Rank& other) const;  // counts before it
  };
  Rank RankOf(const Offer& offer) const;
  std::vector<Offer>::const_iterator First() const;

  bool remembers_;
  std::vector<Offer> offers_;
  std::set<PeerId> present_;  // those who take part
};

}  // namespace tandem
