#include "collab/dds/cyclone/socket_drops.h"

#include <filesystem>
#include <fstream>
#include <set>
#include <sstream>
#include <string>
#include <vector>

namespace tandem {
namespace {

namespace fs = std::filesystem;

/// Returns the inodes of this process's sockets.
std::set<std::string> OwnSockets() {
  const std::string mark = "socket:[";
  std::set<std::string> inodes;
  std::error_code gone;  // files are opened and closed meanwhile
  for (const fs::directory_entry& file : fs::directory_iterator("/proc/self/fd", gone)) {
    const std::string target = fs::read_symlink(file.path(), gone).string();
    if (target.rfind(mark, 0) == 0) {
      inodes.insert(target.substr(mark.size(), target.size() - mark.size() - 1));
    }
  }
  return inodes;
}

}  // namespace

std::uint64_t PacketsDroppedAtSockets() {
  constexpr std::size_t kInode = 9;  // columns of the kernel's table
  constexpr std::size_t kDrops = 12;
  const std::set<std::string> own = OwnSockets();
  std::ifstream table("/proc/self/net/udp");
  std::uint64_t dropped = 0;
  std::string line;
  std::getline(table, line);  // the heading
  while (std::getline(table, line)) {
    std::istringstream words(line);
    std::vector<std::string> word;
    for (std::string one; words >> one;) word.push_back(one);
    if (word.size() > kDrops && own.contains(word[kInode])) dropped += std::stoull(word[kDrops]);
  }
  return dropped;
}

std::uint64_t LargestSocketBuffer() {
  std::uint64_t bytes = 0;
  std::ifstream("/proc/sys/net/core/rmem_max") >> bytes;
  return bytes;
}

}  // namespace tandem
