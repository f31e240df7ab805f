#include "collab/dds/cyclone/cyclone_log.h"

#include <string>

#include <gmock/gmock.h>

#include "collab/dds/cyclone/dds_api.h"
#include "engine/base/files/regular_file.h"

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
  EXPECT_THAT(in_plain_words, ::testing::StartsWith("a damaged or hostile packet was dropped ("));
}

TEST(CycloneLog, MessageLengthIsBounded) {
  EXPECT_LT(KeptOf("writer " + std::string(10'000, 'x')).size(), 500U);
}

}  // namespace
}  // namespace tandem
