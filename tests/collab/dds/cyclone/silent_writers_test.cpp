#include "collab/dds/cyclone/silent_writers.h"

#include <gtest/gtest.h>

namespace tandem {
namespace {

constexpr dds_instance_handle_t kAnna = 11, kBen = 12;

/// A reader's listener that is told what Cyclone would tell it.
class SilentWritersListener : public ::testing::Test {
 protected:
  void Tell(dds_instance_handle_t writer, int alive, int not_alive) {
    dds_on_liveliness_changed_fn tell = nullptr;
    dds_lget_liveliness_changed(listener_.get(), &tell);
    ASSERT_NE(tell, nullptr);
    dds_liveliness_changed_status_t status{};
    status.alive_count_change = alive;
    status.not_alive_count_change = not_alive;
    status.last_publication_handle = writer;
    tell(0, status, &quiet_);
  }
  void Comes(dds_instance_handle_t writer) { Tell(writer, 1, 0); }
  void FallsSilent(dds_instance_handle_t writer) { Tell(writer, -1, 1); }
  void SpeaksAgain(dds_instance_handle_t writer) { Tell(writer, 1, -1); }
  void Goes(dds_instance_handle_t writer) { Tell(writer, 0, -1); }

  SilentWriters quiet_;
  const Listener listener_ = quiet_.MakeListener(0);
};

TEST_F(SilentWritersListener, WriterIsQuietFromSilenceToItsEnd) {
  Comes(kAnna);
  Comes(kBen);
  EXPECT_FALSE(quiet_.Has(kAnna));
  FallsSilent(kAnna);
  EXPECT_TRUE(quiet_.Has(kAnna));
  EXPECT_FALSE(quiet_.Has(kBen));
  SpeaksAgain(kAnna);
  EXPECT_FALSE(quiet_.Has(kAnna));
}

// Two threads of Cyclone tell it so to a program that was stopped for longer than the lease.
TEST_F(SilentWritersListener, EndReportedBeforeTheStartStillCounts) {
  Comes(kAnna);
  SpeaksAgain(kAnna);
  FallsSilent(kAnna);
  EXPECT_FALSE(quiet_.Has(kAnna));
  FallsSilent(kAnna);
  EXPECT_TRUE(quiet_.Has(kAnna)) << "the next silence counts";
}

TEST_F(SilentWritersListener, CombinedStartAndEndChangeNothing) {
  Comes(kAnna);
  FallsSilent(kAnna);
  Tell(kAnna, 0, 0);
  EXPECT_TRUE(quiet_.Has(kAnna));
  SpeaksAgain(kAnna);
  SpeaksAgain(kAnna);
  Tell(kAnna, 0, 0);
  FallsSilent(kAnna);
  EXPECT_FALSE(quiet_.Has(kAnna)) << "the end was told before, and still counts";
}

TEST_F(SilentWritersListener, DepartedWriterIsForgotten) {
  FallsSilent(kAnna);
  Goes(kAnna);
  EXPECT_FALSE(quiet_.Has(kAnna));
  SpeaksAgain(kBen);
  Tell(kBen, -1, 0);
  FallsSilent(kBen);
  EXPECT_TRUE(quiet_.Has(kBen)) << "a new writer with the number of one that has gone";
  quiet_.Forget(kBen);
  EXPECT_FALSE(quiet_.Has(kBen));
}

}  // namespace
}  // namespace tandem
