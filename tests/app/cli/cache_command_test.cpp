#include <filesystem>
#include <fstream>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "app/common/exit_codes.h"
#include "app/common/program_cache.h"
#include "tests/app/cli/program_run.h"

// Tests `tandem cache`, and that programs use what others have kept.

namespace tandem {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using testing::ExpectRefused;
using ::testing::HasSubstr;
using testing::ProgramOutput;
using testing::RunTandem;

class CacheCommand : public ::testing::Test {
 protected:
  ProgramOutput Run(const std::string& arguments, const std::string& more = "") const {
    return RunTandem(arguments,
                     "TANDEM_CACHE=" + (scratch_.path() / "cache").string() + " " + more);
  }
  json Asked(const std::string& what) const {
    return json::parse(Run("cache " + what + " --json").out, nullptr, false);
  }
  void LoadAScene() const {
    const ProgramOutput output = Run("bench memory --scene ball_and_socket");
    ASSERT_EQ(output.exit_code, kExitOk) << output.err;
  }

  ScratchFolder scratch_;
};

TEST_F(CacheCommand, ListsVerifiesAndClearsCachedFiles) {
  EXPECT_EQ(Asked("list")["files"].size(), 0U);
  LoadAScene();
  const json list = Asked("list");
  ASSERT_GE(list["files"].size(), 1U);
  EXPECT_EQ(list["folder"], (scratch_.path() / "cache").string());
  EXPECT_EQ(list["most_bytes"], VoxelCache::kMostBytes);
  EXPECT_GT(list["bytes"], list["files"].size() * VoxelCache::kLeastBytes);
  EXPECT_LT(list["files"][0]["unused_s"], 100);
  EXPECT_THAT(Run("cache list").out, HasSubstr(" MB in "));
  EXPECT_EQ(Asked("verify")["faults"].size(), 0U);
  EXPECT_EQ(Run("cache verify").exit_code, kExitOk);
  EXPECT_EQ(Asked("clear")["removed"], list["files"].size());
  EXPECT_EQ(Asked("list")["files"].size(), 0U);
}

TEST_F(CacheCommand, VerifyNamesDamagedFiles) {
  LoadAScene();
  const std::string file = Asked("list")["files"][0]["file"];
  fs::resize_file(file, fs::file_size(file) - 100);
  const ProgramOutput output = Run("cache verify");
  EXPECT_EQ(output.exit_code, kExitFailed);
  EXPECT_THAT(output.err, HasSubstr(file));
  EXPECT_THAT(output.err, HasSubstr("cut short"));
  EXPECT_EQ(Asked("verify")["faults"][0]["file"], file);
  LoadAScene();
  EXPECT_EQ(Run("cache verify").exit_code, kExitOk);
}

TEST_F(CacheCommand, IsRefusedWithoutACacheFolder) {
  ExpectRefused(RunTandem("cache list", "TANDEM_CACHE= "), kExitFile, "TANDEM_CACHE is empty");
  ExpectRefused(RunTandem("cache", "TANDEM_CACHE= "), kExitUsage, "subcommand");
}

TEST_F(CacheCommand, UsesTheUsersCacheFolder) {
  const std::string home = scratch_.path().string();
  const auto folder = [](const std::string& before) {
    return json::parse(RunTandem("cache list --json", "env -u TANDEM_CACHE " + before).out, nullptr,
                       false)["folder"];
  };
  EXPECT_EQ(folder("-u XDG_CACHE_HOME HOME=" + home + " "), home + "/.cache/tandem");
  EXPECT_EQ(folder("XDG_CACHE_HOME=" + home + " "), home + "/tandem");
}

TEST_F(CacheCommand, TakesItsLimitFromTheEnvironment) {
  const auto most = [&](const std::string& limit) {
    const ProgramOutput output = Run("cache list --json", "TANDEM_CACHE_LIMIT=" + limit + " ");
    return json::parse(output.out, nullptr, false)["most_bytes"].get<std::uint64_t>();
  };
  EXPECT_EQ(most("512M"), 512U << 20U);
  EXPECT_EQ(most("much"), VoxelCache::kMostBytes);
  EXPECT_EQ(BytesOf("17"), 17U);
  EXPECT_EQ(BytesOf("20G"), std::uint64_t{20} << 30U);
  for (const char* text : {"", "G", "-1", "1T", "1 M", "99999999999G"}) {
    EXPECT_EQ(BytesOf(text), std::nullopt) << text;
  }
}

}  // namespace
}  // namespace tandem
