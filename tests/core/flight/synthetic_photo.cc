#include "tests/core/flight/synthetic_photo.h"

#include <bit>
#include <cmath>

namespace skyquilt::flight {
namespace {

constexpr std::uint16_t kExifPointer = 0x8769;
constexpr std::uint16_t kGpsPointer = 0x8825;

void Put(Bytes& out, std::uint64_t value, int size, bool is_big_endian) {
  for (int i = 0; i < size; ++i) {
    const int shift = 8 * (is_big_endian ? size - 1 - i : i);
    out.push_back(static_cast<std::uint8_t>(value >> shift));
  }
}

void PutSegment(Bytes& jpeg, int marker, const Bytes& payload) {
  jpeg.push_back(0xFF);
  jpeg.push_back(static_cast<std::uint8_t>(marker));
  Put(jpeg, payload.size() + 2, 2, true);
  jpeg.insert(jpeg.end(), payload.begin(), payload.end());
}

Bytes Joined(const std::string& head, const Bytes& tail) {
  Bytes bytes(head.begin(), head.end());
  bytes.insert(bytes.end(), tail.begin(), tail.end());
  return bytes;
}

std::vector<std::pair<std::uint32_t, std::uint32_t>> Dms(double degrees) {
  degrees = std::abs(degrees);
  const auto units = static_cast<std::uint64_t>(std::llround(degrees * 3600.0 * 10000.0));
  const std::uint64_t per_minute = 600000;
  return {{static_cast<std::uint32_t>(units / (60 * per_minute)), 1},
          {static_cast<std::uint32_t>(units / per_minute % 60), 1},
          {static_cast<std::uint32_t>(units % per_minute), 10000}};
}

}  // namespace

ExifWriter& ExifWriter::Ascii(ExifIfd ifd, std::uint16_t tag, const std::string& text) {
  Bytes bytes(text.begin(), text.end());
  bytes.push_back(0);
  entries_[ifd][tag] = {ExifType::kAscii, static_cast<std::uint32_t>(bytes.size()), {}, bytes};
  return *this;
}

ExifWriter& ExifWriter::Rational(ExifIfd ifd, std::uint16_t tag,
                                 std::vector<std::pair<std::uint32_t, std::uint32_t>> values) {
  Entry entry{ExifType::kRational, static_cast<std::uint32_t>(values.size()), {}, {}};
  for (const auto& [numerator, denominator] : values) {
    entry.numbers.push_back(numerator);
    entry.numbers.push_back(denominator);
  }
  entries_[ifd][tag] = entry;
  return *this;
}

ExifWriter& ExifWriter::Short(ExifIfd ifd, std::uint16_t tag, std::uint16_t value) {
  entries_[ifd][tag] = {ExifType::kShort, 1, {value}, {}};
  return *this;
}

ExifWriter& ExifWriter::Long(ExifIfd ifd, std::uint16_t tag, std::uint32_t value) {
  entries_[ifd][tag] = {ExifType::kLong, 1, {value}, {}};
  return *this;
}

ExifWriter& ExifWriter::Undefined(ExifIfd ifd, std::uint16_t tag, const Bytes& bytes) {
  entries_[ifd][tag] = {ExifType::kUndefined, static_cast<std::uint32_t>(bytes.size()), {}, bytes};
  return *this;
}

ExifWriter& ExifWriter::Position(double lat_deg, double lon_deg) {
  return Position(lat_deg, lon_deg, lat_deg < 0 ? "S" : "N", lon_deg < 0 ? "W" : "E");
}

ExifWriter& ExifWriter::Position(double lat_deg, double lon_deg, const std::string& lat_ref,
                                 const std::string& lon_ref) {
  if (!lat_ref.empty()) Ascii(ExifIfd::kGps, 1, lat_ref);
  if (!lon_ref.empty()) Ascii(ExifIfd::kGps, 3, lon_ref);
  Rational(ExifIfd::kGps, 2, Dms(lat_deg));
  return Rational(ExifIfd::kGps, 4, Dms(lon_deg));
}

Bytes ExifWriter::Write(bool is_big_endian) const {
  auto directories = entries_;
  for (const auto& [ifd, pointer] : {std::pair{ExifIfd::kExif, kExifPointer}, {ExifIfd::kGps, kGpsPointer}}) {
    if (directories.contains(ifd)) directories[ExifIfd::kImage][pointer] = {ExifType::kLong, 1, {0}, {}};
  }
  const auto values_of = [&](const Entry& entry) {
    if (!entry.bytes.empty()) return entry.bytes;
    Bytes bytes;
    for (const std::uint32_t number : entry.numbers) {
      Put(bytes, number, entry.type == ExifType::kShort ? 2 : 4, is_big_endian);
    }
    return bytes;
  };
  // Where each directory starts: the directories lie one after the other, each with its values behind it.
  std::map<ExifIfd, std::uint32_t> starts;
  std::uint32_t offset = 8;
  for (const auto& [ifd, entries] : directories) {
    starts[ifd] = offset;
    offset += static_cast<std::uint32_t>(2 + 12 * entries.size() + 4);
    for (const auto& [tag, entry] : entries) {
      const std::size_t size = values_of(entry).size();
      if (size > 4) offset += static_cast<std::uint32_t>(size + size % 2);
    }
  }
  for (const auto& [ifd, pointer] : {std::pair{ExifIfd::kExif, kExifPointer}, {ExifIfd::kGps, kGpsPointer}}) {
    if (starts.contains(ifd)) directories[ExifIfd::kImage][pointer].numbers = {starts[ifd]};
  }
  Bytes out;
  out.push_back(is_big_endian ? 'M' : 'I');
  out.push_back(is_big_endian ? 'M' : 'I');
  Put(out, 42, 2, is_big_endian);
  Put(out, starts[ExifIfd::kImage], 4, is_big_endian);
  for (const auto& [ifd, entries] : directories) {
    Put(out, entries.size(), 2, is_big_endian);
    auto value_offset = static_cast<std::uint32_t>(starts[ifd] + 2 + 12 * entries.size() + 4);
    Bytes behind;
    for (const auto& [tag, entry] : entries) {
      Put(out, tag, 2, is_big_endian);
      Put(out, static_cast<std::uint16_t>(entry.type), 2, is_big_endian);
      Put(out, entry.count, 4, is_big_endian);
      Bytes value = values_of(entry);
      if (value.size() <= 4) {
        value.resize(4);
        out.insert(out.end(), value.begin(), value.end());
        continue;
      }
      Put(out, value_offset + behind.size(), 4, is_big_endian);
      if (value.size() % 2) value.push_back(0);
      behind.insert(behind.end(), value.begin(), value.end());
    }
    Put(out, 0, 4, is_big_endian);
    out.insert(out.end(), behind.begin(), behind.end());
  }
  return out;
}

std::string XmpPacket(const std::string& attributes, const std::string& elements) {
  return "<x:xmpmeta xmlns:x=\"adobe:ns:meta/\"><rdf:RDF "
         "xmlns:rdf=\"http://www.w3.org/1999/02/22-rdf-syntax-ns#\"><rdf:Description rdf:about=\"\" " +
         attributes + ">" + elements + "</rdf:Description></rdf:RDF></x:xmpmeta>";
}

Bytes JpegHeader(const JpegParts& parts) {
  Bytes jpeg{0xFF, 0xD8};
  using namespace std::string_literals;
  if (!parts.exif.empty()) PutSegment(jpeg, 0xE1, Joined("Exif\0\0"s, parts.exif));
  if (!parts.xmp.empty()) {
    PutSegment(jpeg, 0xE1,
               Joined("http://ns.adobe.com/xap/1.0/\0"s, Bytes(parts.xmp.begin(), parts.xmp.end())));
  }
  const std::size_t half = parts.extended_xmp.size() / 2;
  for (const auto& [offset, text] : {std::pair{std::size_t{0}, parts.extended_xmp.substr(0, half)},
                                     {half, parts.extended_xmp.substr(half)}}) {
    if (text.empty()) continue;
    Bytes payload = Joined("http://ns.adobe.com/xmp/extension/\0"s + std::string(32, 'A'), {});
    Put(payload, parts.extended_xmp.size(), 4, true);
    Put(payload, offset, 4, true);
    payload.insert(payload.end(), text.begin(), text.end());
    PutSegment(jpeg, 0xE1, payload);
  }
  Bytes frame{8};
  Put(frame, static_cast<std::uint64_t>(parts.height_px), 2, true);
  Put(frame, static_cast<std::uint64_t>(parts.width_px), 2, true);
  for (const int byte : {1, 1, 0x11, 0}) frame.push_back(static_cast<std::uint8_t>(byte));
  PutSegment(jpeg, 0xC0, frame);
  PutSegment(jpeg, 0xDA, {1, 1, 0, 0, 63, 0});
  jpeg.insert(jpeg.end(), {0x12, 0x34, 0xFF, 0x00, 0x56});
  if (parts.has_end) jpeg.insert(jpeg.end(), {0xFF, 0xD9});
  return jpeg;
}

namespace {

Bytes TiffOf(ExifWriter tags, int width_px, int height_px, const Bytes& pixels, const std::string& xmp) {
  constexpr auto kImage = ExifIfd::kImage;
  tags.Long(kImage, 0x0100, static_cast<std::uint32_t>(width_px));
  tags.Long(kImage, 0x0101, static_cast<std::uint32_t>(height_px));
  tags.Short(kImage, 0x0103, 1);
  tags.Long(kImage, 0x0116, static_cast<std::uint32_t>(height_px)).Short(kImage, 0x011C, 1);
  tags.Long(kImage, 0x0117, static_cast<std::uint32_t>(pixels.size()));
  if (!xmp.empty()) tags.Undefined(kImage, 0x02BC, Bytes(xmp.begin(), xmp.end()));
  tags.Long(kImage, 0x0111, 0);
  const auto pixel_offset = static_cast<std::uint32_t>(tags.Write().size());
  tags.Long(kImage, 0x0111, pixel_offset);
  Bytes file = tags.Write();
  file.insert(file.end(), pixels.begin(), pixels.end());
  return file;
}

}  // namespace

Bytes TiffImage(ExifWriter tags, int width_px, int height_px, const Bytes& pixels_rgb,
                const std::string& xmp) {
  constexpr auto kImage = ExifIfd::kImage;
  tags.Short(kImage, 0x0102, 8).Short(kImage, 0x0106, 2).Short(kImage, 0x0115, 3);
  return TiffOf(std::move(tags), width_px, height_px, pixels_rgb, xmp);
}

Bytes BandTiff(ExifWriter tags, int width_px, int height_px, const std::vector<std::uint16_t>& samples,
               const std::string& xmp) {
  constexpr auto kImage = ExifIfd::kImage;
  tags.Short(kImage, 0x0102, 16).Short(kImage, 0x0106, 1).Short(kImage, 0x0115, 1);
  Bytes pixels;
  for (const std::uint16_t sample : samples) Put(pixels, sample, 2, false);
  return TiffOf(std::move(tags), width_px, height_px, pixels, xmp);
}

Bytes DjiNote(const std::map<std::uint16_t, float>& values) {
  Bytes note;
  Put(note, values.size(), 2, false);
  for (const auto& [tag, value] : values) {
    Put(note, tag, 2, false);
    Put(note, 11, 2, false);
    Put(note, 1, 4, false);
    Put(note, std::bit_cast<std::uint32_t>(value), 4, false);
  }
  Put(note, 0, 4, false);
  return note;
}

}  // namespace skyquilt::flight
