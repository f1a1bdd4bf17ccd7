// What readers of photos take of files that were made to cost: counted, not timed.
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <zlib.h>

#include <numeric>
#include <tuple>

#include "core/flight/lists/file_kinds.h"
#include "core/flight/lists/sort_files.h"
#include "core/flight/metadata/xmp.h"
#include "core/flight/photos/image_header.h"
#include "core/flight/photos/jpeg_segments.h"
#include "core/flight/photos/png_profile.h"
#include "tests/core/flight/synthetic_photo.h"
#include "tests/support/temporary_folder.h"
#include "tests/support/value_of.h"

namespace skyquilt::flight {
namespace {

// Counts what is asked of it.
class CountingBytes final : public ByteSource {
 public:
  explicit CountingBytes(std::span<const std::uint8_t> bytes, std::uint64_t zeros_behind = 0)
      : bytes_(bytes), zeros_behind_(zeros_behind) {}
  std::uint64_t size() const override { return bytes_.size() + zeros_behind_; }
  bool Read(std::uint64_t offset, std::span<std::uint8_t> into) override {
    ++reads;
    bytes_read += into.size();
    if (offset > size() || into.size() > size() - offset) return false;
    for (std::size_t i = 0; i < into.size(); ++i) {
      const std::uint64_t at = offset + i;
      into[i] = at < bytes_.size() ? bytes_[static_cast<std::size_t>(at)] : 0;
    }
    return true;
  }
  std::uint64_t reads = 0;
  std::uint64_t bytes_read = 0;

