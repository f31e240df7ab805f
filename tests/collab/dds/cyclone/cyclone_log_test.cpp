#include "collab/dds/cyclone/cyclone_log.h"

#include <algorithm>
#include <chrono>
#include <string>

#include <gmock/gmock.h>

#include "collab/dds/cyclone/dds_api.h"
#include "engine/base/files/regular_file.h"
#include "engine/realtime/line_writer.h"

namespace tandem {
namespace {

/// Has Cyclone log the words, and returns what our sink has kept of them.
std::string KeptOf(const std::string& words) {
  RedirectCycloneLog();
  CycloneLogCapture capture;
  dds_log(DDS_LC_WARNING, __FILE__, __LINE__, "test", "%s\n", words.c_str());
  return capture.Take();
}

// Cyclone logs names of others' topics and types as they come.
TEST(CycloneLog, MessageIsOneLineOfPlainText) {
  EXPECT_EQ(KeptOf("writer a/\x1b[2J\xff\ntandem: all is well"),
            "writer a/?[2J? tandem: all is well");
  const std::string in_plain_words = ExplainMessage(KeptOf("malformed \x1b]0;title\x07\r\nforged"));
  EXPECT_TRUE(IsPlainText(in_plain_words)) << in_plain_words;
  EXPECT_EQ(in_plain_words, "a damaged or hostile packet was dropped");
}

TEST(CycloneLog, MessageLengthIsBounded) {
  EXPECT_LT(KeptOf("writer " + std::string(10'000, 'x')).size(), 500U);
}

// Each message is one that Cyclone 0.10.2 writes where a network is gone, or one of no known kind.
TEST(CycloneLog, MessageOfCycloneIsTranslatedAndItsMeaningWrittenOnce) {
  RedirectCycloneLog();
  ::testing::internal::CaptureStderr();
  for (int i = 0; i < 30; ++i) {
    for (const char* const message :
         {"ddsi_udp_conn_write to udp/10.9.0.2:18162 failed with retcode -1",
          "UDP recvmsg sock 7: ret -1 retcode -3", "ddsi_frobnicate: 0x17"}) {
      dds_log(DDS_LC_ERROR, __FILE__, __LINE__, "test", "%s\n", message);
    }
  }
  StandardError().Flush(std::chrono::seconds(5));
  const std::string written = ::testing::internal::GetCapturedStderr();
  EXPECT_EQ(std::ranges::count(written, '\n'), 3) << written;
  for (const char* const raw : {"udp", "retcode", "frobnicate", "10.9.0.2"}) {
    EXPECT_THAT(written, ::testing::Not(::testing::HasSubstr(raw)));
  }
  EXPECT_THAT(written, ::testing::HasSubstr("packets cannot be sent at the moment"));
  EXPECT_THAT(written, ::testing::HasSubstr("tandem doctor"));
}

// Cyclone writes it in any secured session, where a packet comes before our own participant is made
// or after it is gone.
TEST(CycloneLog, PeerThatIsHeardWhileOneJoinsOrLeavesIsNoAttack) {
  EXPECT_EQ(KeptOf("Remote secure participant eb3dd664:782d8e84:778a9eb0:1c1 not allowed"), "");
  ::testing::internal::CaptureStderr();
  dds_log(DDS_LC_WARNING, __FILE__, __LINE__, "test", "%s\n",
          "Remote secure participant eb3dd664:782d8e84:778a9eb0:1c1 not allowed");
  StandardError().Flush(std::chrono::seconds(5));
  EXPECT_EQ(::testing::internal::GetCapturedStderr(), "");
  EXPECT_THAT(KeptOf("connect_proxy_writer_with_reader (pwr 1:2:3:4) with (rd 5:6:7:8) not allowed "
                     "by security"),
              ::testing::HasSubstr("not allowed"));
}

}  // namespace
}  // namespace tandem
