#include "core/flight/aside/aside.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <utility>

#include "core/flight/bytes/text_fields.h"
#include "core/flight/remarks/because.h"
#include "core/flight/remarks/remark_words.h"

namespace skyquilt::flight {
namespace {

struct AsideFacts {
  Aside why;
  ErrorCode code;
  RemarkCode said;
  std::string_view of;  // the name of that value; beside a camera stands the one that is used instead
};
constexpr AsideFacts kAsides[] = {
    {Aside::kSameBytes, ErrorCode::kConflict, RemarkCode::kLeftSameBytes, "other"},
    {Aside::kPanorama, ErrorCode::kUnprocessable, RemarkCode::kLeftPanorama, "evidence_words"},
    {Aside::kRawPicture, ErrorCode::kUnsupportedFormat, RemarkCode::kLeftRawPicture, "format"},
    {Aside::kThumbnailFirst, ErrorCode::kUnsupportedFormat, RemarkCode::kLeftThumbnailFirst, ""},
    {Aside::kCopy, ErrorCode::kConflict, RemarkCode::kLeftCopy, "other"},
    {Aside::kOlderMetadata, ErrorCode::kConflict, RemarkCode::kLeftOlderMetadata, "other"},
    {Aside::kOtherCamera, ErrorCode::kUnprocessable, RemarkCode::kLeftOtherCamera, "camera"},
    {Aside::kThermal, ErrorCode::kUnprocessable, RemarkCode::kLeftThermal, "camera"},
    {Aside::kVisible, ErrorCode::kUnprocessable, RemarkCode::kLeftVisible, "camera"},
    {Aside::kOtherTags, ErrorCode::kConflict, RemarkCode::kLeftOtherTags, "other"},
    {Aside::kMap, ErrorCode::kUnsupportedFormat, RemarkCode::kLeftMap, ""},
};

const AsideFacts& FactsOf(Aside why) {
  return *std::find_if(std::begin(kAsides), std::end(kAsides),
                       [&](const AsideFacts& facts) { return facts.why == why; });
}

Remark ReasonOf(const AsideFacts& facts, std::string_view of, std::string_view instead) {
  Remark reason = facts.said;
  if (!facts.of.empty()) reason.values.emplace(facts.of, of);
  if (facts.of == "camera") reason.values.emplace("instead", instead);
  return reason;
}

struct SomeLines {
  std::vector<Remark> lines;
  std::size_t more = 0;  // pictures of which none speaks
};

SomeLines FirstLines(const std::vector<LeftOutPhoto>& left_out, std::size_t most) {
  constexpr std::size_t kMaxNamedApart = 3;
  std::map<std::string, std::size_t> all, seen;
  for (const LeftOutPhoto& photo : left_out) ++all[InWords(photo.reason)];
  SomeLines some;
  std::size_t told = 0;
  for (const LeftOutPhoto& photo : left_out) {
    const std::string reason = InWords(photo.reason);
    const std::size_t count = all[reason];
    const bool is_named_apart = count <= kMaxNamedApart;
    if (some.lines.size() == most || (seen[reason]++ > 0 && !is_named_apart)) continue;
    some.lines.push_back(is_named_apart
                             ? Remark(RemarkCode::kOfPhoto, {{"photo", photo.name}, {"said", photo.reason}})
                             : Remark(RemarkCode::kPhotoAndMore,
                                      {{"photo", photo.name}, {"more", count - 1}, {"said", photo.reason}}));
    told += is_named_apart ? 1 : count;
  }
  some.more = left_out.size() - told;
  return some;
}

}  // namespace

Error AsideError(Aside why, std::string_view of, std::string_view instead) {
  const AsideFacts& facts = FactsOf(why);
  return Because(facts.code, ReasonOf(facts, of, instead));
}

LeftOutPhoto LeftAside(const std::string& name, Aside why, std::string_view of, std::string_view instead) {
  const AsideFacts& facts = FactsOf(why);
  return {name, facts.code, ReasonOf(facts, of, instead)};
}

bool LeavesNoGap(const LeftOutPhoto& photo) {
  constexpr std::array kGapless = {
      RemarkCode::kLeftSameBytes, RemarkCode::kLeftCopy,        RemarkCode::kLeftOlderMetadata,
      RemarkCode::kLeftOtherTags, RemarkCode::kLeftOtherCamera, RemarkCode::kLeftThermal,
      RemarkCode::kLeftVisible,   RemarkCode::kLeftPanel,       RemarkCode::kLeftMap};
  return std::find(kGapless.begin(), kGapless.end(), photo.reason.code) != kGapless.end();
}

std::string CameraInWords(const Photo& photo, Lens lens) {
  std::string words = MakeAndModel(photo);
  if (words.find_first_not_of(' ') == std::string::npos) words = "unnamed";
  if (lens == Lens::kWide) words += ", wide";
  if (lens == Lens::kZoom) words += ", zoom";
  if (lens == Lens::kThermal) words += ", thermal";
  const auto [shorter, longer] = std::minmax(photo.intrinsics.width_px, photo.intrinsics.height_px);
  return fmt::format("{}, {} x {} px", words, longer, shorter);
}

std::vector<std::string> LeftOutInLines(const std::vector<LeftOutPhoto>& left_out) {
  constexpr std::size_t kMaxLines = 20;
  const SomeLines some = FirstLines(left_out, kMaxLines);
  std::vector<std::string> lines = InWords(some.lines);
  if (some.more > 0)
    lines.push_back(fmt::format("and {} more picture{}", some.more, some.more == 1 ? "" : "s"));
  return lines;
}

Remark FirstLeftOut(const std::vector<LeftOutPhoto>& left_out) {
  constexpr std::size_t kMaxSentences = 3;
  SomeLines some = FirstLines(left_out, kMaxSentences);
  if (some.more > 0) some.lines.push_back({RemarkCode::kAndMorePictures, {{"pictures", some.more}}});
  return InARow(std::move(some.lines));
}

namespace {

constexpr std::uint16_t kNewSubfileType = 0x00FE, kImageWidth = 0x0100, kImageHeight = 0x0101;
constexpr std::uint16_t kCompression = 0x0103, kPhotometric = 0x0106, kMakeOfTiff = 0x010F, kSubIfds = 0x014A;
constexpr std::uint16_t kDngVersion = 0xC612;
constexpr int kMaxPictures = 16;

double NumberOf(const ExifTable& table, std::uint16_t tag) {
  return table.Number(ExifIfd::kImage, tag).value_or(0.0);
}

bool IsReduced(const ExifTable& table) { return std::fmod(NumberOf(table, kNewSubfileType), 2.0) == 1.0; }

// What a sensor counted behind its colour filters, or what only makers compress so.
bool HoldsSensorLevels(const ExifTable& table) {
  constexpr std::array kPhotometrics = {32803.0, 34892.0};  // colour filter array, linear raw
  // Kodak, Nikon, Sony, Samsung (two), Pentax.
  constexpr std::array kCompressions = {65000.0, 34713.0, 32767.0, 32769.0, 32770.0, 65535.0};
  const auto is_one_of = [](const auto& list, double value) {
    return std::find(list.begin(), list.end(), value) != list.end();
  };
  return is_one_of(kPhotometrics, NumberOf(table, kPhotometric)) ||
         is_one_of(kCompressions, NumberOf(table, kCompression));
}

double PixelsOfTiff(const ExifTable& table) {
  return NumberOf(table, kImageWidth) * NumberOf(table, kImageHeight);
}

}  // namespace

std::string_view RawFormatOf(std::span<const std::uint8_t> head) {
  struct Mark {
    std::size_t at;
    std::string_view bytes, format;
  };
  using namespace std::string_view_literals;
  constexpr std::array kMarks = {
      Mark{0, "FUJIFILMCCD-RAW"sv, "RAF"sv},
      Mark{0, "IIRO"sv, "ORF"sv},
      Mark{0, "IIRS"sv, "ORF"sv},
      Mark{0, "MMOR"sv, "ORF"sv},
      Mark{0, "IIU\0"sv, "RW2"sv},
      Mark{4, "ftypcrx "sv, "CR3"sv},
      Mark{4, "\x10\0\0\0CR\2"sv, "CR2"sv},
      Mark{6, "HEAPCCDR"sv, "CRW"sv},
      Mark{0, "FOVb"sv, "X3F"sv},
      Mark{0, "\0MRM"sv, "MRW"sv},
  };
  const std::string_view text = TextOf(head);
  for (const Mark& mark : kMarks) {
    if (text.size() >= mark.at && text.substr(mark.at).starts_with(mark.bytes)) return mark.format;
  }
  return "";
}

BoxedPicture BoxedPictureOf(std::string_view head) {
  constexpr std::array<std::string_view, 2> kAvif = {"avif", "avis"};
  constexpr std::array<std::string_view, 8> kHeic = {"heic", "heix", "heim", "heis",
                                                     "hevc", "hevx", "mif1", "msf1"};
  constexpr std::size_t kBrand = 8, kOthers = 16, kBrandBytes = 4;
  if (head.size() < kBrand + kBrandBytes || head.substr(4, 4) != "ftyp") return BoxedPicture::kNone;
  const std::string_view brand = head.substr(kBrand, kBrandBytes);
  if (IsOneOf(brand, kAvif)) return BoxedPicture::kAvif;
  if (!IsOneOf(brand, kHeic)) return BoxedPicture::kNone;
  // "mif1" is any picture: what it is of the others say.
  const std::size_t box_bytes = static_cast<std::uint8_t>(head[3]);
  const bool is_short = head[0] == 0 && head[1] == 0 && head[2] == 0;
  const std::size_t end = is_short ? std::min(box_bytes, head.size()) : 0;
  for (std::size_t at = kOthers; brand[0] == 'm' && at + kBrandBytes <= end; at += kBrandBytes) {
    if (IsOneOf(head.substr(at, kBrandBytes), kAvif)) return BoxedPicture::kAvif;
  }
  return BoxedPicture::kHeic;
}

std::optional<Error> WhyRaw(const ExifTable& first, ByteSource& source) {
  if (first.Find(ExifIfd::kImage, kDngVersion)) return AsideError(Aside::kRawPicture, "DNG");
  bool is_raw = HoldsSensorLevels(first);
  bool has_larger = false;
  if (!is_raw && (IsReduced(first) || first.Find(ExifIfd::kImage, kSubIfds))) {
    for (const ExifTable& other : ReadTiffPictures(source, kMaxPictures)) {
      is_raw |= HoldsSensorLevels(other);
      has_larger |= PixelsOfTiff(other) > PixelsOfTiff(first);
    }
  }
  if (is_raw) {
    const std::string make = first.Text(ExifIfd::kImage, kMakeOfTiff);
    return AsideError(Aside::kRawPicture, make.empty() ? "the sensor's own levels" : "of " + make);
  }
  if (IsReduced(first) && has_larger) return AsideError(Aside::kThumbnailFirst, "");
  return std::nullopt;
}

std::optional<Error> WhyMap(const ExifTable& tags) {
  constexpr std::uint16_t kModel = 0x0110, kExposureTime = 0x829A, kFocalLength = 0x920A, kLatitudeOfGps = 2;
  const auto has = [&](ExifIfd ifd, std::uint16_t tag) { return tags.Find(ifd, tag) != nullptr; };
  const bool is_of_camera = has(ExifIfd::kImage, kMakeOfTiff) || has(ExifIfd::kImage, kModel) ||
                            has(ExifIfd::kExif, kExposureTime) || has(ExifIfd::kExif, kFocalLength) ||
                            has(ExifIfd::kGps, kLatitudeOfGps);
  if (is_of_camera || !IsGeoTiff(tags)) return std::nullopt;
  return AsideError(Aside::kMap, "");
}

std::optional<Error> WhyPanorama(int width_px, int height_px, const XmpTags& xmp) {
  const std::string projection = LowerCase(xmp.Text("GPano:ProjectionType"));
  const bool is_plain = projection == "rectilinear" || projection == "perspective";
  if (!projection.empty() && !is_plain)
    return AsideError(Aside::kPanorama, "its XMP says " + projection.substr(0, 40));
  constexpr int kMaxAspect = 3;
  const auto [shorter, longer] = std::minmax(width_px, height_px);
  if (longer > static_cast<std::int64_t>(kMaxAspect) * shorter)
    return AsideError(Aside::kPanorama, "its long side is over three times its short one");
  return std::nullopt;
}

}  // namespace skyquilt::flight
