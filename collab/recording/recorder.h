#pragma once

#include <atomic>
#include <condition_variable>
#include <filesystem>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <string_view>
#include <thread>
#include <utility>
#include <vector>

#include "collab/recording/byte_ring.h"
#include "collab/recording/frame_code.h"
#include "collab/recording/recording.h"

namespace tandem {

inline constexpr std::string_view kRecordingMagic = "tandem-recording 2\n";
inline constexpr std::string_view kFirstRecordingMagic = "tandem-recording 1\n";

/// Records every input of every frame in a file; a crash of the program loses at most the last 100
/// ms. The haptic thread puts frames into a ring, and the recorder's own thread writes them. If
/// that cannot keep up, the recording ends with the last whole frame, for later frames could not be
/// repeated.
class Recorder final : public FrameObserver {
 public:
  /// Makes a new file, readable by its owner alone. Refuses a file that has bytes in it or is being
  /// recorded into: recordings are never overwritten.
  static Result<std::unique_ptr<Recorder>> Create(const std::filesystem::path& file,
                                                  const RecordingHeader& header);
  ~Recorder() override;
  Recorder(const Recorder&) = delete;
  Recorder& operator=(const Recorder&) = delete;

  void Begin(std::int64_t now_ns, double capacity) noexcept override;
  void OnReceived(const MembershipChange& change) noexcept override;
  void OnReceived(const Event& event) noexcept override;
  void OnReceived(const ObjectState& state) noexcept override;
  void OnReceived(const CouplingLinks& links) noexcept override;
  void OnCommand(const Command& command) noexcept override;
  void OnDevice(const Anchor& device) noexcept override;
  void End(std::uint64_t state_hash) noexcept override;

  /// Notes a peer's name for readers of the recording. Called by another thread than the haptic
  /// one.
  void Named(PeerId peer, const std::string& name);

  /// Returns once that the recording has ended before its peer, and why; otherwise empty. Called by
  /// another thread than the haptic one.
  std::string News();

  /// Writes the rest after the last frame, and waits until the disk has it; returns the number of
  /// frames in the file. Errors: the disk was full or too slow, and nothing was kept from that
  /// frame on.
  Result<std::uint64_t> Close();
  /// Closes likewise, and removes the file.
  void Discard();

 private:
  // Peers with invented ids and names may come without end: further ones stay nameless.
  static constexpr std::size_t kMostNames = 4096;
  static constexpr int kMostNamesOfOne = 16;
  struct Names {
    std::string newest;
    int count = 0;
  };

  /// `bytes`: size of the file so far.
  Recorder(std::filesystem::path file, int descriptor, std::uint64_t bytes);
  void Run();
  void WriteDown();
  /// Appends the ring's frames to out_, and the end of each to ends_.
  void TakeFrames();
  void TakeNames();
  std::string WhyEnded() const;
  template <typename T>
  void PutPart(FramePart part, const T& value) noexcept;

  const std::filesystem::path file_;
  int descriptor_;
  ByteRing ring_{std::size_t{1} << 24U};
  std::atomic<bool> ended_{false};    // a frame did not fit
  std::atomic<bool> drained_{false};  // and the frames before it are written
  std::mutex mutex_;
  std::condition_variable stopping_;
  bool stop_ = false;
  std::map<PeerId, Names> names_;                        // as given; guarded by mutex_
  std::vector<std::pair<PeerId, std::string>> unnoted_;  // names still to be written
  std::vector<std::byte> taken_;                         // buffer of the writing thread
  std::vector<std::byte> out_;
  std::vector<std::size_t> ends_;         // ends of the frames in out_
  std::uint64_t bytes_ = 0;               // in the file, all in whole frames
  std::atomic<std::uint64_t> frames_{0};  // in the file
  std::atomic<int> fault_{0};             // errno: the disk took no more
  bool reported_ = false;                 // News() has reported it
  std::thread thread_;
};

}  // namespace tandem
