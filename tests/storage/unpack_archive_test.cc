#include "storage/uploads/unpack_archive.h"

#include <gtest/gtest.h>

#include <fstream>

#include "storage/db/ids.h"
#include "tests/support/temporary_folder.h"
#include "tests/support/value_of.h"

namespace skyquilt::storage {
namespace {

using namespace std::string_literals;

// A zip of a.jpg, which holds "abc", compressed by LZMA (method 14) with a dictionary of a size of one's
// choice.
std::string LzmaZip(std::string_view dictionary_bytes) {
  const std::string file =
      "PK\x03\x04\x3f\0\x02\0\x0e\0\0\0\x21\x58\xc2\x41\x24\x35\x16\0\0\0\x03\0\0\0\x05\0\0\0a.jpg"
      "\x09\x04\x05\0\x5d"s +
      std::string(dictionary_bytes) + "\0\x30\x98\x88\xa4\x4a\x8e\x9f\xff\xf6\x63\x80\0"s;
  const std::string directory =
      "PK\x01\x02\x3f\x03\x3f\0\x02\0\x0e\0\0\0\x21\x58\xc2\x41\x24\x35\x16\0\0\0\x03\0\0\0\x05\0\0\0\0\0\0\0\0\0\0\0"
      "\x80\x01\0\0\0\0a.jpg"s;
  return file + directory + "PK\x05\x06\0\0\0\0\x01\0\x01\0\x33\0\0\0\x39\0\0\0\0\0"s;
}

std::string StoredZip() {
  const std::string file =
      "PK\x03\x04\x14\0\0\0\0\0\0\0\x21\x58\xc2\x41\x24\x35\x03\0\0\0\x03\0\0\0\x05\0\0\0a.jpgabc"s;
  const std::string directory =
      "PK\x01\x02\x14\x03\x14\0\0\0\0\0\0\0\x21\x58\xc2\x41\x24\x35\x03\0\0\0\x03\0\0\0\x05\0\0\0\0\0\0\0\0\0\0\0"
      "\x80\x01\0\0\0\0a.jpg"s;
  return file + directory + "PK\x05\x06\0\0\0\0\x01\0\x01\0\x33\0\0\0\x26\0\0\0\0\0"s;
}

std::string Octal(std::size_t number, std::size_t digits) {
  std::string text;
  for (; digits > 0; --digits, number /= 8) text.insert(0, 1, static_cast<char>('0' + number % 8));
  return text;
}

// A tar of files that hold their own names.
std::string TarOf(const std::vector<std::string>& names) {
  std::string tar;
  for (const std::string& name : names) {
    std::string header(512, '\0');
    const auto put = [&](std::size_t at, const std::string& text) { header.replace(at, text.size(), text); };
    put(0, name);
    put(100, "0000644");
    put(124, Octal(name.size(), 11));
    put(136, "00000000000");
    put(148, "        ");  // the sum counts itself as blanks
    put(156, "0");
    put(257, "ustar"s + '\0' + "00");
    std::size_t sum = 0;
    for (const unsigned char byte : header) sum += byte;
    put(148, Octal(sum, 6) + '\0');
    tar += header + name + std::string(512 - name.size(), '\0');
  }
  return tar + std::string(1024, '\0');
}

class UnpackArchiveTest : public testing::Test {
 protected:
  Result<std::vector<UnpackedFile>> Unpack(const std::string& archive) {
    const std::filesystem::path path = scratch_.path() / "archive";
    std::ofstream(path, std::ios::binary) << archive;
    return UnpackArchive(store_, flight_, path, {});
  }

  const test::TemporaryFolder scratch_;
  const PhotoStore store_{*DataDir::Open(scratch_.path())};
  const std::string flight_ = NewId();
};

TEST_F(UnpackArchiveTest, TakesFilesAsTheyAre) {
  const auto files = test::ValueOf(Unpack(StoredZip()));
  ASSERT_EQ(files.size(), 1U);
  EXPECT_FALSE(files.front().error);
  EXPECT_EQ(files.front().file.name, "a.jpg");
  EXPECT_EQ(files.front().file.bytes, 3);
}

// A zip of Python's, or of Windows: every name with a letter beyond ASCII is marked as UTF-8.
TEST_F(UnpackArchiveTest, TakesFilesBelowFoldersOfAnyLetters) {
  std::string zip = StoredZip();
  const std::string name = "\xc3\xbc/a.jpg";
  for (const std::size_t at : {zip.rfind("a.jpg"), zip.find("a.jpg")}) zip.replace(at, 5, name);
  const std::size_t directory = zip.find("PK\x01\x02"), end = zip.find("PK\x05\x06");
  zip[7] = zip[directory + 9] = '\x08';
  zip[26] = zip[directory + 28] = static_cast<char>(name.size());
  zip[end + 12] = static_cast<char>(end - directory);
  zip[end + 16] = static_cast<char>(directory);
  const auto files = test::ValueOf(Unpack(zip));
  ASSERT_EQ(files.size(), 1U);
  EXPECT_FALSE(files.front().error) << files.front().error->message;
  EXPECT_EQ(files.front().file.name, "a.jpg");
}

TEST_F(UnpackArchiveTest, KeepsTheFoldersOfFilesOfOneName) {
  const auto files =
      Unpack(TarOf({"./DCIM/100MEDIA/DJI_0001.JPG", "./DCIM/101MEDIA/DJI_0001.JPG",
                    "./DCIM/101MEDIA/positions.csv", "./DCIM/DJI_0002.JPG", "../DJI_0002.JPG"}));
  ASSERT_TRUE(files) << files.error().message << files.error().detail;
  std::vector<std::string> names;
  for (const UnpackedFile& file : *files) names.push_back(file.file.name);
  EXPECT_EQ(names, (std::vector<std::string>{"100MEDIA_DJI_0001.JPG", "101MEDIA_DJI_0001.JPG",
                                             "101MEDIA_positions.csv", "DJI_0002.JPG", "DJI_0002.JPG"}));
  EXPECT_TRUE(files->back().error) << "it counts for nothing";
}

TEST(ArchiveLimits, LetAFileBeAsLargeAsOneThatComesAlone) {
  EXPECT_EQ(ArchiveLimits().file_bytes, kMaxFileBytes) << "films of a card that was packed whole";
}

// libarchive would take it as "a", whatever it goes on with.
TEST_F(UnpackArchiveTest, RefusesNamesWithANul) {
  const std::string zip = StoredZip();
  const std::size_t before_file = zip.find("a.jpg");
  for (const std::size_t at : {before_file, zip.find("a.jpg", before_file + 1)}) {
    std::string with_nul = zip;
    with_nul[at + 1] = '\0';
    const auto files = Unpack(with_nul);
    ASSERT_FALSE(files) << at;
    EXPECT_EQ(files.error().code, ErrorCode::kUnprocessable);
    EXPECT_NE(files.error().message.find("NUL"), std::string::npos) << files.error().message;
  }
}

// Such an entry takes what memory it asks for before a byte of it is out: here 8 MiB, and more than three
// gigabytes.
TEST_F(UnpackArchiveTest, RefusesZipsThatAskForMemory) {
  for (const std::string& dictionary : {"\0\0\x80\0"s, "\0\0\0\xc1"s}) {
    const Error files = test::ErrorOf(Unpack(LzmaZip(dictionary)));
    EXPECT_EQ(files.code, ErrorCode::kUnprocessable);
    EXPECT_NE(files.message.find("a.jpg"), std::string::npos) << files.message;
    EXPECT_NE(files.message.find("deflate"), std::string::npos) << files.message;
  }
}

}  // namespace
}  // namespace skyquilt::storage
