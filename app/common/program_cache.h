#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <stop_token>
#include <string>

#include "app/common/program_folders.h"
#include "engine/base/result.h"
#include "engine/world/world_model.h"

namespace tandem {

/// Returns the cache in the folder that the user's programs share: $TANDEM_CACHE, or `tandem` of
/// $XDG_CACHE_HOME (~/.cache). Null: there is no folder, or $TANDEM_CACHE is empty, which says that
/// nothing is kept. $TANDEM_CACHE_LIMIT is the most bytes that it may have, such as 512M or 20G.
const VoxelCache* ProgramCache();

/// Loads a world by LoadWorld() with that cache. Says so on stderr if it takes longer than ten
/// seconds.
Result<std::shared_ptr<const WorldModel>> LoadCached(const Scene& scene, LoadOptions options = {});
/// Does the same, and says the world's remarks on stderr.
Result<std::shared_ptr<const WorldModel>> LoadAndTell(const Scene& scene, LoadOptions options = {});

}  // namespace tandem
