#include "core/video/take_frames.h"

#include <fmt/format.h>

#include <algorithm>
#include <fstream>
#include <utility>

#include "core/base/try.h"
#include "core/flight/bytes/byte_source.h"
#include "core/flight/logs/formats.h"
#include "core/flight/remarks/because.h"
#include "core/image/picture_codec.h"
#include "core/video/frame_motion.h"
#include "core/video/video_file.h"

namespace skyquilt::video {
namespace {

constexpr int kFollowedWidthPx = 480;
constexpr double kStepS = 0.12;  // between frames that are looked at: motion between them stays small
constexpr double kRoomForSharpest =
    0.06;                              // of overlap above the wanted one, within which the sharpest is taken
constexpr double kWorthTheEnd = 0.95;  // the last frame is taken too unless it shows hardly anything new

Result<void> WriteBytes(const std::filesystem::path& path, const char* bytes, std::size_t size) {
  std::ofstream file(path, std::ios::binary | std::ios::trunc);
  file.write(bytes, static_cast<std::streamsize>(size));
  file.close();
  if (file) return {};
  return Error{ErrorCode::kIo, "Could not write " + path.string() + ": check that the disk has room.", ""};
}

class Taking {
 public:
  Taking(const flight::InputFile& film, VideoFile& video, const std::filesystem::path& folder,
         const TakeFramesOptions& options)
      : stem_(std::filesystem::path(film.name).stem().string()),
        video_(video),
        folder_(folder),
        options_(options) {}

  // The frame at hand, which shares `overlap` with the one taken last; nothing: as much as nobody knows.
  Result<void> See(const GrayFrame& gray, std::optional<double> overlap) {
    if (taken_.photos.empty() || !overlap) {
      // After a cut the frame before it was the last of its ground.
      if (has_candidate_) SKYQUILT_TRY(TakeCandidate());
      Keep(kOnlyForTheEnd);
      SKYQUILT_TRY(TakeCandidate());
      motion.MakeReference();
      return {};
    }
    if (*overlap >= kWorthTheEnd) return {};
    if (*overlap >= options_.overlap + kRoomForSharpest) {
      Keep(kOnlyForTheEnd);
      return {};
    }
    const double sharpness = Sharpness(gray);
    const bool is_in_question = *overlap >= options_.overlap || candidate_sharpness_ == kOnlyForTheEnd;
    if (is_in_question && sharpness > candidate_sharpness_) Keep(sharpness);
    if (*overlap >= options_.overlap) return {};
    SKYQUILT_TRY(TakeCandidate());
    motion.MakeMarkedReference();
    return {};
  }

  // The film is over: what its last frames show is on no photo yet.
  Result<void> End() {
    if (!has_candidate_) return {};
    return TakeCandidate();
  }

  bool IsFull() const { return static_cast<int>(taken_.photos.size()) >= options_.max_frames; }
  TakenFrames taken() && { return std::move(taken_); }

  FrameMotion motion;

 private:
  static constexpr double kOnlyForTheEnd = -1.0;

  void Keep(double sharpness) {
    video_.Keep();
    motion.Mark();
    candidate_sharpness_ = sharpness;
    candidate_time_s_ = video_.time_s();
    candidate_number_ = video_.number();
    has_candidate_ = true;
  }

  Result<void> TakeCandidate() {
    has_candidate_ = false;
    candidate_sharpness_ = kOnlyForTheEnd;
    SKYQUILT_TRY_ASSIGN(const image::DecodedImage frame, video_.Kept());
    const image::PixelRows rows{frame.rgb.data(), frame.width_px, frame.height_px, 3, 3 * frame.width_px};
    const std::vector<std::uint8_t> jpeg = image::EncodeJpeg(rows, options_.jpeg_quality);
    const std::string name = fmt::format("{}_{:06}.jpg", stem_, candidate_number_);
    SKYQUILT_TRY(WriteBytes(folder_ / name, reinterpret_cast<const char*>(jpeg.data()), jpeg.size()));
    taken_.photos.push_back({name, folder_ / name});
    taken_.times_s.push_back(candidate_time_s_);
    return {};
  }

