#include "app/common/poses_file.h"

#include <string>

#include <gmock/gmock.h>

#include "tests/support/scratch_folder.h"

namespace tandem {
namespace {

using ::testing::HasSubstr;

constexpr const char* kHeader = "fixed,moving,kind,tx,ty,tz,ax,ay,az,angle_deg\n";

std::string ErrorOfPoses(const std::string& line) {
  const ScratchFolder folder;
  const auto file = folder.Write("p.csv", kHeader + line + "\n");
  const Result<std::vector<FilePose>> poses = ReadPosesFile(file);
  if (poses) return "";
  const std::string start = file.string();
  EXPECT_EQ(poses.error().what.substr(0, start.size()), start);
  return poses.error().what.substr(start.size());
}

TEST(PosesFile, IsReadInFull) {
  const ScratchFolder folder;
  const auto file =
      folder.Write("p.csv", std::string(kHeader) + "a,b\xC3\xA9,near,1,2,3,0,0,2,90\r\n");
  const Result<std::vector<FilePose>> poses = ReadPosesFile(file);
  ASSERT_TRUE(poses) << poses.error().what;
  ASSERT_EQ(poses->size(), 1U);
  EXPECT_EQ(poses->at(0).fixed, "a");
  EXPECT_EQ(poses->at(0).moving, "b\xC3\xA9");
  EXPECT_EQ(poses->at(0).kind, "near");
  EXPECT_EQ(poses->at(0).X_WM.p, Vec3(1, 2, 3));
  EXPECT_NEAR(RotationVector(poses->at(0).X_WM.q).z(), 0.5 * M_PI, 1e-12);
}

TEST(PosesFile, DuplicateColumnIsRefused) {
  const ScratchFolder folder;
  const auto error = [&](const std::string& header) {
    const auto file = folder.Write("p.csv", header + "\na,b,k,1,2,3,0,0,2,90,9\n");
    const Result<std::vector<FilePose>> poses = ReadPosesFile(file);
    return poses ? "" : poses.error().what.substr(file.string().size());
  };
  EXPECT_EQ(error("fixed,moving,kind,tx,ty,tz,ax,ay,az,angle_deg,tx"),
            ":1: has the column tx twice: leave one of them out");
  EXPECT_EQ(error("fixed,moving,kind,tx,ty,tz,ax,ay,az,angle_deg,kind"),
            ":1: has the column kind twice: leave one of them out");
  EXPECT_EQ(error("fixed,moving,kind,tx,ty,tz,ax,ay,az,angle_deg,"), "");
  const std::string without_names = "fixed,moving,,tx,ty,tz,ax,ay,az,angle_deg,";
  EXPECT_EQ(error(without_names), "") << "nobody reads columns without a name";
}

TEST(PosesFile, TerminalControlsAreRefusedWithTheirPosition) {
  EXPECT_EQ(ErrorOfPoses("a,b\x1b[31m,k,0,0,0,0,0,1,0"),
            ":2: moving: expected plain text of at most 256 bytes, got \"b?[31m\"");
  EXPECT_THAT(ErrorOfPoses("a\xE2\x80\xAE,b,k,0,0,0,0,0,1,0"), HasSubstr(":2: fixed: expected"));
  EXPECT_THAT(ErrorOfPoses("a,b,\xff,0,0,0,0,0,1,0"), HasSubstr(":2: kind: expected"));
  EXPECT_THAT(ErrorOfPoses("a," + std::string(257, 'b') + ",k,0,0,0,0,0,1,0"),
              HasSubstr(":2: moving: expected"));
  EXPECT_EQ(ErrorOfPoses("a," + std::string(256, 'b') + ",k,0,0,0,0,0,1,0"), "");
}

TEST(PosesFile, ImplausibleNumbersAreRefused) {
  EXPECT_EQ(ErrorOfPoses("a,b,k,0,1e300,0,0,0,1,0"),
            ":2: ty: expected a number from -1e9 to 1e9, got \"1e300\"");
  EXPECT_THAT(ErrorOfPoses("a,b,k,0,0,0,0,0,1,1e300"), HasSubstr(":2: angle_deg: expected"));
  EXPECT_EQ(ErrorOfPoses("a,b,k,0,0,0,0,1e200,0,10"),
            ":2: the rotation axis must have a length from 1e-9 to 1e9");
  EXPECT_THAT(ErrorOfPoses("a,b,k,0,0,0,0,0,0,10"), HasSubstr(":2: the rotation axis"));
  EXPECT_EQ(ErrorOfPoses("a,b,k,0,0,0,0,0,0,0"), "");
}

// 'tandem replay --export FILE.csv' writes such a file
TEST(PosesFile, PosesOfASceneHaveTimesAndNoFixedPart) {
  const ScratchFolder folder;
  const auto file =
      folder.Write("p.csv", "t_s,moving,tx,ty,tz,ax,ay,az,angle_deg\n0.010,'=cmd,1,2,3,0,0,1,0\n");
  const Result<std::vector<FilePose>> poses = ReadPosesFile(file);
  ASSERT_TRUE(poses) << poses.error().what;
  ASSERT_EQ(poses->size(), 1U);
  EXPECT_EQ(poses->at(0).fixed, "");
  EXPECT_EQ(poses->at(0).moving, "=cmd") << "CSV has a ' before what a spreadsheet would run";
  EXPECT_EQ(poses->at(0).t_s, 0.01);
  EXPECT_EQ(SecondsText(0.01), "0.010");
  EXPECT_EQ(SecondsText(12.3456784), "12.345678");
}

}  // namespace
}  // namespace tandem
