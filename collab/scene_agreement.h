#pragma once

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

/// The manifests on offer, by who offers them, and which of them is the session's: of those whose
/// offerers are here, the one of the highest revision, then that of the lowest id. Keeps at most
/// kMost, so that forged ones cost nothing.
class SceneOffers {
 public:
  static constexpr std::size_t kMost = 4 * kMaxPeers;

  void OnScene(const SceneManifest& manifest);
  /// What one who has gone offered counts when nobody here offers anything.
  void OnPresence(PeerId peer, bool here);

  /// Null: nothing has been offered.
  const SceneManifest* session() const;
  const SceneManifest* From(PeerId peer) const;
  std::vector<SceneManifest> All() const;
  std::size_t size() const noexcept { return offers_.size(); }

 private:
  struct Offer {
    SceneManifest manifest;
    bool here = true;
  };
  static bool Precedes(const Offer& a, const Offer& b);

  std::vector<Offer> offers_;
};

}  // namespace tandem
