#include "collab/transfer/scene_fetch.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "engine/base/units.h"
#include "tests/collab/transfer/transfer_bench.h"

namespace tandem {
namespace {

namespace fs = std::filesystem;
using testing::ContentOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using testing::MemoryStore;
using testing::NoiseBytes;
using ::testing::SizeIs;
using testing::TransferBench;
using State = SceneFetch::State;

/// Two meshes of 1.2 MB in all, one of them of many pieces, the other of a part of one.
class Fetching : public ::testing::Test {
 protected:
  const std::string large_ = NoiseBytes(1'200'000, 1);
  const std::string small_ = NoiseBytes(777, 2);
  ScratchFolder folder_;
  const fs::path scene_ = testing::WriteScene(folder_, "scene", {large_, small_});
  const std::uint64_t content_ = ContentOf(scene_);
  TransferBench bench_{content_};
  MemoryStore store_;

  void Begin() {
    bench_.RunToList();
    ASSERT_EQ(bench_.fetch.state(), State::kListed) << bench_.fetch.fault();
    bench_.fetch.Begin(store_, bench_.now_ns);
  }
  void ExpectFetched() const {
    EXPECT_EQ(bench_.fetch.state(), State::kFetched) << bench_.fetch.fault();
    const auto files = store_.Files();
    ASSERT_EQ(files.size(), 3U);
    EXPECT_EQ(files.at(1), large_);
    EXPECT_EQ(files.at(2), small_);
  }
};

TEST_F(Fetching, FetchesAllFilesByteForByte) {
  bench_.AddServer(1, scene_);
  Begin();
  EXPECT_EQ(bench_.fetch.source(), 1U);
  bench_.RunToEnd(20);
  ExpectFetched();
}

TEST_F(Fetching, RequestsLostPiecesAgain) {
  bench_.loss = 0.2;
  bench_.AddServer(1, scene_);
  Begin();
  bench_.RunToEnd(60);
  ExpectFetched();
  EXPECT_THAT(bench_.fetch.liars(), SizeIs(0));
}

TEST_F(Fetching, ContinuesWithAnotherPeerAfterALeave) {
  bench_.AddServer(1, scene_);
  bench_.AddServer(2, scene_);
  Begin();
  bench_.RunWhile({State::kFetching}, 0.1);
  ASSERT_EQ(bench_.fetch.state(), State::kFetching);
  const PeerId first = bench_.fetch.source();
  bench_.servers[first].here = false;
  bench_.RunToEnd(20);
  ExpectFetched();
  EXPECT_NE(bench_.fetch.source(), first);
  EXPECT_THAT(bench_.fetch.liars(), SizeIs(0));
}

TEST_F(Fetching, WaitsForAReturningPeerThenReportsFailure) {
  bench_.AddServer(1, scene_);
  Begin();
  bench_.RunWhile({State::kFetching}, 0.1);
  bench_.servers[1].here = false;
  bench_.RunWhile({State::kFetching}, 20);
  EXPECT_EQ(bench_.fetch.state(), State::kLooking);
  bench_.servers[1].here = true;
  bench_.RunWhile({State::kLooking}, 2);
  EXPECT_EQ(bench_.fetch.state(), State::kFetching);
  bench_.servers[1].here = false;
  bench_.RunToEnd(30);
  EXPECT_EQ(bench_.fetch.state(), State::kFailed);
  EXPECT_THAT(bench_.fetch.fault(), HasSubstr("nobody who has the scene's files is left"));
  // the pieces that came are there for the next time
  EXPECT_GT(store_.pieces.size(), 3U);
}

TEST_F(Fetching, ResumesAnEarlierFetch) {
  bench_.AddServer(1, scene_);
  Begin();
  bench_.RunWhile({State::kFetching}, 0.1);
  const std::size_t before = store_.pieces.size();
  ASSERT_GT(before, 5U);
  // a piece that was written in part is fetched anew
  store_.pieces.rbegin()->second[3] ^= 1;

  TransferBench next(content_);
  SceneServer& server = next.AddServer(1, scene_);
  next.RunToList();
  next.fetch.Begin(store_, next.now_ns);
  EXPECT_GT(next.fetch.bytes_at_start(), (before - 3) * kPieceBytes);
  next.RunToEnd(20);
  EXPECT_EQ(next.fetch.state(), State::kFetched);
  EXPECT_EQ(store_.Files().at(1), large_);
  EXPECT_LT(next.servers[1].sent_bytes, large_.size() - (before - 4) * kPieceBytes + 10'000);
  EXPECT_EQ(server.waiting(), 0U);
}

TEST_F(Fetching, WrongPieceExcludesItsPeer) {
  bench_.AddServer(1, scene_);
  bench_.AddServer(2, scene_);
  bench_.AddServer(3, scene_);
  // the first two that are asked lie
  for (const PeerId liar : {1U, 2U}) {
    bench_.servers[liar].spoil = [](FilePiece& piece) {
      if (piece.kind == FileAsk::Kind::kFiles && piece.number == 9) {
        piece.compressed = false;
        piece.bytes.assign(kPieceBytes, 'x');
      }
    };
  }
  Begin();
  bench_.RunToEnd(20);
  ExpectFetched();
  EXPECT_THAT(bench_.fetch.liars(), ElementsAre(1, 2));
}

TEST_F(Fetching, ForgedPieceIsNotBlamedOnThePeer) {
  bench_.AddServer(1, scene_);
  Begin();
  FilePiece forged;
  forged.from = 1;
  forged.program = 666;
  forged.kind = FileAsk::Kind::kFiles;
  forged.content_hash = content_;
  forged.list = bench_.fetch.digest();
  forged.number = 4;
  forged.bytes.assign(kPieceBytes, 'x');
  bench_.fetch.OnPiece(forged, bench_.now_ns);
  bench_.RunToEnd(20);
  ExpectFetched();
  EXPECT_THAT(bench_.fetch.liars(), SizeIs(0));
}

TEST_F(Fetching, TriesTheMostOfferedListFirst) {
  const fs::path forged = testing::WriteScene(folder_, "forged", {NoiseBytes(50'000, 3)});
  // servers of another scene under the same content hash: what they say of it is their word
  const auto add_forged = [&](PeerId peer) {
    bench_.Add(peer, std::make_unique<SceneServer>(
                         peer, content_,
                         [forged](const std::atomic<bool>& stop) {
                           return SceneFiles::Open(forged, testing::HashesOf(forged).digest, stop);
                         },
                         SceneServer::kDefaultRate));
  };
  add_forged(1);
  add_forged(2);
  bench_.AddServer(3, scene_);
  Begin();
  EXPECT_EQ(bench_.fetch.list().files.size(), 2U);
  bench_.RunToEnd(20);
  ASSERT_EQ(bench_.fetch.state(), State::kFetched);
  store_.pieces.clear();
  bench_.fetch.Refuse("what was sent is not the session's scene", bench_.now_ns);
  EXPECT_THAT(bench_.fetch.TakeNotifications(),
              ElementsAre(HasSubstr("another peer has other files")));
  Begin();
  bench_.RunToEnd(20);
  ExpectFetched();
  EXPECT_THAT(bench_.fetch.liars(), ElementsAre(1, 2));
}

TEST_F(Fetching, MismatchedListIsRefusedAndTheNextPeerAsked) {
  bench_.AddServer(1, scene_);
  bench_.AddServer(2, scene_);
  bench_.servers[1].spoil = [](FilePiece& piece) {
    if (piece.kind != FileAsk::Kind::kList) return;
    piece.compressed = true;
    piece.bytes.assign(100, 'x');
  };
  Begin();
  bench_.RunToEnd(20);
  ExpectFetched();
  EXPECT_THAT(bench_.fetch.liars(), ElementsAre(1));
}

TEST_F(Fetching, OversizedSceneIsRefusedBeforeTheTransfer) {
  TransferBench bench(content_, 1'000'000);
  bench.AddServer(1, scene_);
  bench.RunToEnd(20);
  EXPECT_EQ(bench.fetch.state(), State::kFailed);
  EXPECT_THAT(bench.fetch.fault(),
              HasSubstr("its files have 2 MB, more than the 1 MB that are allowed"));
  EXPECT_EQ(bench.servers[1].sent_bytes, 0U);
}

TEST_F(Fetching, ReportsThatNoPeerSharesFiles) {
  bench_.RunToEnd(20);
  EXPECT_EQ(bench_.fetch.state(), State::kFailed);
  EXPECT_THAT(bench_.fetch.fault(), HasSubstr("nobody here hands out the scene's files"));
}

// A peer that makes its list of a large scene says so first.
TEST_F(Fetching, WaitsForAPeerThatPreparesItsList) {
  bench_.AddServer(1, scene_);
  bench_.servers[1].here = false;
  bench_.RunToList();
  ASSERT_EQ(bench_.fetch.state(), State::kFailed);

  TransferBench patient(content_);
  patient.AddServer(1, scene_);
  patient.servers[1].here = false;
  patient.RunWhile({State::kLooking}, 1);
  FilePiece preparing;
  preparing.from = 1;
  preparing.program = 1001;
  preparing.content_hash = content_;
  patient.fetch.OnPiece(preparing, patient.now_ns);
  patient.RunWhile({State::kLooking}, 20);
  ASSERT_EQ(patient.fetch.state(), State::kLooking);
  patient.servers[1].here = true;
  patient.RunToList();
  EXPECT_EQ(patient.fetch.state(), State::kListed);
  // with a peer that says so for ever it is patient no longer than a minute and a half
  TransferBench teased(content_);
  teased.RunWhile({State::kLooking}, 1);
  for (int i = 0; i < 200 && teased.fetch.state() == State::kLooking; ++i) {
    teased.fetch.OnPiece(preparing, teased.now_ns);
    teased.RunWhile({State::kLooking}, 1);
  }
  EXPECT_EQ(teased.fetch.state(), State::kFailed);
}

// A peer sends for ever, whatever is asked for.
TEST_F(Fetching, EndlessStreamIsBounded) {
  bench_.AddServer(1, scene_);
  Begin();
  const std::size_t pieces = bench_.fetch.list().pieces();
  FilePiece endless;
  endless.from = 1;
  endless.program = 1001;
  endless.kind = FileAsk::Kind::kFiles;
  endless.content_hash = content_;
  endless.list = bench_.fetch.digest();
  for (std::uint32_t i = 0; i < 100'000; ++i) {
    endless.number = static_cast<std::uint32_t>(pieces) + i;
    bench_.fetch.OnPiece(endless, bench_.now_ns);
  }
  EXPECT_EQ(store_.pieces.size(), 0U);
  bench_.RunToEnd(20);
  ExpectFetched();
}

TEST_F(Fetching, EndsInALineWhereTheDiskIsFull) {
  store_.room = 4;
  bench_.AddServer(1, scene_);
  Begin();
  bench_.RunToEnd(20);
  EXPECT_EQ(bench_.fetch.state(), State::kFailed);
  EXPECT_THAT(bench_.fetch.fault(), HasSubstr("the disk is full"));
}

// The line takes 1 MB/s and has a queue before it, which 7 MB/s would fill.
TEST(RateController, FallsWithQueueingAndRisesWithout) {
  RateController finder;
  std::int64_t now_ns = 1'000'000'000;
  std::int64_t free_ns = now_ns;  // when the line has carried all
  const double way = 1e6;
  std::int64_t sent_ns = now_ns;
  std::int64_t longest_ns = 0;
  for (int i = 0; i < 600; ++i) {
    const std::size_t bytes = 16'000;
    sent_ns +=
        static_cast<std::int64_t>(1e9 * static_cast<double>(bytes) / std::min(7e6, finder.rate()));
    free_ns = std::max(free_ns, sent_ns) +
              static_cast<std::int64_t>(1e9 * static_cast<double>(bytes) / way);
    now_ns = free_ns;
    finder.OnPiece(now_ns - sent_ns, bytes);
    finder.Tick(now_ns);
    if (i > 300) longest_ns = std::max(longest_ns, now_ns - sent_ns);
  }
  EXPECT_LT(finder.rate(), 2 * way);
  EXPECT_GT(finder.rate(), 0.2 * way);
  // twice the delay that makes it go down, and a step of 0.1 s at 1.3 times the way's rate
  EXPECT_LT(longest_ns, 250 * kMs);
}

}  // namespace
}  // namespace tandem
