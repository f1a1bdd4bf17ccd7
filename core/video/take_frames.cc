#include "core/video/take_frames.h"

#include <fmt/chrono.h>
#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <fstream>
#include <opencv2/calib3d.hpp>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <opencv2/video/tracking.hpp>
#include <string_view>
#include <utility>

#include "core/base/try.h"
#include "core/flight/bytes/byte_source.h"
#include "core/flight/logs/formats.h"
#include "core/flight/remarks/because.h"
#include "core/image/picture_codec.h"
#include "core/video/video_file.h"

namespace skyquilt::video {
namespace {

constexpr int kMaxCorners = 300, kMinFollowed = 20;
constexpr double kCornerQuality = 0.01, kCornerDistancePx = 8.0, kTolerancePx = 2.0;
constexpr int kGridSide = 24;  // points of a frame that are looked for in the reference

cv::Mat AsMat(const GrayFrame& frame) {
  return cv::Mat(frame.height_px, frame.width_px, CV_8UC1, const_cast<std::uint8_t*>(frame.gray.data()));
}

// From a frame's pixels to the reference's.
using Motion = cv::Matx33d;

std::optional<Motion> MotionBetween(const cv::Mat& before, const cv::Mat& now) {
  std::vector<cv::Point2f> corners;
  cv::goodFeaturesToTrack(before, corners, kMaxCorners, kCornerQuality, kCornerDistancePx);
  if (static_cast<int>(corners.size()) < kMinFollowed) return std::nullopt;
  std::vector<cv::Point2f> followed;
  std::vector<unsigned char> is_found;
  cv::calcOpticalFlowPyrLK(before, now, corners, followed, is_found, cv::noArray(), cv::Size(21, 21), 4);
  std::vector<cv::Point2f> from, to;
  for (std::size_t i = 0; i < corners.size(); ++i) {
    if (is_found[i] == 0) continue;
    from.push_back(followed[i]);
    to.push_back(corners[i]);
  }
  if (static_cast<int>(from.size()) < kMinFollowed) return std::nullopt;
  std::vector<unsigned char> fits;
  const cv::Mat similarity = cv::estimateAffinePartial2D(from, to, fits, cv::RANSAC, kTolerancePx);
  if (similarity.empty() || std::count(fits.begin(), fits.end(), 1) < kMinFollowed) return std::nullopt;
  Motion motion = Motion::eye();
  for (int row = 0; row < 2; ++row) {
    for (int column = 0; column < 3; ++column) motion(row, column) = similarity.at<double>(row, column);
  }
  return motion;
}

// The share of a frame that the reference shows too.
double Overlap(const Motion& reference_from_frame, const cv::Size& size) {
  int inside = 0;
  for (int i = 0; i < kGridSide * kGridSide; ++i) {
    const int column = i % kGridSide, row = i / kGridSide;
    const cv::Vec3d at = reference_from_frame * cv::Vec3d((column + 0.5) / kGridSide * size.width,
                                                          (row + 0.5) / kGridSide * size.height, 1.0);
    inside += at[0] >= 0.0 && at[1] >= 0.0 && at[0] < size.width && at[1] < size.height ? 1 : 0;
  }
  return static_cast<double>(inside) / (kGridSide * kGridSide);
}

// How far the camera has moved over the ground since a frame of a film, from what the frames show: corners
// are followed from each frame to the next (pyramidal Lucas-Kanade), and a similarity is fitted to them
// (RANSAC). Bouguet 2001, "Pyramidal implementation of the affine Lucas Kanade feature tracker".
class FrameMotion {
 public:
  // The next frame, of the size of those before. Nothing: it does not fit to the one before (a cut, a blur,
  // water), so that the way since the reference is not known.
  std::optional<double> OverlapWithReference(const GrayFrame& frame) {
    const cv::Mat now = AsMat(frame).clone();
    if (before_.size() != now.size()) {
      before_ = now;
      return std::nullopt;
    }
    const std::optional<Motion> motion = MotionBetween(before_, now);
    before_ = now;
    if (!motion) return std::nullopt;
    reference_from_now_ = reference_from_now_ * *motion;
    return Overlap(reference_from_now_, now.size());
  }

