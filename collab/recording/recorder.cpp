#include "collab/recording/recorder.h"

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <cstring>
#include <utility>

#include <fcntl.h>
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

bool WriteAll(int descriptor, const std::byte* data, std::size_t size) {
  while (size > 0) {
    const ssize_t written = write(descriptor, data, size);
    if (written < 0 && errno == EINTR) continue;
    if (written <= 0) return false;
    data += written;
    size -= static_cast<std::size_t>(written);
  }
  return true;
}

}  // namespace

Result<std::unique_ptr<Recorder>> Recorder::Create(const std::filesystem::path& file,
                                                   const RecordingHeader& header) {
  const int descriptor = open(file.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0644);
  if (descriptor < 0) return Error{file.string() + ": " + std::strerror(errno)};
  const std::string text = AsText(header);
  std::vector<std::byte> head;
  for (const char c : kRecordingMagic) head.push_back(static_cast<std::byte>(c));
  Append(head, static_cast<std::uint32_t>(text.size()));
  for (const char c : text) head.push_back(static_cast<std::byte>(c));
  if (!WriteAll(descriptor, head.data(), head.size())) {
    close(descriptor);
    return Error{file.string() + ": cannot be written"};
  }
  return std::unique_ptr<Recorder>(new Recorder(file, descriptor));
}

Recorder::Recorder(std::filesystem::path file, int descriptor)
    : file_(std::move(file)), descriptor_(descriptor), thread_([this] {
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
  if (close(std::exchange(descriptor_, -1)) != 0) failed_ = true;
  const std::string frames = std::to_string(frames_) + " frames";
  if (failed_) return Error{file_.string() + ": cannot be written; it ends after " + frames};
  if (ended_.load())
    return Error{file_.string() + ": the disk is too slow; it ends after " + frames};
  return frames_;
}

void Recorder::Named(PeerId peer, const std::string& name) {
  const std::scoped_lock lock(mutex_);
  std::string& known = names_[peer];
  if (known == name) return;
  known = name;
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
  taken_.clear();
  out_.clear();
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
    ++frames_;
  }
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
  if (!failed_ && !WriteAll(descriptor_, out_.data(), out_.size())) failed_ = true;
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
void Recorder::Heard(const MembershipChange& change) noexcept {
  PutPart(FramePart::kMembership, change);
}
void Recorder::Heard(const Event& event) noexcept {
  PutPart(FramePart::kEvent, event);
}
void Recorder::Heard(const ObjectState& state) noexcept {
  PutPart(FramePart::kState, state);
}
void Recorder::Heard(const CouplingLinks& links) noexcept {
  PutPart(FramePart::kLinks, links);
}
void Recorder::Asked(const Command& command) noexcept {
  PutPart(FramePart::kCommand, command);
}
void Recorder::Felt(const Anchor& device) noexcept {
  PutPart(FramePart::kDevice, device);
}
void Recorder::End(std::uint64_t state_hash) noexcept {
  Encoder code(ring_);
  code(FramePart::kEnd);
  code(state_hash);
  // once a frame is missing, all that follows is worthless
  if (ended_.load(std::memory_order_relaxed)) {
    ring_.Abandon();
  } else if (!ring_.Commit()) {
    ended_.store(true, std::memory_order_relaxed);
  }
}

}  // namespace tandem
