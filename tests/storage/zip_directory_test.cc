#include "storage/uploads/zip_directory.h"

#include <gtest/gtest.h>

#include <cstdint>
#include <fstream>
#include <string>

#include "tests/support/temporary_folder.h"

namespace skyquilt::storage {
namespace {

void Put(std::string& bytes, std::uint64_t value, int size) {
  for (int i = 0; i < size; ++i) bytes.push_back(static_cast<char>(value >> (8 * i)));
}

// A directory of `entries` behind `before` bytes of files, and an end that says what it is told to say.
std::string Zip(int entries, std::size_t before, std::uint64_t says_at, std::uint64_t says_bytes,
                bool is_64 = false) {
  std::string bytes(before, 'x');
  for (int i = 0; i < entries; ++i) bytes += std::string("PK\1\2", 4) + std::string(42, '\0') + "a";
  const std::uint64_t end64_at = bytes.size();
  if (is_64) {
    bytes += std::string("PK\6\6", 4) + std::string(44, '\0');
    Put(bytes, says_at, 8);
    bytes += std::string("PK\6\7", 4) + std::string(4, '\0');
    Put(bytes, end64_at, 8);
    Put(bytes, 1, 4);
  }
  bytes += std::string("PK\5\6", 4) + std::string(8, '\0');
  Put(bytes, is_64 ? 0xFFFFFFFF : says_bytes, 4);
  Put(bytes, is_64 ? 0xFFFFFFFF : says_at, 4);
  Put(bytes, 0, 2);
  return bytes;
}

int Count(const std::string& bytes, int most) {
  const test::TemporaryFolder folder;
  const auto path = folder.path() / "a.zip";
  std::ofstream(path, std::ios::binary) << bytes;
  return CountZipEntries(path, most);
}

TEST(CountZipEntries, CountsUpToOneBeyondTheMost) {
  EXPECT_EQ(Count(Zip(0, 10, 10, 0), 100), 0);
  EXPECT_EQ(Count(Zip(7, 1000, 1000, 7 * 47), 100), 7);
  EXPECT_EQ(Count(Zip(100, 1000, 1000, 100 * 47), 100), 100);
  EXPECT_EQ(Count(Zip(20'000, 1000, 1000, 20'000 * 47), 100), 101);
  EXPECT_EQ(Count(Zip(20'000, 300'000, 300'000, 0, true), 19'000), 19'001);
  EXPECT_EQ(Count(Zip(20'000, 300'000, 300'000, 0, true), 30'000), 20'000);
}

TEST(CountZipEntries, IsNotToldLies) {
  EXPECT_EQ(Count(Zip(500, 1000, 1000 + 490 * 47, 500 * 47), 100), 101);  // begins later
  EXPECT_EQ(Count(Zip(500, 1000, 1000, 47), 100), 101);                   // is shorter
}

TEST(CountZipEntries, OfWhatIsNoZipIsNothing) {
  EXPECT_EQ(Count("", 100), 0);
  EXPECT_EQ(Count(std::string(100'000, 'P'), 100), 0);
  EXPECT_EQ(Count(std::string("PK\5\6", 4), 100), 0);
  EXPECT_EQ(CountZipEntries("/nonexistent/a.zip", 100), 0);
}

}  // namespace
}  // namespace skyquilt::storage
