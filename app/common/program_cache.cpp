#include "app/common/program_cache.h"

#include <chrono>
#include <condition_variable>
#include <cstdlib>
#include <mutex>
#include <stop_token>
#include <string>
#include <thread>
#include <utility>

#include "app/common/console.h"
#include "app/common/program_folders.h"

namespace tandem {

namespace {

std::uint64_t LimitOfCache() {
  if (const auto bytes = CacheLimit()) return *bytes;
  // this program does not set the environment
  const char* text = std::getenv("TANDEM_CACHE_LIMIT");  // NOLINT(concurrency-mt-unsafe)
  if (text == nullptr) return VoxelCache::kMostBytes;
  Say("TANDEM_CACHE_LIMIT: '" + std::string(text) +
      "' is not a size such as 512M or 20G; 10G is used");
  return VoxelCache::kMostBytes;
}

/// Says that loading takes long, while it does.
class LongLoad {
 public:
  explicit LongLoad(const std::string& scene)
      : telling_([scene](const std::stop_token& over) {
          std::mutex mutex;
          std::unique_lock lock(mutex);
          std::condition_variable_any waited;
          const auto never = [] {
            return false;
          };
          waited.wait_for(lock, over, kPatience, never);
          if (!over.stop_requested()) {
            Say("loading " + scene + ": a large scene takes minutes when it is first loaded");
          }
        }) {}

 private:
  static constexpr std::chrono::seconds kPatience{10};
  std::jthread telling_;
};

}  // namespace

const VoxelCache* ProgramCache() {
  static const VoxelCache cache(CacheFolder(), LimitOfCache());
  return cache.folder().empty() ? nullptr : &cache;
}

Result<std::shared_ptr<const WorldModel>> LoadCached(const Scene& scene, LoadOptions options) {
  const LongLoad notice(scene.name);
  options.cache = ProgramCache();
  return LoadWorld(scene, options);
}

Result<std::shared_ptr<const WorldModel>> LoadAndTell(const Scene& scene, LoadOptions options) {
  Result<std::shared_ptr<const WorldModel>> world = LoadCached(scene, std::move(options));
  if (!world) return world;
  for (const std::string& remark : (*world)->remarks) Say(remark);
  return world;
}

}  // namespace tandem
