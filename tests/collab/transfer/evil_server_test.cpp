#include "tests/collab/transfer/evil_server.h"

#include <algorithm>
#include <functional>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <zstd.h>

#include "tests/collab/transfer/transfer_bench.h"

// Tests what a joiner makes of a peer that hands out scenes and means ill.

namespace tandem {
namespace {

namespace fs = std::filesystem;
using ::testing::ElementsAre;
using testing::EvilServer;
using ::testing::HasSubstr;
using testing::Listed;
using testing::NoiseBytes;
using testing::TransferBench;
using State = SceneFetch::State;

constexpr std::uint64_t kEvilContent = 42;
constexpr PeerId kEvil = 6;

class EvilSceneServer : public ::testing::Test {
 protected:
  void Meets(EvilServer::Answer answer) {
    bench_.Add(kEvil, std::make_unique<EvilServer>(kEvil, kEvilContent, std::move(answer)));
  }
  /// Fetches, accepts every list, and refuses every scene that arrives whole. Returns why it
  /// failed.
  std::string Outcome(double seconds = 600) {
    const std::int64_t until_ns = bench_.now_ns + static_cast<std::int64_t>(1e9 * seconds);
    while (bench_.now_ns < until_ns && bench_.fetch.state() != State::kFailed) {
      bench_.Step();
      if (bench_.fetch.state() == State::kListed) Accept();
      if (bench_.fetch.state() == State::kFetched) {
        ++whole_;
        files_.reset();
        bench_.fetch.Refuse("the fetched scene is not the session's", bench_.now_ns);
      }
    }
    if (bench_.fetch.state() == State::kFetching || bench_.fetch.state() == State::kFailed) {
      if (files_) files_->Remove();
    }
    const std::string fault = bench_.fetch.state() == State::kFailed ? bench_.fetch.fault() : "";
    EXPECT_EQ(std::count(fault.begin(), fault.end(), '\n'), 0) << fault;
    return fault;
  }
  void Accept() {
    bool busy = false;
    Result<UnfinishedScene> opened =
        UnfinishedScene::Open(store_, bench_.fetch.list(), bench_.fetch.digest(),
                              {.most_bytes = 1U << 30U, .spare_bytes = 0}, busy);
    ASSERT_TRUE(opened) << opened.error().what;
    files_.reset();
    files_.emplace(*std::move(opened));
    bench_.fetch.Begin(*files_, bench_.now_ns);
  }

