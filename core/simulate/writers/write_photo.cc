#include "core/simulate/writers/write_photo.h"

#include <fstream>

#include "core/base/check.h"
#include "core/image/picture_codec.h"
#include "core/simulate/writers/photo_tags.h"

namespace skyquilt::simulate {
namespace {

void AppendSegment(std::uint8_t marker, const std::vector<std::uint8_t>& payload,
                   std::vector<std::uint8_t>& out) {
  SKYQUILT_CHECK(payload.size() + 2 <= 65535, "a JPEG segment holds at most 65533 bytes");
  const auto length = static_cast<std::uint32_t>(payload.size() + 2);
  out.insert(out.end(),
             {0xFF, marker, static_cast<std::uint8_t>(length >> 8), static_cast<std::uint8_t>(length & 255)});
  out.insert(out.end(), payload.begin(), payload.end());
}

}  // namespace

std::vector<std::uint8_t> EncodePhoto(const image::DecodedImage& photo, const RecordedPose& recorded,
                                      int jpeg_quality) {
  const image::PixelRows rows{photo.rgb.data(), photo.width_px, photo.height_px, 3, 3 * photo.width_px};
  const std::vector<std::uint8_t> jpeg = image::EncodeJpeg(rows, jpeg_quality, image::ChromaSampling::k422);
  SKYQUILT_CHECK(jpeg.size() > 6 && jpeg[0] == 0xFF && jpeg[1] == 0xD8, "the encoder's output is not a JPEG");
  std::vector<std::uint8_t> out(jpeg.begin(), jpeg.begin() + 2);
  AppendSegment(0xE1, ExifPayload(recorded), out);
  AppendSegment(0xE1, XmpPayload(recorded), out);
  // EXIF wants its segment first: the encoder's JFIF header (APP0) is left out.
  std::size_t rest = 2;
  if (jpeg[2] == 0xFF && jpeg[3] == 0xE0) rest += 2u + (static_cast<std::size_t>(jpeg[4]) << 8 | jpeg[5]);
  out.insert(out.end(), jpeg.begin() + static_cast<std::ptrdiff_t>(rest), jpeg.end());
  return out;
}

Result<void> WriteBytes(const std::filesystem::path& path, const std::vector<std::uint8_t>& bytes) {
  std::ofstream file(path, std::ios::binary | std::ios::trunc);
  file.write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
  file.close();
  if (!file) {
    return Error{ErrorCode::kIo,
                 "Could not write " + path.string() + ": check that the folder exists and the disk has room.",
                 "write failed: " + path.string()};
  }
  return {};
}

}  // namespace skyquilt::simulate