  const std::string stem_;
  VideoFile& video_;
  const std::filesystem::path& folder_;
  const TakeFramesOptions& options_;
  TakenFrames taken_;
  bool has_candidate_ = false;
  double candidate_sharpness_ = kOnlyForTheEnd, candidate_time_s_ = 0.0;
  std::int64_t candidate_number_ = 0;
};

Result<flight::FlightLog> LogBeside(const flight::InputFile& subtitles) {
  SKYQUILT_TRY_ASSIGN(const auto mapped, flight::MappedFile::Open(subtitles.path));
  return flight::ParseFilmSubtitles(subtitles.name, mapped.bytes());
}

// What the camera wrote of its way, beside the film or within it. Nothing where it wrote nothing.
std::optional<flight::FlightLog> LogOf(const flight::InputFile& film,
                                       const std::optional<flight::InputFile>& subtitles,
                                       std::vector<flight::Remark>& warnings) {
  if (subtitles) {
    Result<flight::FlightLog> log = LogBeside(*subtitles);
    if (log) return *std::move(log);
    warnings.push_back({flight::RemarkCode::kFileNotRead, {{"why", flight::WhyOf(log.error())}}});
  }
  const Result<std::string> text = VideoFile::Subtitles(film.path);
  if (!text || text->empty()) return std::nullopt;
  Result<flight::FlightLog> log = flight::ParseFilmSubtitles(
      film.name, flight::LogBytes(reinterpret_cast<const std::uint8_t*>(text->data()), text->size()));
  if (!log) return std::nullopt;  // subtitles of another kind are nobody's fault
  return *std::move(log);
}

}  // namespace

Result<TakenFrames> TakeFrames(const flight::InputFile& film,
                               const std::optional<flight::InputFile>& subtitles,
                               const std::filesystem::path& folder, const TakeFramesOptions& options,
                               Progress& progress) {
  SKYQUILT_TRY_ASSIGN(VideoFile video, VideoFile::Open(film.path, options.threads));
  Taking taking(film, video, folder, options);
  double looked_at_s = -1.0;
  for (;;) {
    if (progress.IsCancelled()) return Error{ErrorCode::kCancelled, "Cancelled.", ""};
    SKYQUILT_TRY_ASSIGN(const bool is_there, video.Next());
    if (!is_there || taking.IsFull()) break;
    if (looked_at_s >= 0.0 && video.time_s() < looked_at_s + kStepS) continue;
    looked_at_s = video.time_s();
    SKYQUILT_TRY_ASSIGN(const GrayFrame gray, video.Gray(kFollowedWidthPx));
    SKYQUILT_TRY(taking.See(gray, taking.motion.OverlapWithReference(gray)));
    if (video.facts().duration_s > 0.0) {
      progress.Report(std::min(1.0, looked_at_s / video.facts().duration_s),
                      "choosing frames of " + film.name);
    }
  }
  const bool is_full = taking.IsFull();
  if (!is_full) SKYQUILT_TRY(taking.End());
  TakenFrames taken = std::move(taking).taken();
  if (is_full) {
    taken.warnings.push_back(
        {flight::RemarkCode::kFilmFull,
         {{"file", film.name}, {"frames", taken.photos.size()}, {"until_s", taken.times_s.back()}}});
  }
  const std::optional<flight::FlightLog> log = LogOf(film, subtitles, taken.warnings);
  std::vector<std::string> names;
  for (const flight::InputFile& photo : taken.photos) names.push_back(photo.name);
  const std::string table = log ? FrameTable(names, taken.times_s, *log) : std::string();
  if (!table.empty()) {
    const std::string name = std::filesystem::path(film.name).stem().string() + "_frames.csv";
    SKYQUILT_TRY(WriteBytes(folder / name, table.data(), table.size()));
    taken.table = flight::InputFile{name, folder / name};
  }
  return taken;
}

}  // namespace skyquilt::video
