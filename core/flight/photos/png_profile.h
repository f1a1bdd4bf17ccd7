// ReadPngProfile: EXIF and XMP that ImageMagick and programs built on it keep in text chunks of a PNG, in
// hexadecimal digits ("Raw profile type exif"). Bounded: 256 KiB of text, however it is compressed. Any
// thread. Source: ImageMagick, coders/png.c; ExifTool, tags of PNG text chunks.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace skyquilt::flight {

struct PngProfile {
  std::vector<std::uint8_t> exif;  // the TIFF block, without its "Exif\0\0"
  std::string xmp;                 // a packet
};

// Whether a text chunk that begins so holds one.
inline constexpr std::size_t kPngProfileKeyBytes = 22;
bool IsPngProfile(std::span<const std::uint8_t> start);

// Of the body of a tEXt chunk or, compressed, of a zTXt chunk; empty for what is damaged or none of these.
PngProfile ReadPngProfile(std::span<const std::uint8_t> chunk, bool is_compressed);

}  // namespace skyquilt::flight