  const Listed listed_{
      {R"({"name": "s", "voxel_m": 0.001, "bodies": []})", NoiseBytes(500'000, 3)}};
  ScratchFolder folder_;
  const SceneStore store_{folder_.path() / "fetched"};
  std::optional<UnfinishedScene> files_;
  TransferBench bench_{kEvilContent};
  int whole_ = 0;
};

TEST_F(EvilSceneServer, WrongPiecesEndItsTransferAtOnce) {
  const std::vector<std::function<void(FilePiece&)>> spoilers{
      [](FilePiece& piece) {
        piece.bytes[7] ^= 1;
      },
      [](FilePiece& piece) {
        piece.bytes.pop_back();
      },
      [](FilePiece& piece) {
        piece.bytes.push_back('x');
      },
      [](FilePiece& piece) {
        piece.bytes.clear();
      },
      [](FilePiece& piece) {
        piece.compressed = true;
      },
      // a piece that unpacks to 64 MB, and says so or not
      [](FilePiece& piece) {
        const std::string zeros(64U << 20U, '\0');
        piece.bytes.resize(ZSTD_compressBound(zeros.size()));
        piece.bytes.resize(
            ZSTD_compress(piece.bytes.data(), piece.bytes.size(), zeros.data(), zeros.size(), 1));
        piece.compressed = true;
      }};
  for (std::size_t i = 0; i < spoilers.size(); ++i) {
    TransferBench bench(kEvilContent);
    testing::MemoryStore store;
    bench.Add(kEvil, std::make_unique<EvilServer>(
                         kEvil, kEvilContent, [&](const FileAsk& ask, const auto& send) {
                           EvilServer::Serve(listed_, ask, [&](FilePiece piece) {
                             if (piece.kind == FileAsk::Kind::kFiles && piece.number == 5)
                               spoilers[i](piece);
                             send(piece);
                           });
                         }));
    bench.RunToList();
    ASSERT_EQ(bench.fetch.state(), State::kListed);
    bench.fetch.Begin(store, bench.now_ns);
    bench.RunToEnd(60);
    EXPECT_EQ(bench.fetch.state(), State::kFailed) << i;
    EXPECT_THAT(bench.fetch.liars(), ElementsAre(kEvil)) << i;
    EXPECT_THAT(bench.fetch.TakeNotifications(),
                ElementsAre(HasSubstr("sent a piece that is not the file's")))
        << i;
    EXPECT_EQ(store.pieces.count({1, 4 * kPieceBytes}), 0U) << i;
  }
}

// The second time that it is asked for its list, it has another.
TEST_F(EvilSceneServer, ListsWithoutEndAreRefusedAfterTheFirst) {
  int lists = 0;
  Meets([&](const FileAsk& ask, const auto& send) {
    const Listed bogus({"scene " + std::to_string(lists), NoiseBytes(1000, 1)});
    EvilServer::Serve(bogus, ask, send);
    if (ask.kind == FileAsk::Kind::kFiles) ++lists;
  });
  EXPECT_THAT(Outcome(), HasSubstr("is not the session's"));
  EXPECT_EQ(whole_, 1);
  EXPECT_THAT(bench_.fetch.liars(), ElementsAre(kEvil));
}

TEST_F(EvilSceneServer, ListsThatMakeNoSenseAreRefused) {
  std::vector<std::vector<char>> lists;
  const auto add = [&](const std::function<void(SceneList&)>& change) {
    SceneList list = listed_.list;
    change(list);
    lists.push_back(Encode(list));
  };
  add([](SceneList& list) {
    list.files[1].bytes = UINT64_MAX;
  });
  add([](SceneList& list) {
    list.files[1].bytes = 0;
  });
  add([](SceneList& list) {
    list.files[1].bytes += kPieceBytes;
  });
  add([](SceneList& list) {
    list.files[0].bytes = SceneList::kMostSceneBytes + 1;
  });
  add([](SceneList& list) {
    list.files[1].pieces.pop_back();
  });
  add([](SceneList& list) {
    list.files.push_back(list.files[1]);
  });
  add([](SceneList& list) {
    list.files.resize(1);
  });
  add([](SceneList& list) {
    list.files[1].kind = ".json";
  });
  lists.emplace_back(100, 'x');
  lists.emplace_back(1, '\0');
  for (const std::vector<char>& encoded : lists) {
    TransferBench bench(kEvilContent);
    Listed bogus = listed_;
    bogus.encoded = encoded;
    bench.Add(kEvil, std::make_unique<EvilServer>(kEvil, kEvilContent,
                                                  [&](const FileAsk& ask, const auto& send) {
                                                    EvilServer::Serve(bogus, ask, send);
                                                  }));
    bench.RunToList();
    EXPECT_EQ(bench.fetch.state(), State::kFailed);
    EXPECT_THAT(bench.fetch.fault(), HasSubstr("the list of files that was sent is refused: "));
  }
}

TEST_F(EvilSceneServer, SizesBeyondTheLimitTakeNoMemory) {
  Meets([&](const FileAsk& ask, const auto& send) {
    FilePiece piece;
    piece.kind = ask.kind;
    piece.list_bytes = UINT32_MAX;
    piece.total_bytes = 1;
    send(piece);
  });
  EXPECT_THAT(Outcome(), HasSubstr("its list of files has 4295 MB, more than the "));
}

// It offers, and then says nothing: for ever, if it is asked again for ever.
TEST_F(EvilSceneServer, OffersWithoutPiecesAreGivenUp) {
  Meets([&](const FileAsk& ask, const auto& send) {
    if (ask.kind == FileAsk::Kind::kOffer) EvilServer::Serve(listed_, ask, send);
  });
  const std::int64_t began_ns = bench_.now_ns;
  EXPECT_THAT(Outcome(), HasSubstr("nobody here hands out the scene's files"));
  EXPECT_LT(bench_.now_ns - began_ns, 60'000 * kMs);
}

// A piece again and again keeps its sender's turn, if each counts as news.
TEST_F(EvilSceneServer, TheSamePieceForEverIsNoProgress) {
  Meets([&](const FileAsk& ask, const auto& send) {
    if (ask.kind != FileAsk::Kind::kFiles) return EvilServer::Serve(listed_, ask, send);
    FileAsk first = ask;
    first.first = 0;
    first.wanted.reset();
    first.wanted[0] = true;
    EvilServer::Serve(listed_, first, send);
  });
  EXPECT_THAT(Outcome(), HasSubstr("nobody who has the scene's files is left"));
  EXPECT_TRUE(fs::is_empty(store_.group()));
}

TEST_F(EvilSceneServer, SlowDripIsGivenUp) {
  const Listed large({"scene", NoiseBytes(3'000'000, 4)});
  std::int64_t next_ns = 0;
  Meets([&](const FileAsk& ask, const auto& send) {
    if (ask.kind != FileAsk::Kind::kFiles) return EvilServer::Serve(large, ask, send);
    if (bench_.now_ns < next_ns) return;
    next_ns = bench_.now_ns + 2'300 * kMs;
    FileAsk one = ask;
    one.wanted.reset();
    one.wanted[0] = true;
    EvilServer::Serve(large, one, send);
  });
  const std::int64_t began_ns = bench_.now_ns;
  EXPECT_THAT(Outcome(400), HasSubstr("nobody who has the scene's files is left"));
  // 93 pieces at this rate would take 214 s
  EXPECT_LT(bench_.now_ns - began_ns, 120'000 * kMs);
}

}  // namespace
}  // namespace tandem
