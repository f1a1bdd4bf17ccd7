// What tiles at a map's edge cost in each encoding: fringe MAP.mbtiles, of a map made with `--format
// jpeg-png`, whose PNGs are the truth. A row an encoding: bytes, milliseconds of processor time to encode and
// to decode a tile, and how far colours are off where the map covers the ground wholly (PSNR, decibels).
#include <fmt/core.h>
#include <time.h>
#include <webp/encode.h>

#include <cmath>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "core/image/fringe_encoder.h"
#include "core/image/picture_codec.h"
#include "core/image/png_encoder.h"
#include "storage/exports/stored_tiles.h"

namespace {

using namespace skyquilt;

double ThreadMs() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return 1e3 * static_cast<double>(now.tv_sec) + 1e-6 * static_cast<double>(now.tv_nsec);
}

std::string_view Text(const std::vector<std::uint8_t>& bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

std::vector<image::RgbaImage> FringeOf(const char* mbtiles) {
  std::vector<image::RgbaImage> tiles;
  auto db = storage::SqliteDb::Open(mbtiles, storage::OpenMode::kReadOnlyImmutable);
  if (!db) return tiles;
  auto walk = storage::TileWalk::Of(*db);
  while (walk) {
    const Result<bool> more = walk->Next();
    if (!more || !*more) break;
    if (image::PictureFormatOf(walk->bytes()) != image::PictureFormat::kPng) continue;
    if (auto tile = image::DecodePicture(walk->bytes())) tiles.push_back(*std::move(tile));
  }
  return tiles;
}

// Colours and alpha by libwebp alone.
std::vector<std::uint8_t> ByLibrary(const image::RgbaImage& tile, int method, float quality) {
  WebPConfig config;
  WebPPicture picture;
  WebPMemoryWriter memory;
  WebPConfigPreset(&config, WEBP_PRESET_DEFAULT, quality);
  WebPPictureInit(&picture);
  WebPMemoryWriterInit(&memory);
  config.method = method;
  picture.width = tile.width_px;
  picture.height = tile.height_px;
  picture.writer = WebPMemoryWrite;
  picture.custom_ptr = &memory;
  WebPPictureImportRGBA(&picture, tile.rgba.data(), 4 * tile.width_px);
  WebPEncode(&config, &picture);
  std::vector<std::uint8_t> bytes(memory.mem, memory.mem + memory.size);
  WebPMemoryWriterClear(&memory);
  WebPPictureFree(&picture);
  return bytes;
}

void Weigh(const std::vector<image::RgbaImage>& tiles, const std::string& name,
           const std::function<std::vector<std::uint8_t>(const image::RgbaImage&)>& encode) {
  double encode_ms = 0.0, decode_ms = 0.0, squares = 0.0, bytes = 0.0, values = 0.0;
  for (const image::RgbaImage& tile : tiles) {
    const double begun = ThreadMs();
    const std::vector<std::uint8_t> encoded = encode(tile);
    const double done = ThreadMs();
    const auto decoded = image::DecodePicture(Text(encoded));
    encode_ms += done - begun;
    decode_ms += ThreadMs() - done;
    bytes += static_cast<double>(encoded.size());
    for (std::size_t i = 0; i < tile.rgba.size(); i += 4) {
      if (tile.rgba[i + 3] != 255) continue;
      for (std::size_t c = i; c < i + 3; ++c) squares += std::pow(decoded->rgba[c] - tile.rgba[c], 2);
      values += 3.0;
    }
  }
  const auto count = static_cast<double>(tiles.size());
  fmt::print("{:<18} {:>9.0f} {:>9.2f} {:>9.2f} {:>7.2f}\n", name, bytes / count, encode_ms / count,
             decode_ms / count, 10.0 * std::log10(255.0 * 255.0 * values / squares));
}

}  // namespace

int main(int argc, char** argv) {
  const std::vector<image::RgbaImage> tiles = argc == 2 ? FringeOf(argv[1]) : std::vector<image::RgbaImage>();
  if (tiles.empty()) {
    fmt::print(stderr, "fringe MAP.mbtiles: of a map with PNG tiles (skyquilt stitch --format jpeg-png)\n");
    return 2;
  }
  fmt::print("{} tiles of {} pixels\n{:<18} {:>9} {:>9} {:>9} {:>7}\n", tiles.size(), tiles.front().width_px,
             "", "bytes", "encode ms", "decode ms", "dB");
  Weigh(tiles, "PNG", [](const auto& tile) { return image::EncodeWholePng(tile); });
  Weigh(tiles, "JPEG 85, no alpha",
        [](const auto& tile) { return image::EncodeJpeg(image::RowsOf(tile), 85); });
  for (const int method : {0, 1, 2, 4})
    Weigh(tiles, fmt::format("libwebp {}, 70", method),
          [&](const auto& tile) { return ByLibrary(tile, method, 70.0F); });
  for (const int quality : {60, 70, 80, 90})
    Weigh(tiles, fmt::format("ours {}", quality),
          [&](const auto& tile) { return image::EncodeFringeWebp(tile, static_cast<float>(quality)); });
  return 0;
}
