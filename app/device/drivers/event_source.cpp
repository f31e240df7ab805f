#include "app/device/drivers/event_source.h"

#include <array>
#include <cerrno>
#include <chrono>
#include <climits>
#include <cstring>
#include <filesystem>
#include <set>

#include <fcntl.h>
#include <poll.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include "app/device/drivers/driver_support.h"

namespace tandem::driver {
namespace {

namespace fs = std::filesystem;

constexpr const char* kMendRights = "sudo usermod -aG input $USER, then log out and in again";

template <std::size_t kBits>
using Bits = std::array<unsigned long, kBits / (CHAR_BIT * sizeof(unsigned long)) + 1>;

template <typename Set>
bool Has(const Set& bits, unsigned bit) {
  constexpr unsigned kWord = CHAR_BIT * sizeof(unsigned long);
  return (bits[bit / kWord] >> (bit % kWord) & 1UL) != 0;
}

bool HasKey(int file, unsigned key) {
  Bits<KEY_MAX> keys{};
  return ioctl(file, EVIOCGBIT(EV_KEY, sizeof keys), keys.data()) >= 0 && Has(keys, key);
}

/// Opens a file for reading without waiting, if its writer is there; below 0: it cannot.
int OpenFile(const std::string& path) {
  const int file = open(path.c_str(), O_RDONLY | O_NONBLOCK | O_CLOEXEC);
  if (file < 0) return -1;
  pollfd wait{file, POLLIN, 0};
  poll(&wait, 1, 0);
  if ((wait.revents & (POLLHUP | POLLERR)) == 0) return file;
  close(file);
  errno = ENODEV;
  return -1;
}

/// Returns the event files of a folder by name, so that the first stays the first.
std::set<fs::path> EventFiles(const std::string& folder) {
  std::set<fs::path> files;
  std::error_code unreadable;
  for (const auto& entry : fs::directory_iterator(folder, unreadable)) {
    if (entry.path().filename().string().rfind("event", 0) == 0) files.insert(entry.path());
  }
  return files;
}

/// Opens a file if it is a device of the kind; below 0: it is not, or could not be opened. `denied`
/// is set where this user lacks the right.
int OpenIfOfKind(const fs::path& path, EventSource::IsKind is_kind, bool& denied) {
  const int file = OpenFile(path.string());
  denied = denied || (file < 0 && errno == EACCES);
  if (file < 0 || is_kind(file)) return file;
  close(file);
  return -1;
}

/// Opens the first device of the kind; below 0: none. `denied`: the right to open one was missing.
int OpenFirst(EventSource::IsKind is_kind, bool& denied) {
  denied = false;
  for (const fs::path& path : EventFiles(EventSource::kEventFolder)) {
    const int file = OpenIfOfKind(path, is_kind, denied);
    if (file >= 0) return file;
  }
  return -1;
}

}  // namespace

bool IsMouse(int file) {
  Bits<REL_MAX> axes{};
  return ioctl(file, EVIOCGBIT(EV_REL, sizeof axes), axes.data()) >= 0 && Has(axes, REL_X) &&
         Has(axes, REL_Y) && HasKey(file, BTN_LEFT);
}

bool IsKeyboard(int file) {
  return HasKey(file, KEY_LEFT) && HasKey(file, KEY_RIGHTCTRL) && HasKey(file, KEY_A);
}

std::int32_t EventSource::List(TandemDeviceFound* found, std::int32_t room, IsKind is_kind,
                               const char* kind, const std::string& folder) {
  if (room < 1) return 0;
  bool denied = false;
  std::int32_t count = 0;
  for (const fs::path& path : EventFiles(folder)) {
    if (count == room) return count;
    const int file = OpenIfOfKind(path, is_kind, denied);
    if (file < 0) continue;
    std::array<char, 64> name{};
    ioctl(file, EVIOCGNAME(name.size() - 1), name.data());
    close(file);
    TandemDeviceFound& one = found[count++];
    one.present = 1;
    Put(one.name, name.data());
    Put(one.options, "path=" + path.string());
  }
  if (count == 1) Put(found[0].options, "");  // the driver takes the only one without an option
  if (count > 0) return count;
  if (denied) {
    Put(found->missing, "the right to read " + folder);
    Put(found->mend, kMendRights);
  } else {
    Put(found->missing, std::string("there is no ") + kind + " at " + folder);
    Put(found->mend, "plug it in, or give path=FILE");
  }
  return 1;
}

std::string EventSource::Open(const std::string& path, IsKind is_kind, const char* kind) {
  path_ = path;
  is_kind_ = is_kind;
  bool denied = false;
  const int file = path.empty() ? OpenFirst(is_kind, denied) : OpenFile(path);
  denied = denied || (file < 0 && errno == EACCES);
  if (file < 0) {
    const std::string what = path.empty() ? std::string("no ") + kind + " at /dev/input" : path;
    if (denied) return what + ": no right to read it: " + kMendRights;
    if (path.empty()) return what + ": plug it in, or give path=FILE";
    return what + ": " + std::strerror(errno);  // NOLINT(concurrency-mt-unsafe)
  }
  file_.store(file);
  return {};
}

void EventSource::Start() {
  keeper_ = std::thread([this] {
    Keep();
  });
}

EventSource::~EventSource() {
  over_.store(true);
  if (keeper_.joinable()) keeper_.join();
  for (const int file : {file_.load(), gone_.load()}) {
    if (file >= 0) close(file);
  }
}

EventSource::ReadResult EventSource::Next(int file, input_event& event) noexcept {
  const ssize_t size = read(file, &event, sizeof event);
  if (size == static_cast<ssize_t>(sizeof event)) return ReadResult::kEvent;
  if (size < 0 && (errno == EAGAIN || errno == EINTR)) return ReadResult::kNothing;
  // unplugged, or an incomplete event
  gone_.store(file, std::memory_order_release);
  file_.store(-1, std::memory_order_release);
  return ReadResult::kGone;
}

void EventSource::Keep() {
  int waited_ms = 0;
  while (!over_.load()) {
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
    if (file_.load() >= 0) continue;
    const int gone = gone_.exchange(-1);
    if (gone >= 0) close(gone);
    waited_ms += 20;
    if (waited_ms < kReopenMs) continue;
    waited_ms = 0;
    bool denied = false;
    const int file = path_.empty() ? OpenFirst(is_kind_, denied) : OpenFile(path_);
    if (file >= 0) file_.store(file, std::memory_order_release);
  }
}

bool EventSource::IsDown(int key) const noexcept {
  Bits<KEY_MAX> keys{};
  const int file = file_.load();
  return file >= 0 && ioctl(file, EVIOCGKEY(sizeof keys), keys.data()) >= 0 &&
         Has(keys, static_cast<unsigned>(key));
}

}  // namespace tandem::driver
