#include "app/cli/program_cache.h"

#include <charconv>
#include <chrono>
#include <condition_variable>
#include <cstdlib>
#include <mutex>
#include <stop_token>
#include <string>
#include <thread>

#include "app/cli/talk.h"
#include "app/program_folders.h"

namespace tandem {

namespace {

namespace fs = std::filesystem;

// Nothing of ours sets the environment.
std::optional<std::string> Variable(const char* name) {
  const char* value = std::getenv(name);  // NOLINT(concurrency-mt-unsafe)
  return value != nullptr ? std::optional<std::string>(value) : std::nullopt;
}

/// Empty: nothing is kept.
fs::path CacheFolder() {
  const auto named = Variable("TANDEM_CACHE");
  return named ? fs::path(*named) : PersonsFolder("XDG_CACHE_HOME", ".cache");
}

std::uint64_t CacheLimit() {
  const auto text = Variable("TANDEM_CACHE_LIMIT");
  if (!text) return VoxelCache::kMostBytes;
  if (const auto bytes = BytesOf(*text)) return *bytes;
  Say("TANDEM_CACHE_LIMIT: '" + *text + "' is no number of bytes such as 512M or 20G; 10G counts");
  return VoxelCache::kMostBytes;
}

/// Says what takes so long, while it does.
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
  static const VoxelCache cache(CacheFolder(), CacheLimit());
  return cache.folder().empty() ? nullptr : &cache;
}

Result<std::shared_ptr<const WorldModel>> LoadCached(const Scene& scene, LoadOptions options) {
  const LongLoad told(scene.name);
  options.cache = ProgramCache();
  return LoadWorld(scene, options);
}

std::optional<std::uint64_t> BytesOf(const std::string& text) {
  std::uint64_t number = 0;
  const char* end = text.data() + text.size();
  const auto [rest, fault] = std::from_chars(text.data(), end, number);
  if (fault != std::errc()) return std::nullopt;
  const std::string unit(rest, end);
  const int shift = unit.empty() ? 0 : unit == "K" ? 10 : unit == "M" ? 20 : unit == "G" ? 30 : -1;
  if (shift < 0 || number > std::uint64_t{1} << (63 - shift)) return std::nullopt;
  return number << shift;
}

}  // namespace tandem
