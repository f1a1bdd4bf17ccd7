#include "storage/pmtiles/pmtiles_archive.h"

#include <gtest/gtest.h>

#include <random>

namespace skyquilt::storage {
namespace {

std::string Varint(std::uint64_t value) {
  std::string bytes;
  for (; value >= 0x80; value >>= 7) bytes += static_cast<char>((value & 0x7f) | 0x80);
  return bytes + static_cast<char>(value);
}

std::string Packed(std::initializer_list<std::uint64_t> numbers) {
  std::string plain;
  for (const std::uint64_t number : numbers) plain += Varint(number);
  return Gzip(plain);
}

TEST(ParsePmtilesDirectory, ReadsWhatTheWriterWrites) {
  std::vector<PmtilesEntry> entries;
  std::mt19937 random(1);
  std::uint64_t tile = 5, offset = 0;
  for (int i = 0; i < 500; ++i) {
    const auto length = static_cast<std::uint32_t>(1 + random() % 50'000);
    entries.push_back({tile, offset, length, static_cast<std::uint32_t>(1 + random() % 3)});
    tile += entries.back().run + random() % 10;
    offset += random() % 4 == 0 ? length + 7 : length;
  }
  const auto read = ParsePmtilesDirectory(MakePmtilesDirectories(entries).root);
  ASSERT_TRUE(read) << read.error().detail;
  ASSERT_EQ(read->size(), entries.size());
  for (std::size_t i = 0; i < entries.size(); ++i) {
    EXPECT_EQ((*read)[i].tile, entries[i].tile);
    EXPECT_EQ((*read)[i].offset, entries[i].offset);
    EXPECT_EQ((*read)[i].length, entries[i].length);
    EXPECT_EQ((*read)[i].run, entries[i].run);
  }
}

TEST(ParsePmtilesDirectory, RefusesWhatIsNone) {
  constexpr std::uint64_t kHuge = std::uint64_t{1} << 63;
  for (const std::string& bad :
       {std::string(), std::string("not packed"), Gzip(""), Packed({0}), Packed({2, 1, 0, 1, 1, 5, 5, 1, 0}),
        Packed({kHuge, 1, 1, 1, 1}), Packed({1, 1, 1, 5}), Packed({1, 1, 1, 0, 1}), Packed({1, 1, 1, 5, 0}),
        Packed({1, 1, kHuge, 5, 1}), Packed({1, 1, 1, kHuge, 1}), Packed({1, 1, 1, 5, kHuge}),
        Packed({2, kHuge, kHuge, 1, 1, 5, 5, 1, 0}), Packed({1, 1, 1, 5, 1}).substr(0, 15),
        Packed({1, 1, 0, std::uint64_t{1} << 30, 1}), Gzip(std::string(11, '\xff')),
        Gzip(std::string(std::size_t{40} << 20, '\1'))}) {
    EXPECT_FALSE(ParsePmtilesDirectory(bad)) << bad.size();
  }
  EXPECT_TRUE(ParsePmtilesDirectory(Packed({1, 1, 1, 5, 1})));
}

TEST(FindPmtilesEntry, FindsRunsAndLeaves) {
  const std::vector<PmtilesEntry> entries = {{5, 0, 10, 3}, {10, 10, 10, 1}, {20, 0, 99, 0}};
  EXPECT_FALSE(FindPmtilesEntry(entries, 4));
  EXPECT_EQ(FindPmtilesEntry(entries, 7)->tile, 5U);
  EXPECT_FALSE(FindPmtilesEntry(entries, 8));
  EXPECT_FALSE(FindPmtilesEntry(entries, 11));
  EXPECT_EQ(FindPmtilesEntry(entries, 1'000)->tile, 20U);  // in the leaf, if it is anywhere
  EXPECT_FALSE(FindPmtilesEntry({}, 1));
}

TEST(ParsePmtilesHeader, RefusesWhatIsNone) {
  EXPECT_FALSE(ParsePmtilesHeader(""));
  EXPECT_FALSE(ParsePmtilesHeader("PMTiles"));
  EXPECT_FALSE(ParsePmtilesHeader("PMTiles\3" + std::string(119, '\xff')));
  EXPECT_FALSE(ParsePmtilesHeader("PMTiles\2" + std::string(119, '\1')));
  EXPECT_FALSE(ParsePmtilesHeader(std::string(127, '\0')));
}

}  // namespace
}  // namespace skyquilt::storage
