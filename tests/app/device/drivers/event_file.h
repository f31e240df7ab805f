#pragma once

#include <filesystem>
#include <initializer_list>

#include <fcntl.h>
#include <linux/input.h>
#include <sys/stat.h>
#include <unistd.h>

namespace tandem::testing {

/// A pipe with a name in place of an input device of Linux: what a test writes is what the kernel
/// would tell. To close it is to unplug the device.
class EventFile {
 public:
  explicit EventFile(const std::filesystem::path& path) : path_(path) {
    mkfifo(path.c_str(), 0600);
    Plug();
  }
  ~EventFile() { Unplug(); }
  EventFile(const EventFile&) = delete;
  EventFile& operator=(const EventFile&) = delete;

  void Plug() { file_ = open(path_.c_str(), O_RDWR | O_NONBLOCK | O_CLOEXEC); }
  void Unplug() {
    if (file_ >= 0) close(file_);
    file_ = -1;
  }
  void Send(int type, int code, int value) const {
    input_event event{};
    event.type = static_cast<unsigned short>(type);
    event.code = static_cast<unsigned short>(code);
    event.value = value;
    if (write(file_, &event, sizeof event) < 0) return;
  }
  void Press(std::initializer_list<int> keys, bool down = true) const {
    for (const int key : keys) Send(EV_KEY, key, down ? 1 : 0);
    Send(EV_SYN, SYN_REPORT, 0);
  }

 private:
  std::filesystem::path path_;
  int file_ = -1;
};

}  // namespace tandem::testing
