// VideoFile: the frames of a film one after the other, decoded by libav, and what the film says of itself.
// Memory: a few frames, whatever the film's length. One thread at a time; decoding itself uses as many as are
// asked for, with the same pixels for any number. Errors: kUnsupportedFormat (no film, or of a coding that is
// not known), kCorrupt, kTooLarge, kIo.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>

#include "core/base/pixel_bytes.h"
#include "core/base/result.h"
#include "core/flight/photo.h"
#include "core/image/decoded_image.h"

namespace skyquilt::video {

inline constexpr int kMaxFrameSidePx = 8192;
inline constexpr double kLongestFilmS = 86'400.0;  // what says that it lasts longer is not believed

struct VideoFacts {
  int width_px = 0, height_px = 0;
  double duration_s = 0.0;                    // of the pictures, else of the whole film; 0: not said
  std::optional<flight::UtcTime> created_at;  // when it began or ended, by a clock of whatever zone
};

struct GrayFrame {
  int width_px = 0, height_px = 0;
  PixelBytes gray;  // rows without padding
};

class VideoFile {
 public:
  static Result<VideoFile> Open(const std::filesystem::path& path, int threads);
  VideoFile(VideoFile&&) noexcept;
  VideoFile& operator=(VideoFile&&) noexcept;
  ~VideoFile();

  const VideoFacts& facts() const { return facts_; }
  // The next frame is the current one; false at the end. Frames that are damaged are skipped; a film that
  // breaks off ends there.
  Result<bool> Next();
  double time_s() const;        // of the current frame, from the first
  std::int64_t number() const;  // of the current frame, from 0
  // The current frame, `width_px` wide.
  Result<GrayFrame> Gray(int width_px);
  // Keeps the current frame in place of the one kept before; costs no copy.
  void Keep();
  // The kept one in its full size. Call only after Keep.
  Result<image::DecodedImage> Kept();

  // What a subtitle track within the film says, as a subtitle file would; empty without one. Reads the film
  // once from its beginning; independent of Next.
  static Result<std::string> Subtitles(const std::filesystem::path& path);

 private:
  struct Streams;
  explicit VideoFile(std::unique_ptr<Streams> streams);
  std::unique_ptr<Streams> streams_;
  VideoFacts facts_;
};

}  // namespace skyquilt::video
