#include "collab/recording/recorder.h"

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <cstring>
#include <system_error>
#include <utility>

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

namespace tandem {
namespace {

constexpr std::chrono::milliseconds kWritePeriod{50};

// Puts numbers into the ring.
class Encoder {
 public:
  explicit Encoder(ByteRing& ring) : ring_(&ring) {}
  template <typename T>
  void operator()(const T& value) noexcept {
    ring_->Put(&value, sizeof value);
  }

 private:
  ByteRing* ring_;
};

template <typename T>
void Append(std::vector<std::byte>& out, const T& value) {
  const auto* bytes = reinterpret_cast<const std::byte*>(&value);
  out.insert(out.end(), bytes, bytes + sizeof value);
}

/// Returns how many of the bytes the disk took; if not all, `fault` says why.
std::size_t WriteAll(int descriptor, const std::byte* data, std::size_t size, int& fault) {
  std::size_t done = 0;
  while (done < size) {
    const ssize_t written = write(descriptor, data + done, size - done);
    if (written < 0 && errno == EINTR) continue;
    if (written <= 0) {
      fault = written < 0 ? errno : ENOSPC;
      break;
    }
    done += static_cast<std::size_t>(written);
  }
  return done;
}

std::string Reason(int fault) {
  return std::generic_category().message(fault);
}

/// Opens a file that no other program writes; the error says why it cannot.
Result<int> OpenNew(const std::filesystem::path& file) {
  const Error exists{file.string() + " exists already: recordings are never overwritten"};
  int descriptor = open(file.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0600);
  if (descriptor < 0 && errno == EEXIST) {
    // an empty file, a pipe or a device may be meant for us
    descriptor = open(file.c_str(), O_WRONLY | O_NONBLOCK | O_CLOEXEC | O_NOCTTY);
  }
  if (descriptor < 0) return Error{file.string() + ": " + Reason(errno)};
  struct stat status {};
  const bool known = fstat(descriptor, &status) == 0;
  const bool regular = known && S_ISREG(status.st_mode);
  // one of two recorders that begin together gets the lock, and keeps it to its end
  if (regular && (flock(descriptor, LOCK_EX | LOCK_NB) != 0 || fstat(descriptor, &status) != 0 ||
                  status.st_size > 0)) {
    close(descriptor);
    return exists;
  }
  fcntl(descriptor, F_SETFL, 0);
  return descriptor;
}

}  // namespace

Result<std::unique_ptr<Recorder>> Recorder::Create(const std::filesystem::path& file,
                                                   const RecordingHeader& header) {
  const Result<int> descriptor = OpenNew(file);
  if (!descriptor) return descriptor.error();
  const std::string text = AsText(header);
  std::vector<std::byte> head;
  for (const char c : kRecordingMagic) head.push_back(static_cast<std::byte>(c));
  Append(head, static_cast<std::uint32_t>(text.size()));
  for (const char c : text) head.push_back(static_cast<std::byte>(c));
  int fault = 0;
  if (WriteAll(*descriptor, head.data(), head.size(), fault) < head.size()) {
    close(*descriptor);
    std::error_code none;
    if (std::filesystem::is_regular_file(file, none)) unlink(file.c_str());
    return Error{file.string() + ": cannot be written: " + Reason(fault)};
  }
  std::unique_ptr<Recorder> recorder(new Recorder(file, *descriptor, head.size()));
  return recorder;
}

Recorder::Recorder(std::filesystem::path file, int descriptor, std::uint64_t bytes)
    : file_(std::move(file)), descriptor_(descriptor), bytes_(bytes), thread_([this] {
        Run();
      }) {}

Recorder::~Recorder() {
  if (descriptor_ >= 0) static_cast<void>(Close());
}

Result<std::uint64_t> Recorder::Close() {
  {
    const std::scoped_lock lock(mutex_);
    stop_ = true;
  }
  stopping_.notify_one();
  if (thread_.joinable()) thread_.join();
  // a full disk may report it only here
  const bool synced = fsync(descriptor_) == 0 || errno == EINVAL || errno == EROFS;
  int fault = synced ? 0 : errno;
  if (close(std::exchange(descriptor_, -1)) != 0 && fault == 0) fault = errno;
  if (fault != 0 && fault_.load() == 0) fault_.store(fault);
  if (const std::string ended = WhyEnded(); !ended.empty()) return Error{ended};
  return frames_.load();
}

void Recorder::Discard() {
  if (descriptor_ >= 0) static_cast<void>(Close());
  std::error_code none;
  if (std::filesystem::is_regular_file(file_, none)) unlink(file_.c_str());
}

std::string Recorder::WhyEnded() const {
  const std::uint64_t count = frames_.load();
  const std::string frames = std::to_string(count) + (count == 1 ? " frame" : " frames");
  if (const int fault = fault_.load(); fault != 0) {
    return file_.string() + ": cannot be written: " + Reason(fault) + "; it ends after " + frames;
  }
  if (ended_.load()) return file_.string() + ": the disk is too slow; it ends after " + frames;
  return {};
}

std::string Recorder::News() {
  if (reported_) return {};
  // a ring that ran over still holds frames: their number is known when the disk has them
  if (fault_.load() == 0 && !(ended_.load() && drained_.load())) return {};
  reported_ = true;
  return WhyEnded();
}

void Recorder::Named(PeerId peer, const std::string& name) {
  const std::scoped_lock lock(mutex_);
  if (names_.size() >= kMostNames && !names_.contains(peer)) return;
  Names& known = names_[peer];
  if (known.newest == name || known.count == kMostNamesOfOne) return;
  known.newest = name;
  ++known.count;
  unnoted_.emplace_back(peer, name);
}

void Recorder::Run() {
  const auto asked_to_stop = [this] {
    std::unique_lock lock(mutex_);
    return stopping_.wait_for(lock, kWritePeriod, [this] {
      return stop_;
    });
  };
  while (!asked_to_stop()) WriteDown();
  WriteDown();
}

void Recorder::WriteDown() {
  const bool last = ended_.load();
  TakeFrames();
  TakeNames();
  if (fault_.load() == 0) {
    int fault = 0;
    const std::size_t written = WriteAll(descriptor_, out_.data(), out_.size(), fault);
    const auto whole = std::upper_bound(ends_.begin(), ends_.end(), written);
    frames_ += static_cast<std::uint64_t>(whole - ends_.begin());
    if (fault == 0) {
      bytes_ += written;
    } else {
      // a partial frame is useless, and its room may be needed
      bytes_ += whole == ends_.begin() ? 0 : *(whole - 1);
      if (ftruncate(descriptor_, static_cast<off_t>(bytes_)) != 0) errno = 0;
      fault_.store(fault);
    }
  }
  if (last) drained_.store(true);
}

void Recorder::TakeFrames() {
  taken_.clear();
  out_.clear();
  ends_.clear();
  ring_.TakeAll(taken_);
  std::size_t at = 0;
  while (at < taken_.size()) {
    std::uint32_t length = 0;
    std::memcpy(&length, &taken_[at], sizeof length);
    at += sizeof length;
    Append(out_, length);
    Append(out_, Crc32(&taken_[at], length));
    out_.insert(out_.end(), taken_.begin() + static_cast<std::ptrdiff_t>(at),
                taken_.begin() + static_cast<std::ptrdiff_t>(at + length));
    at += length;
    ends_.push_back(out_.size());
  }
}

void Recorder::TakeNames() {
  std::vector<std::pair<PeerId, std::string>> names;
  {
    const std::scoped_lock lock(mutex_);
    names.swap(unnoted_);
  }
  for (const auto& [peer, name] : names) {
    std::vector<std::byte> content;
    Append(content, FramePart::kName);
    Append(content, peer);
    std::array<char, kNameBytes> text{};
    std::copy_n(name.data(), std::min(name.size(), text.size()), text.data());
    Append(content, text);
    Append(out_, static_cast<std::uint32_t>(content.size()));
    Append(out_, Crc32(content.data(), content.size()));
    out_.insert(out_.end(), content.begin(), content.end());
  }
}

template <typename T>
void Recorder::PutPart(FramePart part, const T& value) noexcept {
  Encoder code(ring_);
  code(part);
  CodeFields(code, value);
}

void Recorder::Begin(std::int64_t now_ns, double capacity) noexcept {
  ring_.Open();
  Encoder code(ring_);
  code(FramePart::kBegin);
  code(now_ns);
  code(capacity);
}
void Recorder::OnReceived(const MembershipChange& change) noexcept {
  PutPart(FramePart::kMembership, change);
}
void Recorder::OnReceived(const Event& event) noexcept {
  PutPart(FramePart::kEvent, event);
}
void Recorder::OnReceived(const ObjectState& state) noexcept {
  PutPart(FramePart::kState, state);
}
void Recorder::OnReceived(const CouplingLinks& links) noexcept {
  PutPart(FramePart::kLinks, links);
}
void Recorder::OnCommand(const Command& command) noexcept {
  PutPart(FramePart::kCommand, command);
}
void Recorder::OnDevice(const Anchor& device) noexcept {
  PutPart(FramePart::kDevice, device);
}
void Recorder::End(std::uint64_t state_hash) noexcept {
  Encoder code(ring_);
  code(FramePart::kEnd);
  code(state_hash);
  // once a frame is missing, all later ones are worthless
  if (ended_.load(std::memory_order_relaxed)) {
    ring_.Abandon();
  } else if (!ring_.Commit()) {
    ended_.store(true, std::memory_order_relaxed);
  }
}

}  // namespace tandem
