// Tests archives with numbers of 64 bits (ZIP64), as lib3mf writes all of its files.
#include "engine/geometry/formats/package/zip_archive.h"

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>

#include <gtest/gtest.h>

#include "engine/geometry/formats/native_readers.h"
#include "tests/engine/geometry/formats/misread_files.h"

namespace tandem {
namespace {

using testing::Bytes;
using testing::MisreadFiles;
using testing::With;
using testing::Zip;

constexpr std::uint64_t kAllOnes = 0xffffffff;
const std::string kEntry = "PK\x01\x02";
const std::string kEnd = "PK\x05\x06";

/// Numbers of an archive's only entry and of its end record that stand in fields of 64 bits.
struct LongNumbers {
  bool size = true, packed = true, header = true, directory = true;
  std::string before;  // another extra field before that of the long numbers
};

/// Returns an archive of one file, with numbers of 64 bits.
std::string Zip64(const std::string& name, const std::string& content,
                  const LongNumbers& numbers = {}) {
  std::string archive = Zip({{name, content}});
  const std::size_t entry = archive.find(kEntry);
  const std::size_t end = archive.rfind(kEnd);
  std::string directory = archive.substr(entry, end - entry);
  std::string extra;
  const auto move = [&](bool is_long, std::size_t at) {
    if (!is_long) return;
    std::uint64_t number = 0;
    for (std::size_t i = 4; i > 0; --i) {
      number = number << 8U | static_cast<unsigned char>(directory[at + i - 1]);
    }
    extra += Bytes(number, 8);
    directory.replace(at, 4, Bytes(kAllOnes, 4));
  };
  move(numbers.size, 24);
  move(numbers.packed, 20);
  move(numbers.header, 42);
  extra = numbers.before + Bytes(1, 2) + Bytes(extra.size(), 2) + extra;
  directory.replace(30, 2, Bytes(extra.size(), 2));
  directory += extra;
  const std::string begin = archive.substr(0, entry);
  const std::string counts = Bytes(1, 8) + Bytes(1, 8);
  const std::string long_end = "PK\x06\x06" + Bytes(44, 8) + Bytes(45, 2) + Bytes(45, 2) +
                               Bytes(0, 8) + counts + Bytes(directory.size(), 8) +
                               Bytes(begin.size(), 8);
  const std::string locator =
      "PK\x06\x07" + Bytes(0, 4) + Bytes(begin.size() + directory.size(), 8) + Bytes(1, 4);
  const std::uint64_t place = numbers.directory ? kAllOnes : begin.size();
  const std::uint64_t size = numbers.directory ? kAllOnes : directory.size();
  return begin + directory + long_end + locator + kEnd + Bytes(0, 4) + Bytes(1, 2) + Bytes(1, 2) +
         Bytes(size, 4) + Bytes(place, 4) + Bytes(0, 2);
}

class ZipArchiveFiles : public MisreadFiles {
 protected:
  /// Returns the content of file "a" in an archive; nothing: it cannot be had.
  std::optional<std::string> ContentOf(const std::string& archive) {
    const auto opened = ZipArchive::Open(folder_.Write("a.zip", archive));
    if (!opened) return std::nullopt;
    const Result<std::string> content = opened->Read("a", 1000);
    return content ? std::optional(*content) : std::nullopt;
  }
};

TEST_F(ZipArchiveFiles, NumbersOf64BitsAreTakenWhereTheShortOnesAreAllOnes) {
  EXPECT_EQ(ContentOf(Zip64("a", "words")), "words");
  const std::string other = Bytes(0x5455, 2) + Bytes(3, 2) + "abc";
  for (int mask = 0; mask < 16; ++mask) {
    const LongNumbers numbers{(mask & 1) != 0, (mask & 2) != 0, (mask & 4) != 0, (mask & 8) != 0,
                              mask % 3 == 0 ? other : ""};
    EXPECT_EQ(ContentOf(Zip64("a", "words", numbers)), "words") << mask;
  }
}

TEST_F(ZipArchiveFiles, DamagedLongNumbersAreRefused) {
  const std::string good = Zip64("a", "words");
  EXPECT_EQ(ContentOf(With(good, "PK\x06\x07", "PK\x06\x08")), std::nullopt);
  EXPECT_EQ(ContentOf(With(good, "PK\x06\x06", "PK\x06\x08")), std::nullopt);
  EXPECT_EQ(ContentOf(With(good, Bytes(5, 8) + Bytes(5, 8), Bytes(4, 8) + Bytes(5, 8))),
            std::nullopt);
  for (std::size_t at = good.find(kEntry); at < good.size(); ++at) {
    std::string changed = good;
    changed[at] = static_cast<char>(changed[at] ^ 0x7f);
    const auto content = ContentOf(changed);
    if (content) {
      EXPECT_EQ(*content, "words") << at;
    }
  }
}

TEST_F(ZipArchiveFiles, A3mfFileWithLongNumbersIsRead) {
  const std::string model = testing::ThreeMfModel(
      "<resources><object id=\"1\" type=\"model\">" + testing::ThreeMfBox(1, 2, 3) +
      "</object></resources><build><item objectid=\"1\"/></build>");
  ExpectVolume(6, "long.3mf", Zip64("3D/3dmodel.model", model));
}

}  // namespace
}  // namespace tandem
