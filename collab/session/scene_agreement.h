#pragma once

#include <set>
#include <string>
#include <vector>

#include "collab/session/messages.h"
#include "engine/scene/force_parameters.h"
#include "engine/scene/scene_hash.h"

namespace tandem {

/// Decides whether two peers mean the same scene, and by what parameters they simulate it (paper
/// §6.1). Content must be equal by its digest. A joining peer adopts the session's force
/// parameters, or keeps its own. With its own parameters it and the others push unequally, and
/// shared bodies are not held together. docs/decisions/0022-agreement.md

/// Returns in a line why a scene is too large for a session; empty if it is not. One peer may come
/// to answer for all moving bodies, and can claim at most kMaxClaims.
std::string BeyondLimits(const Scene& scene);

/// Returns the manifest that a peer with this scene offers to the session.
SceneManifest ManifestOf(const Scene& scene, const SceneHash& hash, PeerId by);

/// Returns whether the session goes by `a` rather than `b`: higher revision, then lower peer id.
bool Precedes(const SceneManifest& a, const SceneManifest& b);

ForceParameters ParametersOf(const SceneManifest& manifest);

/// Returns the difference of a scene's content from the session's, in one line that names the body
/// and the file; empty if there is none.
std::string ContentDifference(const Scene& scene, const SceneHash& hash,
                              const SceneManifest& session);

/// Says which peer pushes harder and by how much, if `who` has the parameters `theirs` and we
/// `ours`. `mass`: the heaviest moving body, kg.
std::string PushWarning(const ForceParameters& ours, const ForceParameters& theirs, double mass,
                        const std::string& who);

/// Returns whether this peer may adopt the session's voxel size unasked: within a factor of four of
/// its own, so that no peer can make others fill their memory.
bool MayBeAdopted(const ForceParameters& session, const ForceParameters& ours);

/// Keeps the manifests on offer, by author, and finds the session's. An offer counts while its
/// author offers it and is here; as under way only if the author takes part. Among offers under way
/// the one with the most followers here counts, then that of the lowest id. Among the others the
/// highest revision counts, then the lowest id. Keeps at most kMost, so that forged offers cost
/// nothing.
class SceneOffers {
 public:
  static constexpr std::size_t kMost = 4 * kMaxPeers;

  /// `remembers`: offers of peers that have gone count when no peer here offers anything.
  explicit SceneOffers(bool remembers = false) : remembers_(remembers) {}

  void OnScene(const SceneManifest& manifest);
  void OnWithdrawn(PeerId peer);
  void OnPresence(PeerId peer, bool here);

  /// The session's manifest; null: nothing is on offer.
  const SceneManifest* session() const;
  const SceneManifest* From(PeerId peer) const;
  std::vector<SceneManifest> All() const;
  std::size_t size() const noexcept { return offers_.size(); }

 private:
  struct Offer {
    SceneManifest manifest;
    bool here = true;  // offered by a peer that is not gone
  };
  struct Rank {
    bool here = false;
    std::uint32_t revision = 0;
    std::size_t followers = 0;  // offers under way with the same scene and parameters
    PeerId by = 0;

    bool operator<(const Rank& other) const;  // ranks before the other
  };
  Rank RankOf(const Offer& offer) const;
  std::vector<Offer>::const_iterator First() const;

  bool remembers_;
  std::vector<Offer> offers_;
  std::set<PeerId> present_;  // peers that take part
};

}  // namespace tandem