  // The frame that was given last becomes the reference, or the marked one.
  void MakeReference() { reference_from_now_ = Motion::eye(); }
  void Mark() { reference_from_marked_ = reference_from_now_; }
  void MakeMarkedReference() { reference_from_now_ = reference_from_marked_.inv() * reference_from_now_; }

 private:
  cv::Mat before_;
  Motion reference_from_now_ = Motion::eye(), reference_from_marked_ = Motion::eye();
};

// Variance of the Laplacian: larger for a sharper picture of the same ground.
double Sharpness(const GrayFrame& frame) {
  cv::Mat laplacian;
  cv::Laplacian(AsMat(frame), laplacian, CV_16S);
  cv::Scalar mean, deviation;
  cv::meanStdDev(laplacian, mean, deviation);
  return deviation[0] * deviation[0];
}

constexpr int kFollowedWidthPx = 480;
constexpr double kStepS = 0.12;  // between frames that are looked at: motion between them stays small
constexpr double kRoomForSharpest =
    0.06;                              // of overlap above the wanted one, within which the sharpest is taken
constexpr double kWorthTheEnd = 0.95;  // the last frame is taken too unless it shows hardly anything new
// Of frames of which nobody knows what they share: cuts and blurs come singly, over water all are so.
// These take half of the frames that there may be, spread over the film, however long it is.
constexpr double kUnfollowedAtOnce = 25.0, kUnfollowedShare = 0.5;
constexpr double kUnfollowedPerS = 2.0;  // where nothing says how long it is

double UnfollowedPerS(double duration_s, int max_frames) {
  const bool is_known = duration_s > 0.0 && duration_s < kLongestFilmS;
  return is_known ? kUnfollowedShare * max_frames / duration_s : kUnfollowedPerS;
}

Result<void> WriteBytes(const std::filesystem::path& path, const char* bytes, std::size_t size) {
  std::ofstream file(path, std::ios::binary | std::ios::trunc);
  file.write(bytes, static_cast<std::streamsize>(size));
  file.close();
  if (file) return {};
  return Error{ErrorCode::kIo, "Could not write " + path.string() + ": check that the disk has room.", ""};
}

// With its time in XMP, of no zone, in a segment behind the mark that begins a JPEG (ISO 16684-1; part 3 of
// Adobe's XMP specification, 1.1.3).
std::vector<std::uint8_t> WithTime(const std::vector<std::uint8_t>& jpeg, flight::UtcTime began_at,
                                   double time_s) {
  constexpr std::string_view kHeader("http://ns.adobe.com/xap/1.0/\0", 29);
  const auto time =
      began_at + std::chrono::milliseconds(std::llround(1e3 * std::clamp(time_s, 0.0, kLongestFilmS)));
  const auto second = std::chrono::floor<std::chrono::seconds>(time);
  const std::string packet = fmt::format(
      R"(<x:xmpmeta xmlns:x="adobe:ns:meta/"><rdf:RDF xmlns:rdf="http://www.w3.org/1999/02/22-rdf-syntax-ns#">)"
      R"(<rdf:Description rdf:about="" xmlns:xmp="http://ns.adobe.com/xap/1.0/" )"
      R"(xmp:CreateDate="{:%Y-%m-%dT%H:%M:%S}.{:03}"/></rdf:RDF></x:xmpmeta>)",
      fmt::gmtime(std::chrono::system_clock::to_time_t(second)),
      std::chrono::floor<std::chrono::milliseconds>(time - second).count());
  const std::size_t length = 2 + kHeader.size() + packet.size();
  std::vector<std::uint8_t> timed(jpeg.begin(), jpeg.begin() + 2);
  for (const std::size_t byte : {std::size_t{0xFF}, std::size_t{0xE1}, length >> 8, length & 0xFF})
    timed.push_back(static_cast<std::uint8_t>(byte));
  timed.insert(timed.end(), kHeader.begin(), kHeader.end());
  timed.insert(timed.end(), packet.begin(), packet.end());
  timed.insert(timed.end(), jpeg.begin() + 2, jpeg.end());
  return timed;
}

class Taking {
 public:
  Taking(const flight::InputFile& film, VideoFile& video, const std::filesystem::path& folder,
         const TakeFramesOptions& options)
      : stem_(std::filesystem::path(film.name).stem().string()),
        video_(video),
        folder_(folder),
        options_(options),
        unfollowed_per_s_(UnfollowedPerS(video.facts().duration_s, options.max_frames)) {}

