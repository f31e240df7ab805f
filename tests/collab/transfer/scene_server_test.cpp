#include "collab/transfer/scene_server.h"

#include <map>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/collab/transfer/transfer_bench.h"

namespace tandem {
namespace {

namespace fs = std::filesystem;
using testing::NoiseBytes;

/// A server of a scene of 4 MB that no compression makes smaller, and what it sends.
class Serving : public ::testing::Test {
 protected:
  static constexpr std::uint64_t kRate = 2'000'000;

  ScratchFolder folder_;
  const fs::path scene_ = testing::WriteScene(folder_, "scene", {NoiseBytes(4'000'000, 1)});
  const std::uint64_t content_ = testing::ContentOf(scene_);
  const Sha256 digest_ = testing::HashesOf(scene_).digest;
  SceneServer server_{1, content_,
                      [this](const std::atomic<bool>& stop) {
                        return SceneFiles::Open(scene_, digest_, stop);
                      },
                      kRate};
  std::int64_t now_ns_ = 1'000'000'000;
  std::vector<FilePiece> sent_;
  std::map<PeerId, double> bytes_to_;
  std::size_t listeners_ = 1;

  FileAsk Ask(PeerId from, FileAsk::Kind kind, std::uint32_t first = 0) {
    FileAsk ask;
    ask.from = from;
    ask.program = 100 + from;
    ask.to = 1;
    ask.kind = kind;
    ask.content_hash = content_;
    ask.list = list_;
    ask.first = first;
    if (kind != FileAsk::Kind::kOffer) ask.wanted.set();
    ask.rate = 100'000'000;
    return ask;
  }
  void Run(double seconds) {
    const auto until_ns = now_ns_ + static_cast<std::int64_t>(1e9 * seconds);
    TransferEndpoint::Out out;
    out.piece = [this](const FilePiece& piece) {
      sent_.push_back(piece);
      bytes_to_[piece.to] += static_cast<double>(piece.bytes.size());
    };
    out.listeners = [this] {
      return listeners_;
    };
    while (now_ns_ < until_ns) now_ns_ = std::max(now_ns_ + 1000, server_.Tick(now_ns_, out));
    now_ns_ = until_ns;
  }
  void Open() {
    server_.OnAsk(Ask(7, FileAsk::Kind::kOffer), now_ns_);
    Run(0.1);
    // it says that it has them and, when the list is made, sends the list
    ASSERT_EQ(sent_.size(), 2U);
    EXPECT_EQ(sent_[0].list_bytes, 0U);
    EXPECT_GT(sent_[1].total_bytes, 4'000'000U);
    list_ = sent_[1].list;
    sent_.clear();
  }
  Sha256 list_{};
};

TEST_F(Serving, RespectsItsRateLimit) {
  Open();
  for (int i = 0; i < 20; ++i) {
    server_.OnAsk(Ask(7, FileAsk::Kind::kFiles), now_ns_);
    Run(0.1);
  }
  // 2 MB/s for 2 s, of which heads take a part
  EXPECT_LT(bytes_to_[7], 4'050'000);
  EXPECT_GT(bytes_to_[7], 3'600'000);
}

TEST_F(Serving, GivesAllReceiversEqualShares) {
  Open();
  for (int i = 0; i < 20; ++i) {
    for (const PeerId peer : {7U, 8U, 9U, 10U}) {
      server_.OnAsk(Ask(peer, FileAsk::Kind::kFiles), now_ns_);
    }
    Run(0.1);
  }
  for (const PeerId peer : {7U, 8U, 9U, 10U}) EXPECT_NEAR(bytes_to_[peer], 950'000, 100'000);
}

TEST_F(Serving, SendsAtTheReceiversRate) {
  Open();
  for (int i = 0; i < 20; ++i) {
    FileAsk ask = Ask(7, FileAsk::Kind::kFiles);
    ask.rate = 300'000;
    server_.OnAsk(ask, now_ns_);
    Run(0.1);
  }
  EXPECT_NEAR(bytes_to_[7], 600'000, 60'000);
}

TEST_F(Serving, DuplicateSendsCountTowardsTheRate) {
  Open();
  listeners_ = 4;
  for (int i = 0; i < 20; ++i) {
    server_.OnAsk(Ask(7, FileAsk::Kind::kFiles), now_ns_);
    Run(0.1);
  }
  EXPECT_NEAR(bytes_to_[7], 1'000'000, 100'000);
}

// 10,000 programs of strangers, each of which wants all, again and again.
TEST_F(Serving, RequestFloodTakesBoundedMemoryAndBandwidth) {
  Open();
  for (std::uint32_t i = 0; i < 10'000; ++i) {
    server_.OnAsk(Ask(20 + i, FileAsk::Kind::kFiles, i % 100), now_ns_);
    server_.OnAsk(Ask(20 + i, FileAsk::Kind::kOffer), now_ns_);
    FileAsk beyond = Ask(20 + i, FileAsk::Kind::kFiles, 0xFFFFFF00U);
    server_.OnAsk(beyond, now_ns_);
  }
  EXPECT_EQ(server_.requesters(), SceneServer::kMostRequesters);
  EXPECT_LE(server_.waiting(), SceneServer::kMostRequesters * SceneServer::kMostWaiting);
  Run(1);
  std::size_t offers = 0;
  std::size_t bytes = 0;
  for (const FilePiece& piece : sent_) {
    offers += piece.kind == FileAsk::Kind::kOffer ? 1 : 0;
    bytes += piece.bytes.size();
  }
  EXPECT_LE(offers, SceneServer::kOffersPerSecond + 1);
  EXPECT_LT(bytes, 2'100'000U);
}

TEST_F(Serving, SilentReceiverLosesItsPlace) {
  Open();
  for (std::uint32_t i = 0; i < SceneServer::kMostRequesters; ++i) {
    server_.OnAsk(Ask(20 + i, FileAsk::Kind::kFiles), now_ns_);
  }
  Run(0.1);
  server_.OnAsk(Ask(7, FileAsk::Kind::kFiles), now_ns_);
  Run(0.1);
  EXPECT_EQ(bytes_to_[7], 0);
  Run(3);
  server_.OnAsk(Ask(7, FileAsk::Kind::kFiles), now_ns_);
  Run(0.1);
  EXPECT_EQ(server_.requesters(), 1U);
  EXPECT_GT(bytes_to_[7], 100'000);
}

TEST_F(Serving, RefusesAChangedScene) {
  folder_.Write("scene/mesh 0.stl", NoiseBytes(4'000'000, 9));
  server_.OnAsk(Ask(7, FileAsk::Kind::kOffer), now_ns_);
  Run(0.2);
  for (const FilePiece& piece : sent_) EXPECT_EQ(piece.list_bytes, 0U);
  EXPECT_THAT(server_.TakeNotifications(), ::testing::HasSubstr("or its mesh files have changed"));
  EXPECT_EQ(server_.TakeNotifications(), "");
}

TEST_F(Serving, IgnoresRequestsForOtherScenesOrPeers) {
  Open();
  FileAsk other = Ask(7, FileAsk::Kind::kFiles);
  other.content_hash ^= 1;
  server_.OnAsk(other, now_ns_);
  other = Ask(7, FileAsk::Kind::kFiles);
  other.to = 2;
  server_.OnAsk(other, now_ns_);
  other = Ask(7, FileAsk::Kind::kFiles);
  other.list[0] ^= 1;
  server_.OnAsk(other, now_ns_);
  Run(0.5);
  EXPECT_TRUE(sent_.empty());
}

}  // namespace
}  // namespace tandem
