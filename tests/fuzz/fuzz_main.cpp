// fuzz_readers TARGET SECONDS [SEED] [CORPUS] feeds a reader with bad files made from good ones, in
// a process of its own, which is watched. A crash, a file that takes longer than a second, or more
// than 512 MB of memory end the run with exit code 1, and the file is kept. fuzz_readers FILE...
// feeds these files to the reader that the folder or the file's name says.

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <new>
#include <string>
#include <thread>
#include <vector>

#include <sys/mman.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include "engine/geometry/import/mesh_file.h"
#include "tests/fuzz/mutator.h"
#include "tests/fuzz/targets.h"

namespace tandem {
namespace {

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;

constexpr std::size_t kMostBytes = 1 << 17;
constexpr auto kLongest = std::chrono::seconds(1);
constexpr long kMostMemory = 512L << 10;  // KiB

/// State that the feeding process tells the watching one.
struct Shared {
  std::atomic<std::uint64_t> runs;
  std::atomic<std::int64_t> began_ns;  // the file under way
  std::atomic<std::size_t> size;
  std::atomic<std::int64_t> longest_ns;
  char bytes[kMostBytes];
};

std::int64_t NowNs() {
  return std::chrono::duration_cast<std::chrono::nanoseconds>(Clock::now().time_since_epoch())
      .count();
}

std::string BytesOf(const fs::path& file) {
  std::ifstream stream(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(stream), {}};
}

std::vector<std::string> SeedsIn(const fs::path& folder) {
  std::vector<fs::path> files;
  std::error_code none;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder, none)) {
    files.push_back(entry.path());
  }
  std::ranges::sort(files);
  std::vector<std::string> seeds;
  for (const fs::path& file : files) seeds.push_back(BytesOf(file));
  return seeds;
}

void Run(const FuzzTarget& target, const std::string& bytes, Shared& shared) {
  shared.size = std::min(bytes.size(), kMostBytes);
  std::memcpy(shared.bytes, bytes.data(), shared.size);
  const std::int64_t began_ns = NowNs();
  shared.began_ns = began_ns;
  target.run(bytes);
  shared.longest_ns = std::max<std::int64_t>(shared.longest_ns, NowNs() - began_ns);
  ++shared.runs;
}

[[noreturn]] void Feed(const FuzzTarget& target, double seconds, std::uint64_t seed,
                       const fs::path& corpus, Shared& shared) {
  const std::vector<std::string> seeds = SeedsIn(corpus);
  for (const std::string& bytes : seeds) Run(target, bytes, shared);
  Mutator mutator(seeds, seed);
  const auto end_ns = NowNs() + static_cast<std::int64_t>(1e9 * seconds);
  while (NowNs() < end_ns) Run(target, mutator.Next(), shared);
  std::exit(0);
}

int Keep(const FuzzTarget& target, const Shared& shared, const std::string& why) {
  const std::string file = std::string("fuzz-") + target.name + "-" + std::to_string(getpid());
  std::ofstream(file, std::ios::binary)
      .write(shared.bytes, static_cast<std::streamsize>(shared.size));
  std::fprintf(stderr, "%s: %s after %llu files; kept in %s\n", target.name, why.c_str(),
               static_cast<unsigned long long>(shared.runs), file.c_str());
  return 1;
}

int Watch(const FuzzTarget& target, pid_t child, const Shared& shared) {
  int status = 0;
  while (true) {
    const pid_t ended = waitpid(child, &status, WNOHANG);
    if (ended == child) break;
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
    const std::int64_t began_ns = shared.began_ns;
    if (began_ns == 0 || NowNs() - began_ns < std::chrono::nanoseconds(kLongest).count()) continue;
    // a machine that is busy with others is no hang of ours: ten seconds are
    if (NowNs() - began_ns < 10 * std::chrono::nanoseconds(kLongest).count()) continue;
    kill(child, SIGKILL);
    waitpid(child, &status, 0);
    return Keep(target, shared, "a file took longer than ten seconds");
  }
  rusage used{};
  getrusage(RUSAGE_CHILDREN, &used);
  if (!WIFEXITED(status) || WEXITSTATUS(status) != 0) {
    return Keep(target, shared,
                WIFSIGNALED(status) ? std::string("signal ") + strsignal(WTERMSIG(status))
                                    : "exit code " + std::to_string(WEXITSTATUS(status)));
  }
  std::printf("%s: %llu files, the longest %.1f ms, %ld MB\n", target.name,
              static_cast<unsigned long long>(shared.runs),
              1e-6 * static_cast<double>(shared.longest_ns), used.ru_maxrss >> 10);
  if (used.ru_maxrss > kMostMemory) return Keep(target, shared, "more than 512 MB");
  if (shared.longest_ns > std::chrono::nanoseconds(kLongest).count()) {
    std::printf("%s: longer than a second, by the wall's clock\n", target.name);
  }
  return 0;
}

int FeedFiles(int count, char** files) {
  for (int i = 0; i < count; ++i) {
    const fs::path file = files[i];
    const FuzzTarget* found = FuzzTargetNamed(file.parent_path().filename().string());
    for (const FuzzTarget& target : FuzzTargets()) {
      if (found != nullptr) break;
      const std::string begin = std::string("fuzz-") + target.name + "-";
      if (file.filename().string().starts_with(begin)) found = &target;
    }
    if (found == nullptr) continue;
    std::printf("%s: %s\n", found->name, file.c_str());
    found->run(BytesOf(file));
  }
  return 0;
}

}  // namespace
}  // namespace tandem

int main(int argc, char** argv) {
  using namespace tandem;
  RunImportHelperIfAsked(argc, argv);
  const FuzzTarget* target = argc > 1 ? FuzzTargetNamed(argv[1]) : nullptr;
  if (target == nullptr && argc > 1 && fs::exists(argv[1])) return FeedFiles(argc - 1, argv + 1);
  if (target == nullptr || argc < 3) {
    std::fprintf(stderr, "usage: fuzz_readers TARGET SECONDS [SEED] [CORPUS], TARGET one of");
    for (const FuzzTarget& one : FuzzTargets()) std::fprintf(stderr, " %s", one.name);
    std::fprintf(stderr, "\n");
    return 2;
  }
  const double seconds = std::atof(argv[2]);
  const std::uint64_t seed = argc > 3 ? std::strtoull(argv[3], nullptr, 10) : 1;
  const fs::path corpus = argc > 4 ? fs::path(argv[4]) : fs::path(TANDEM_CORPUS) / target->name;
  void* memory =
      mmap(nullptr, sizeof(Shared), PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
  if (memory == MAP_FAILED) return 1;
  auto* shared = new (memory) Shared();
  const pid_t child = fork();
  if (child == 0) Feed(*target, seconds, seed, corpus, *shared);
  return Watch(*target, child, *shared);
}
