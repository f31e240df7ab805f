#pragma once

#include <atomic>
#include <cstdint>
#include <deque>
#include <functional>
#include <mutex>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "collab/transfer/file_messages.h"
#include "collab/transfer/scene_files.h"
#include "collab/transfer/scene_list.h"

namespace tandem {

/// Hands the files of a session's scene to the programs that ask, at a limited total rate. Each
/// asking program takes a bounded place, whatever it asks for: there are kMostRequesters places of
/// kMostWaiting pieces each, served in turn. A program that has not asked for kForgetNs loses its
/// place; until then no other program gets it.
class SceneServer : public TransferEndpoint {
 public:
  static constexpr std::size_t kMostRequesters = 16;
  static constexpr std::size_t kMostWaiting = 512;
  static constexpr std::int64_t kForgetNs = 2'000'000'000;
  static constexpr std::int64_t kOffersPerSecond = 20;
  static constexpr std::uint64_t kDefaultRate = 7'000'000;  // bytes/s

  /// `open`: opens the files when the first program asks.
  using Open = std::function<Result<SceneFiles>(const std::atomic<bool>& stop)>;
  /// `rate`: bytes/s.
  SceneServer(PeerId self, std::uint64_t content_hash, Open open, std::uint64_t rate);

  bool serves() const override { return true; }
  void OnAsk(const FileAsk& ask, std::int64_t now_ns) override;
  std::int64_t Tick(std::int64_t now_ns, const Out& out) override;
  void Stop() override { stop_.store(true); }

  /// Returns news for a person here, each once; empty: none. From any thread.
  std::string TakeNotifications();
  std::size_t requesters() const noexcept { return requesters_.size(); }
  std::size_t waiting() const noexcept;  // pieces of all requesters

 private:
  struct Requester {
    std::uint64_t program = 0;
    PeerId peer = 0;
    FileAsk::Kind kind = FileAsk::Kind::kFiles;
    std::int64_t received_ns = 0;
    std::int64_t room_from_ns = 0;  // when its own rate has paid off the bytes sent to it
    std::uint32_t rate = 0;
    std::deque<std::uint32_t> waiting;
    std::set<std::uint32_t> known;  // pieces in `waiting`
  };

  bool Ready();
  void Note(const std::string& line);
  void Offer(std::int64_t now_ns, const Out& out);
  Requester* NextRequester(std::int64_t now_ns);
  /// Sends its next piece; returns its bytes, 0: none was sent.
  std::size_t Serve(Requester& requester, std::int64_t now_ns, const Out& out);

  const PeerId self_;
  const std::uint64_t content_hash_;
  const Open open_;
  const std::uint64_t rate_;
  std::atomic<bool> stop_{false};
  std::atomic<bool> has_news_{false};
  std::mutex news_mutex_;
  std::string notifications_;
  bool reported_ = false;  // the user was told that a program fetches
  bool opened_ = false;
  std::optional<SceneFiles> files_;
  std::vector<char> list_;  // encoded
  Sha256 list_digest_{};
  std::vector<Requester> requesters_;
  std::size_t turn_ = 0;            // index of the requester whose turn it is
  std::int64_t room_from_ns_ = 0;   // when the rate has paid off all bytes sent
  std::int64_t offer_from_ns_ = 0;  // the same for offers
  std::optional<PeerId> wants_offer_;
  PieceCoder coder_;
  std::vector<char> piece_;
  FilePiece out_;
};

}  // namespace tandem
