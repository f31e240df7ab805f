#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <stop_token>
#include <string>

#include "app/program_folders.h"
#include "engine/base/result.h"
#include "engine/world/world_model.h"

namespace tandem {

/// The folder that the user's programs share: $TANDEM_CACHE, or `tandem` of $XDG_CACHE_HOME
/// (~/.cache). Null: there is none, or $TANDEM_CACHE is empty, which says that nothing is kept.
/// $TANDEM_CACHE_LIMIT says how many bytes it may have, such as 512M or 20G.
const VoxelCache* ProgramCache();

/// LoadWorld() with that folder. Says so on stderr where it takes longer than ten seconds.
Result<std::shared_ptr<const WorldModel>> LoadCached(const Scene& scene, LoadOptions options = {});

}  // namespace tandem