  // The frame at hand, which shares `overlap` with the one taken last; nothing: as much as nobody knows.
  Result<void> See(const GrayFrame& gray, std::optional<double> overlap) {
    if (taken_.photos.empty() || is_lost_ || !overlap) {
      // After a cut the frame before it was the last of its ground.
      if (has_candidate_) SKYQUILT_TRY(TakeCandidate());
      is_lost_ = !MayTakeUnfollowed();
      if (is_lost_) return {};
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

  bool MayTakeUnfollowed() {
    const double since_s = std::max(0.0, video_.time_s() - unfollowed_at_s_);
    unfollowed_at_s_ = video_.time_s();
    unfollowed_left_ = std::min(kUnfollowedAtOnce, unfollowed_left_ + unfollowed_per_s_ * since_s);
    if (unfollowed_left_ < 1.0) return false;
    unfollowed_left_ -= 1.0;
    return true;
  }

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
    std::vector<std::uint8_t> jpeg = image::EncodeJpeg(rows, options_.jpeg_quality);
    if (options_.began_at) jpeg = WithTime(jpeg, *options_.began_at, candidate_time_s_);
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
  bool is_lost_ = false;  // a frame was passed over whose share with the one taken last nobody knows
  const double unfollowed_per_s_;
  double unfollowed_left_ = kUnfollowedAtOnce, unfollowed_at_s_ = 0.0;
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

// Of a film that says for how long it goes on: a copy that broke off, or pictures that cannot be decoded.
std::optional<flight::Remark> EndsEarly(const flight::InputFile& film, double film_s, double until_s) {
  constexpr double kLastPicturesS = 3.0;
  if (film_s - until_s <= kLastPicturesS || film_s > kLongestFilmS) return std::nullopt;
  return flight::Remark{flight::RemarkCode::kFilmEndsEarly,
                        {{"file", film.name}, {"film_s", film_s}, {"until_s", until_s}}};
}

// Cameras write a subtitle a second or more often; what lies further apart than the last few was not written
// with this film, or not with all of it.
std::optional<flight::Remark> OfOtherLength(const flight::InputFile& film, double film_s,
                                            const flight::FlightLog& log) {
  constexpr double kLastSubtitlesS = 3.0;
  if (film_s <= 0.0 || log.gnss.empty()) return std::nullopt;
  const double subtitles_s = log.gnss.back().t_s;
  if (std::abs(subtitles_s - film_s) <= kLastSubtitlesS) return std::nullopt;
  return flight::Remark{flight::RemarkCode::kSubtitlesOfOtherLength,
                        {{"file", film.name}, {"film_s", film_s}, {"subtitles_s", subtitles_s}}};
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
  if (auto early = EndsEarly(film, video.facts().duration_s, looked_at_s); early && !is_full)
    taken.warnings.push_back(*std::move(early));
  const std::optional<flight::FlightLog> log = LogOf(film, subtitles, taken.warnings);
  std::vector<std::string> names;
  for (const flight::InputFile& photo : taken.photos) names.push_back(photo.name);
  const std::string table = log ? FrameTable(names, taken.times_s, *log) : std::string();
  if (!table.empty()) {
    if (auto apart = OfOtherLength(film, video.facts().duration_s, *log))
      taken.warnings.push_back(*std::move(apart));
    const std::string name = std::filesystem::path(film.name).stem().string() + "_frames.csv";
    SKYQUILT_TRY(WriteBytes(folder / name, table.data(), table.size()));
    taken.table = flight::InputFile{name, folder / name};
  }
  return taken;
}

}  // namespace skyquilt::video
