#include "engine/realtime/seqlock.h"

#include <array>
#include <atomic>
#include <cstring>
#include <thread>

#include <gtest/gtest.h>

#include "engine/realtime/clock.h"
#include "engine/realtime/doorbell.h"

namespace tandem {
namespace {

struct Numbers {
  std::array<std::uint64_t, 13> n{};
};

TEST(Seqlock, IsEmptyBeforeTheFirstWriteThenNewest) {
  Seqlock<Numbers> shared;
  Numbers read;
  read.n[0] = 77;
  EXPECT_FALSE(shared.Read(read));
  EXPECT_EQ(read.n[0], 77U);
  for (std::uint64_t i = 1; i < 5; ++i) {
    Numbers written;
    written.n.fill(i);
    shared.Write(written);
  }
  ASSERT_TRUE(shared.Read(read));
  EXPECT_EQ(read.n[12], 4U);
}

TEST(Seqlock, ReadersNeverSeeATornValue) {
  Seqlock<Numbers> shared;
  std::atomic<bool> end{false};
  std::thread writer([&] {
    Numbers written;
    for (std::uint64_t i = 1; !end; ++i) {
      written.n.fill(i);
      shared.Write(written);
    }
  });
  Numbers read;
  std::uint64_t last = 0;
  int changes = 0;
  int torn = 0;
  int older = 0;
  while (changes < 20'000) {
    if (!shared.Read(read)) continue;
    for (const std::uint64_t n : read.n) torn += n != read.n[0] ? 1 : 0;
    older += read.n[0] < last ? 1 : 0;
    changes += read.n[0] != last ? 1 : 0;
    last = read.n[0];
  }
  end = true;
  writer.join();
  EXPECT_EQ(torn, 0);
  EXPECT_EQ(older, 0);
}

// A writer that dies within a write leaves the counter odd.
TEST(Seqlock, ReaderOfADeadWriterGetsNothing) {
  Seqlock<Numbers> shared;
  Numbers written;
  written.n.fill(1);
  shared.Write(written);
  auto* turn = reinterpret_cast<std::atomic<std::uint64_t>*>(&shared);
  turn->store(turn->load() + 1);
  Numbers read;
  EXPECT_FALSE(shared.Read(read));
  EXPECT_EQ(read.n[0], 0U);
}

TEST(Doorbell, EndsAWaitByRingingOrByTime) {
  Doorbell doorbell;
  const std::uint32_t seen = doorbell.rings();
  EXPECT_FALSE(doorbell.WaitBeyond(seen, MonotonicNowNs() + 2'000'000, 100'000));
  std::thread ringer([&] {
    doorbell.Ring();
  });
  EXPECT_TRUE(doorbell.WaitBeyond(seen, MonotonicNowNs() + 10'000'000'000, 0));
  ringer.join();
  EXPECT_TRUE(doorbell.WaitBeyond(seen, 0, 0));
}

}  // namespace
}  // namespace tandem