 private:
  std::span<const std::uint8_t> bytes_;
  std::uint64_t zeros_behind_;
};

void Put(Bytes& bytes, std::string_view text) { bytes.insert(bytes.end(), text.begin(), text.end()); }
void Put16(Bytes& bytes, std::uint32_t value) {
  for (const int shift : {0, 8}) bytes.push_back(static_cast<std::uint8_t>(value >> shift));
}
void Put32(Bytes& bytes, std::uint32_t value) {
  Put16(bytes, value & 0xFFFF);
  Put16(bytes, value >> 16);
}
void PutBig32(Bytes& bytes, std::uint32_t value) {
  for (const int shift : {24, 16, 8, 0}) bytes.push_back(static_cast<std::uint8_t>(value >> shift));
}

// `entries` tags that all share one value of `bytes` bytes.
Bytes SharingExif(std::uint32_t entries, std::uint32_t bytes) {
  Bytes exif;
  Put(exif, std::string_view("II*\0\x08\0\0\0", 8));
  Put16(exif, entries);
  const std::uint32_t value_at = 8 + 2 + 12 * entries + 4;
  for (std::uint32_t i = 0; i < entries; ++i) {
    Put16(exif, 0x8770 + i);  // none of the pointers
    Put16(exif, static_cast<std::uint32_t>(ExifType::kUndefined));
    Put32(exif, bytes);
    Put32(exif, value_at);
  }
  Put32(exif, 0);
  exif.resize(value_at + bytes);
  return exif;
}

std::size_t BytesOf(const ExifTable& table) {
  return std::accumulate(table.values().begin(), table.values().end(), std::size_t{0},
                         [](std::size_t sum, const auto& value) { return sum + value.second.bytes.size(); });
}

std::string Attributes(int count) {
  std::string attributes;
  for (int i = 0; i < count; ++i) attributes += "a" + std::to_string(i) + "=\"1\" ";
  return attributes;
}

TEST(ExifSegment, EntriesThatShareTheirValueMakeNoMoreOfIt) {
  EXPECT_EQ(BytesOf(ReadExifSegment(SharingExif(100, 60'000))), 100U * 60'000U);
  const ExifTable many = ReadExifSegment(SharingExif(1000, 50'000));
  EXPECT_GT(BytesOf(many), std::size_t{7} << 20);
  EXPECT_LE(BytesOf(many), std::size_t{8} << 20);
  EXPECT_EQ(BytesOf(ReadExifSegment(SharingExif(2000, 30'000))), 0U);
}

TEST(XmpTags, TakesOnlySoManyAttributesOfAnElement) {
  XmpTags plenty;
  EXPECT_TRUE(plenty.AddPacket(XmpPacket(kDjiNamespace + Attributes(300))));
  EXPECT_GE(plenty.values().size(), 300U);
  XmpTags too_many;
  EXPECT_FALSE(too_many.AddPacket(XmpPacket(kDjiNamespace + Attributes(500))));
  // Nothing in a comment or in CDATA hides them from being counted.
  for (const char* hiding : {"<!-- ' -->", "<!-- \" -->", "<![CDATA[ ' ]]>", "<?x ' ?>"}) {
    XmpTags hidden;
    EXPECT_FALSE(
        hidden.AddPacket(XmpPacket(kDjiNamespace, std::string(hiding) + "<e " + Attributes(500) + "/>")))
        << hiding;
  }
  // And they may stand in a value.
  XmpTags quoted;
  EXPECT_TRUE(quoted.AddPacket(XmpPacket(
      kDjiNamespace + ("drone-dji:Note=\"" + std::string(1000, '=') + "\" drone-dji:Model='<b c=\"1\">'"))));
  EXPECT_EQ(quoted.Text("drone-dji:Note"), std::string(1000, '='));
}

TEST(XmpTags, TakesOnlySoManyElementsAndBytes) {
  const auto elements = [](int count) {
    std::string text;
    for (int i = 0; i < count; ++i) text += "<e/>";
    return text;
  };
  XmpTags tags;
  EXPECT_TRUE(tags.AddPacket(XmpPacket(kDjiNamespace, elements(10'000))));
  EXPECT_FALSE(tags.AddPacket(XmpPacket(kDjiNamespace, elements(21'000))));
  EXPECT_FALSE(tags.AddPacket(XmpPacket(kDjiNamespace, "<e>" + std::string(2 << 20, 'x') + "</e>")));
}

TEST(XmpTags, LongNamesOfStructuresAreNotCopiedForEachField) {
  std::string fields;
  for (int i = 0; i < 1000; ++i) fields += "<f" + std::to_string(i) + ">1</f" + std::to_string(i) + ">";
  const std::string name(1000, 'n');
  XmpTags tags;
  EXPECT_TRUE(
      tags.AddPacket(XmpPacket(kDjiNamespace, "<" + name + ">" + fields + "</" + name + "><g>2</g>")));
  EXPECT_EQ(tags.Text("g"), "2");
  EXPECT_LE(tags.values().size(), 2U);
}

TEST(JpegSegments, StrayBytesAndPaddingEndSoon) {
  for (const std::uint8_t fill : {std::uint8_t{0x00}, std::uint8_t{0xFF}}) {
    Bytes bytes = {0xFF, 0xD8};
    for (int segment = 0; segment < 20; ++segment) {
      bytes.insert(bytes.end(), 40'000, fill);
      Put(bytes, std::string_view("\xFF\xE5\0\x02", 4));
    }
    CountingBytes source(bytes);
    EXPECT_FALSE(ScanJpegSegments(source));
    EXPECT_LT(source.reads, 70'000U);
  }
}

TEST(JpegSegments, TheEndIsLookedForWhereItCanBe) {
  const Bytes bytes = {0xFF, 0xD8, 0xFF, 0xD9};
  CountingBytes near(bytes, 1 << 20);
  EXPECT_TRUE(HasEndOfImage(near, 0));
  CountingBytes far(bytes, std::uint64_t{100} << 20);
  EXPECT_FALSE(HasEndOfImage(far, 0));
  EXPECT_LT(far.bytes_read, std::uint64_t{65} << 20);
}

// The text chunk in which ImageMagick keeps EXIF.
Bytes ProfileChunk(const Bytes& exif, bool is_compressed) {
  std::string text = fmt::format("\nexif\n    {}\n", exif.size() + 6);
  std::string bytes("Exif\0\0", 6);
  bytes.append(exif.begin(), exif.end());
  for (std::size_t i = 0; i < bytes.size(); ++i)
    text += fmt::format("{:02x}{}", static_cast<std::uint8_t>(bytes[i]), i % 36 == 35 ? "\n" : "");
  Bytes chunk;
  Put(chunk, std::string_view("Raw profile type exif\0", 22));
  if (!is_compressed) {
    Put(chunk, text);
    return chunk;
  }
  chunk.push_back(0);
  Bytes packed(compressBound(text.size()));
  uLongf size = packed.size();
  EXPECT_EQ(compress(packed.data(), &size, reinterpret_cast<const Bytef*>(text.data()), text.size()), Z_OK);
  chunk.insert(chunk.end(), packed.begin(), packed.begin() + static_cast<std::ptrdiff_t>(size));
  return chunk;
}

TEST(PngProfile, HasTheExifThatImageMagickKeeps) {
  const Bytes exif = ExifWriter().Ascii(ExifIfd::kImage, 0x010F, "DJI").Write();
  for (const bool is_compressed : {true, false}) {
    const Bytes chunk = ProfileChunk(exif, is_compressed);
    ASSERT_TRUE(IsPngProfile(chunk));
    EXPECT_EQ(ReadPngProfile(chunk, is_compressed).exif, exif);
    // Cut off anywhere.
    for (std::size_t size = 0; size < chunk.size(); ++size)
      EXPECT_LE(ReadPngProfile(std::span(chunk).first(size), is_compressed).exif.size(), exif.size());
  }
  // What would be larger than anything that cameras write.
  EXPECT_TRUE(ReadPngProfile(ProfileChunk(Bytes(200'000, 0), true), true).exif.empty());
}

TEST(PngHeader, OneExifAndFewPacketsAreRead) {
  Bytes png;
  Put(png, std::string_view("\x89PNG\r\n\x1A\n", 8));
  const auto chunk = [&](std::string_view type, const Bytes& body) {
    PutBig32(png, static_cast<std::uint32_t>(body.size()));
    Put(png, type);
    png.insert(png.end(), body.begin(), body.end());
    PutBig32(png, 0);
  };
  Bytes size;
  PutBig32(size, 4000);
  PutBig32(size, 3000);
  size.resize(13);
  chunk("IHDR", size);
  const Bytes exif = SharingExif(1000, 50'000);
  for (int i = 0; i < 20; ++i) chunk("eXIf", exif);
  Bytes text;
  Put(text, std::string_view("XML:com.adobe.xmp\0\0\0\0\0", 22));
  text.resize(60'000, ' ');
  for (int i = 0; i < 20; ++i) chunk("iTXt", text);
  chunk("IEND", {});
  CountingBytes source(png);
  EXPECT_LE(test::ValueOf(ReadImageHeader(source)).xmp_packets.size(), 4U);
  EXPECT_LT(source.bytes_read, 500'000U);
}

TEST(TiffDirectories, ChainsAreCountedOnlySoFar) {
  const auto chain = [](std::uint32_t length, bool closes) {
    Bytes tiff;
    Put(tiff, std::string_view("II*\0", 4));
    Put32(tiff, 8);
    for (std::uint32_t i = 0; i < length; ++i) {
      Put16(tiff, 1);
      tiff.resize(tiff.size() + 12);
      const bool is_last = i + 1 == length;
      Put32(tiff, !is_last ? 8 + 18 * (i + 1) : closes ? 8 : 0);
    }
    return tiff;
  };
  for (const auto& [length, closes, count] :
       {std::tuple{3U, false, 3}, {64U, false, 64}, {65U, false, 65}, {60'000U, false, 65}, {2U, true, 65}}) {
    const Bytes tiff = chain(length, closes);
    CountingBytes source(tiff);
    EXPECT_EQ(test::ValueOf(CountTiffDirectories(source, 64)), count);
    EXPECT_LT(source.reads, 200U);
  }
  const test::TemporaryFolder folder;
  for (const std::uint32_t length : {10U, 1000U})
    EXPECT_EQ(CheckTiffDirectories(folder.Write("chain.tif", chain(length, false))).ok(), length < 64);
}

TEST(FindDuplicates, FilesThatAreAlikeAtFirstAreToldApart) {
  const test::TemporaryFolder folder;
  std::vector<InputFile> files;
  for (int i = 0; i < 40; ++i) {
    const std::string content = std::string(70'000, 'x') + static_cast<char>('a' + i % 20);
    files.push_back({std::to_string(i), folder.Write(std::to_string(i), content)});
  }
  const auto duplicate_of = FindDuplicates(files);
  for (std::size_t i = 0; i < 20; ++i) {
    EXPECT_FALSE(duplicate_of[i]);
    EXPECT_EQ(duplicate_of[i + 20], i);
  }
}

}  // namespace
}  // namespace skyquilt::flight
