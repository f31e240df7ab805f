#include "collab/transfer/scene_store.h"

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <system_error>
#include <utility>

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <sys/statvfs.h>
#include <unistd.h>

#include "collab/transfer/scene_files.h"
#include "engine/base/files/regular_file.h"
#include "engine/base/text/hex.h"

namespace tandem {

namespace {

namespace fs = std::filesystem;

constexpr const char* kUnfinished = "unfinished-";
constexpr const char* kPlain = "plain";
constexpr std::string_view kOfAuthority = "authority-";
constexpr std::size_t kMostScenes = 1000;  // scenes read from a folder
// age at which unfinished scenes are removed
constexpr std::chrono::hours kLeftFor{24 * 7};

std::string Reason(int fault) {
  return std::generic_category().message(fault);
}

bool IsHex(std::string_view text, std::size_t digits) {
  return text.size() == digits &&
         text.find_first_not_of("0123456789abcdef") == std::string_view::npos;
}
bool IsWholeName(const std::string& name) {
  return IsHex(name, 64);
}
/// Returns whether a folder of all scenes may hold this one of a scene: earlier versions put scenes
/// there, which no session uses any more.
bool IsEarlierName(const std::string& name) {
  return IsHex(name, 16);
}
bool IsUnfinishedName(const std::string& name) {
  return name.starts_with(kUnfinished) &&
         IsHex(std::string_view(name).substr(std::char_traits<char>::length(kUnfinished)), 64);
}

bool IsGroupName(const std::string& name) {
  return name == kPlain || (name.starts_with(kOfAuthority) &&
                            IsHex(std::string_view(name).substr(kOfAuthority.size()), 64));
}

/// Returns whether the file or folder is this user's, and only this user may write to it.
bool IsOwn(int descriptor, mode_t kind) {
  struct stat facts {};
  return fstat(descriptor, &facts) == 0 && (facts.st_mode & S_IFMT) == kind &&
         facts.st_uid == geteuid() && (facts.st_mode & 0022) == 0;
}

/// Opens a folder below an open one, and makes it if there is none. Negative: it belongs to another
/// user, or is a link.
int OpenFolder(int above, const char* name) {
  if (mkdirat(above, name, 0700) != 0 && errno != EEXIST) return -1;
  const int folder = openat(above, name, O_RDONLY | O_DIRECTORY | O_NOFOLLOW | O_CLOEXEC);
  if (folder < 0 || IsOwn(folder, S_IFDIR)) return folder;
  close(folder);
  errno = EACCES;
  return -1;
}

/// Opens the folder of a group in the folder of all scenes, and makes both if there are none.
int OpenGroup(const fs::path& folder, const std::string& group) {
  std::error_code failed;
  fs::create_directories(folder.parent_path(), failed);
  const int above = open(folder.parent_path().c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (above < 0) return -1;
  const int root = OpenFolder(above, folder.filename().c_str());
  int fault = errno;
  close(above);
  const int opened = root < 0 ? -1 : OpenFolder(root, group.c_str());
  if (root >= 0) {
    fault = errno;
    close(root);
  }
  errno = fault;
  return opened;
}

std::uint64_t SizeOf(const fs::path& folder) {
  std::uint64_t bytes = 0;
  std::error_code unknown;
  for (fs::directory_iterator entry(folder, unknown), end; !unknown && entry != end;
       entry.increment(unknown)) {
    struct stat facts {};
    if (lstat(entry->path().c_str(), &facts) == 0 && S_ISREG(facts.st_mode)) {
      bytes += static_cast<std::uint64_t>(facts.st_blocks) * 512;
    }
  }
  return bytes;
}

/// Removes a folder that holds only files, unless a program has its lock.
bool RemoveUnlessHeld(const fs::path& path) {
  const int folder = open(path.c_str(), O_RDONLY | O_DIRECTORY | O_NOFOLLOW | O_CLOEXEC);
  if (folder < 0) return false;
  const bool free = IsOwn(folder, S_IFDIR) && flock(folder, LOCK_EX | LOCK_NB) == 0;
  std::error_code failed;
  if (free) fs::remove_all(path, failed);
  close(folder);
  return free && !failed;
}

bool WriteAll(int descriptor, std::span<const char> bytes, std::uint64_t at) {
  std::size_t done = 0;
  while (done < bytes.size()) {
    const ssize_t size =
        pwrite(descriptor, bytes.data() + done, bytes.size() - done, static_cast<off_t>(at + done));
    if (size < 0 && errno == EINTR) continue;
    if (size <= 0) return false;
    done += static_cast<std::size_t>(size);
  }
  return true;
}

bool ReadAll(int descriptor, std::span<char> bytes, std::uint64_t at) {
  std::size_t done = 0;
  while (done < bytes.size()) {
    const ssize_t size =
        pread(descriptor, bytes.data() + done, bytes.size() - done, static_cast<off_t>(at + done));
    if (size < 0 && errno == EINTR) continue;
    if (size <= 0) return false;
    done += static_cast<std::size_t>(size);
  }
  return true;
}

/// Makes room for a scene: removes old unfinished scenes, then the least recently used scenes.
void MakeRoom(const SceneStore& store, std::uint64_t wanted, std::uint64_t most_bytes,
              const fs::path& but) {
  std::vector<FetchedScene> scenes = store.Scenes();
  std::uint64_t sum = wanted;
  for (const FetchedScene& scene : scenes) sum += scene.bytes;
  const auto now = fs::file_time_type::clock::now();
  for (auto scene = scenes.rbegin(); scene != scenes.rend(); ++scene) {
    if (scene->folder == but) continue;
    const bool left = !scene->whole && now - scene->used > kLeftFor;
    if (!left && sum <= most_bytes) continue;
    if (RemoveUnlessHeld(scene->folder)) sum -= std::min(sum, scene->bytes);
  }
}

}  // namespace

SceneStore::SceneStore(fs::path folder, const std::optional<Sha256>& authority)
    : folder_(std::move(folder)),
      group_(authority ? std::string(kOfAuthority) + HexOfBytes(*authority) : kPlain) {}

fs::path SceneStore::SceneFileOf(const Sha256& content) const {
  return group() / HexOfBytes(content) / kSceneFile;
}

std::vector<FetchedScene> SceneStore::Scenes() const {
  std::vector<FetchedScene> scenes;
  const auto visit = [](const fs::path& folder, const auto& see) {
    std::error_code unreadable;
    for (fs::directory_iterator entry(folder, unreadable), end; !unreadable && entry != end;
         entry.increment(unreadable)) {
      std::error_code unknown;
      const bool is_folder =
          fs::symlink_status(entry->path(), unknown).type() == fs::file_type::directory;
      if (is_folder) see(entry->path());
    }
  };
  const auto add = [&scenes](const fs::path& folder, bool whole) {
    std::error_code unknown;
    const auto used = fs::last_write_time(folder, unknown);
    if (unknown || scenes.size() == kMostScenes) return;
    scenes.push_back({folder, SizeOf(folder), used, whole});
  };
  visit(folder_, [&](const fs::path& group) {
    const std::string name = group.filename().string();
    if (IsEarlierName(name) || IsUnfinishedName(name)) add(group, IsEarlierName(name));
    if (!IsGroupName(name)) return;
    visit(group, [&](const fs::path& scene) {
      const bool whole = IsWholeName(scene.filename().string());
      if (whole || IsUnfinishedName(scene.filename().string())) add(scene, whole);
    });
  });
  std::ranges::sort(scenes, std::greater(), &FetchedScene::used);
  return scenes;
}

std::size_t SceneStore::Clear() const {
  std::size_t removed = 0;
  for (const FetchedScene& scene : Scenes()) {
    if (RemoveUnlessHeld(scene.folder)) ++removed;
  }
  // folders of senders without scenes; one that has a scene stays
  std::error_code unreadable;
  for (fs::directory_iterator entry(folder_, unreadable), end; !unreadable && entry != end;
       entry.increment(unreadable)) {
    if (IsGroupName(entry->path().filename().string())) rmdir(entry->path().c_str());
  }
  return removed;
}

void SceneStore::Touch(const Sha256& content) const {
  std::error_code ignored;
  fs::last_write_time(group() / HexOfBytes(content), fs::file_time_type::clock::now(), ignored);
}

Result<UnfinishedScene> UnfinishedScene::Open(const SceneStore& store, const SceneList& list,
                                              const Sha256& digest, const Limits& limits,
                                              bool& busy) {
  busy = false;
  const fs::path root = store.group();
  const std::string shown = PlainLine(store.folder().string());
  const int root_folder = OpenGroup(store.folder(), store.group_name());
  if (root_folder < 0) {
    return Error{shown + ": cannot be used for scenes from sessions: " + Reason(errno) +
                 "; it must be a folder of yours that others cannot write to"};
  }
  const std::string name = kUnfinished + HexOfBytes(digest);
  int folder = -1;
  // a program that removes leftovers has the lock for a moment, and then the folder is gone
  for (int tries = 0; tries < 3 && folder < 0; ++tries) {
    folder = OpenFolder(root_folder, name.c_str());
    if (folder < 0) break;
    if (flock(folder, LOCK_EX | LOCK_NB) != 0) {
      busy = errno == EWOULDBLOCK;
      close(folder);
      close(root_folder);
      return Error{busy ? "another program on this machine fetches this scene now"
                        : shown + ": its disk knows no locks: set TANDEM_CACHE to another folder"};
    }
    struct stat facts {};
    if (fstat(folder, &facts) != 0 || facts.st_nlink == 0) {
      close(folder);
      folder = -1;
    }
  }
  if (folder < 0) {
    const std::string why = Reason(errno);
    close(root_folder);
    return Error{shown + ": a folder in it cannot be made or used: " + why};
  }
  UnfinishedScene scene(root, list, name, root_folder, folder);
  const std::uint64_t total = list.total_bytes();
  MakeRoom(store, total, limits.most_bytes, root / name);
  if (total > limits.most_bytes) {
    scene.Remove();
    return Error{"the scene is larger than the " + std::to_string(limits.most_bytes / 1'000'000) +
                 " MB of the cache: TANDEM_CACHE_LIMIT allows more"};
  }
  struct statvfs disk {};
  const std::uint64_t held = SizeOf(root / name);
  if (fstatvfs(folder, &disk) == 0 &&
      std::uint64_t{disk.f_bavail} * disk.f_frsize + held < total + limits.spare_bytes) {
    if (held == 0) scene.Remove();
    return Error{shown + ": its disk has no room for " + std::to_string(total / 1'000'000 + 1) +
                 " MB: free some, or set TANDEM_CACHE to a folder of another disk"};
  }
  if (const auto failed = scene.OpenFiles()) {
    scene.Remove();
    return *failed;
  }
  return scene;
}

std::optional<Error> UnfinishedScene::OpenFiles() {
  for (std::size_t f = 0; f < list_.files.size(); ++f) {
    const ListedFile& file = list_.files[f];
    // the scene file as sent does not fit this machine
    names_.push_back(f == 0 ? "sent" : HexOfBytes(file.digest) + file.kind);
    const int opened = openat(folder_, names_.back().c_str(),
                              O_RDWR | O_CREAT | O_NOFOLLOW | O_NONBLOCK | O_CLOEXEC, 0600);
    struct stat facts {};
    const bool own = opened >= 0 && IsOwn(opened, S_IFREG) && fstat(opened, &facts) == 0 &&
                     facts.st_nlink == 1 && static_cast<std::uint64_t>(facts.st_size) <= file.bytes;
    if (opened >= 0) files_.push_back(opened);
    if (!own) {
      return Error{PlainLine((root_ / name_).string()) +
                   ": what is left there of an earlier run is damaged: join again"};
    }
  }
  return std::nullopt;
}

UnfinishedScene::UnfinishedScene(UnfinishedScene&& other) noexcept
    : root_(std::move(other.root_)),
      list_(std::move(other.list_)),
      name_(std::move(other.name_)),
      root_folder_(std::exchange(other.root_folder_, -1)),
      folder_(std::exchange(other.folder_, -1)),
      files_(std::exchange(other.files_, {})),
      names_(std::move(other.names_)) {}

UnfinishedScene::~UnfinishedScene() {
  for (const int file : files_) close(file);
  if (folder_ >= 0) close(folder_);
  if (root_folder_ >= 0) close(root_folder_);
}

bool UnfinishedScene::Read(const PiecePlace& place, std::span<char> piece) {
  return ReadAll(files_[place.file], piece, place.at);
}

bool UnfinishedScene::Write(const PiecePlace& place, std::span<const char> piece) {
  return WriteAll(files_[place.file], piece, place.at);
}

Result<fs::path> UnfinishedScene::WriteScene() {
  std::string sent;
  std::vector<char> block(1U << 20U);
  for (std::size_t f = 0; f < list_.files.size(); ++f) {
    const ListedFile& file = list_.files[f];
    RunningSha256 digest;
    for (std::uint64_t at = 0; at < file.bytes; at += block.size()) {
      const auto bytes =
          static_cast<std::size_t>(std::min<std::uint64_t>(block.size(), file.bytes - at));
      const std::span<char> part(block.data(), bytes);
      if (!ReadAll(files_[f], part, at)) return Error{"a file of the scene cannot be read back"};
      digest.Add(part);
      if (f == 0) sent.append(part.data(), part.size());
    }
    if (digest.Value() != file.digest) {
      return Error{"a file of the scene is not the one that was listed"};
    }
  }
  const Result<std::string> scene = ArrivedScene(sent, names_);
  if (!scene) return scene.error();
  unlinkat(folder_, SceneStore::kSceneFile, 0);
  const int file = openat(folder_, SceneStore::kSceneFile,
                          O_WRONLY | O_CREAT | O_EXCL | O_NOFOLLOW | O_CLOEXEC, 0600);
  const bool written = file >= 0 && WriteAll(file, *scene, 0) && fsync(file) == 0;
  if (file >= 0) close(file);
  if (!written) return Error{"the scene file cannot be written: " + Reason(errno)};
  return root_ / name_ / SceneStore::kSceneFile;
}

Result<fs::path> UnfinishedScene::Commit(const Sha256& content) {
  const std::string whole = HexOfBytes(content);
  int fault = 0;
  for (const int file : files_) {
    if (fault == 0 && fsync(file) != 0 && errno != EINVAL) fault = errno;
  }
  unlinkat(folder_, names_.front().c_str(), 0);
  if (fault == 0 && fsync(folder_) != 0 && errno != EINVAL) fault = errno;
  if (fault == 0 && renameat(root_folder_, name_.c_str(), root_folder_, whole.c_str()) != 0) {
    fault = errno;
  }
  if (fault == ENOTEMPTY || fault == EEXIST) {
    // the old folder was not the scene, or came meanwhile: no program has its lock
    RemoveUnlessHeld(root_ / whole);
    fault = renameat(root_folder_, name_.c_str(), root_folder_, whole.c_str()) == 0 ? 0 : errno;
  }
  if (fault != 0) {
    Remove();
    return Error{PlainLine(root_.string()) + ": the scene cannot be put there: " + Reason(fault)};
  }
  fsync(root_folder_);
  // a scene in its place is locked by no program
  close(std::exchange(folder_, -1));
  return root_ / whole / SceneStore::kSceneFile;
}

void UnfinishedScene::Remove() {
  // only names made here: nothing else is in the folder
  for (const std::string& name : names_) unlinkat(folder_, name.c_str(), 0);
  unlinkat(folder_, SceneStore::kSceneFile, 0);
  if (unlinkat(root_folder_, name_.c_str(), AT_REMOVEDIR) != 0 && errno == ENOTEMPTY) {
    std::error_code ignored;
    fs::remove_all(root_ / name_, ignored);
  }
}

}  // namespace tandem
