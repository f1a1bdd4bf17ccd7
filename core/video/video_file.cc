#include "core/video/video_file.h"

#include <fmt/format.h>

extern "C" {
#include <libavcodec/avcodec.h>
#include <libavformat/avformat.h>
#include <libavutil/parseutils.h>
#include <libavutil/pixdesc.h>
#include <libswscale/swscale.h>
}

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <new>
#include <string_view>
#include <utility>

#include "core/base/check.h"
#include "core/base/try.h"
#include "core/flight/remarks/because.h"

namespace skyquilt::video {
namespace {

struct FreeFormat {
  void operator()(AVFormatContext* format) const { avformat_close_input(&format); }
};
struct FreeCodec {
  void operator()(AVCodecContext* codec) const { avcodec_free_context(&codec); }
};
struct FreeFrame {
  void operator()(AVFrame* frame) const { av_frame_free(&frame); }
};
struct FreePacket {
  void operator()(AVPacket* packet) const { av_packet_free(&packet); }
};
struct FreeScaler {
  void operator()(SwsContext* scaler) const { sws_freeContext(scaler); }
};
using Format = std::unique_ptr<AVFormatContext, FreeFormat>;
using Codec = std::unique_ptr<AVCodecContext, FreeCodec>;
using Frame = std::unique_ptr<AVFrame, FreeFrame>;
using Packet = std::unique_ptr<AVPacket, FreePacket>;
using Scaler = std::unique_ptr<SwsContext, FreeScaler>;

template <typename Owner, typename Raw>
Owner Owned(Raw* raw) {
  if (raw == nullptr) throw std::bad_alloc();
  return Owner(raw);
}

std::string Words(int error) {
  std::array<char, AV_ERROR_MAX_STRING_SIZE> words{};
  av_strerror(error, words.data(), words.size());
  return words.data();
}

Error NoFilm(const std::filesystem::path& path, std::string detail) {
  return flight::Because(ErrorCode::kUnsupportedFormat,
                         {flight::RemarkCode::kNoFilm, {{"file", path.filename().string()}}},
                         std::move(detail));
}

Error Damaged(const std::filesystem::path& path, std::string detail) {
  return flight::Because(ErrorCode::kCorrupt,
                         {flight::RemarkCode::kFilmDamaged, {{"file", path.filename().string()}}},
                         std::move(detail));
}

Result<Format> OpenFormat(const std::filesystem::path& path) {
  AVFormatContext* raw = nullptr;
  // Only what a camera writes into one file: no playlists, which name others.
  AVDictionary* settings = nullptr;
  av_dict_set(&settings, "protocol_whitelist", "file", 0);
  av_dict_set(&settings, "format_whitelist", "mov,mp4,m4a,3gp,3g2,mj2,avi,matroska,webm,mpegts", 0);
  const int opened = avformat_open_input(&raw, path.c_str(), nullptr, &settings);
  av_dict_free(&settings);
  if (opened < 0) return NoFilm(path, Words(opened));
  Format format(raw);
  const int found = avformat_find_stream_info(format.get(), nullptr);
  if (found < 0) return NoFilm(path, Words(found));
  return format;
}

// "2023-09-18T11:58:23.000000Z". A clock that was never set says nothing.
std::optional<flight::UtcTime> CreatedAt(const AVFormatContext& format) {
  const AVDictionaryEntry* entry = av_dict_get(format.metadata, "creation_time", nullptr, 0);
  if (entry == nullptr) return std::nullopt;
  constexpr std::int64_t kYear1980Us = 315'532'800'000'000, kYear2100Us = 4'102'444'800'000'000;
  std::int64_t us = 0;
  if (av_parse_time(&us, entry->value, 0) < 0 || us < kYear1980Us || us >= kYear2100Us) return std::nullopt;
  return flight::UtcTime(std::chrono::microseconds(us));
}

// How a frame says that its colours were coded (ITU-R BT.601, BT.709, BT.2020; levels from 0 or from 16); by
// itself the scaler takes all for BT.601. What a frame does not say stays so.
void TakeColoursOf(const AVFrame& frame, SwsContext* scaler) {
  const AVPixFmtDescriptor* const pixels = av_pix_fmt_desc_get(static_cast<AVPixelFormat>(frame.format));
  if (pixels == nullptr || (pixels->flags & AV_PIX_FMT_FLAG_RGB) != 0) return;
  int *of_frame = nullptr, *of_picture = nullptr;
  int frame_is_full = 0, picture_is_full = 0, brightness = 0, contrast = 0, saturation = 0;
  if (sws_getColorspaceDetails(scaler, &of_frame, &frame_is_full, &of_picture, &picture_is_full, &brightness,
                               &contrast, &saturation) < 0)
    return;
  if (frame.color_range == AVCOL_RANGE_JPEG) frame_is_full = 1;
  sws_setColorspaceDetails(scaler, sws_getCoefficients(frame.colorspace), frame_is_full, of_picture,
                           picture_is_full, brightness, contrast, saturation);
}

}  // namespace

struct VideoFile::Streams {
  std::filesystem::path path;
  Format format;
  Codec codec;
  int video = -1;
  Frame current, kept;
  Packet packet;
  Scaler to_gray, to_rgb;
  std::int64_t number = -1;
  std::int64_t first_pts = AV_NOPTS_VALUE;
  bool is_drained = false;

  double TimeOf(const AVFrame& frame) const {
    const std::int64_t pts = frame.best_effort_timestamp;
    if (pts == AV_NOPTS_VALUE || first_pts == AV_NOPTS_VALUE) return 0.0;
    return static_cast<double>(pts - first_pts) * av_q2d(format->streams[video]->time_base);
  }

  // The next packet of the film's pictures to the decoder; after the last, that it was.
  void Feed() {
    for (;;) {
      const int read = av_read_frame(format.get(), packet.get());
      if (read < 0) {  // the end, or where the file breaks off
        (void)avcodec_send_packet(codec.get(), nullptr);
        is_drained = true;
        return;
      }
      const bool is_wanted = packet->stream_index == video;
      // A packet that the decoder refuses is a damaged picture: the next one stands for it.
      if (is_wanted) (void)avcodec_send_packet(codec.get(), packet.get());
      av_packet_unref(packet.get());
      if (is_wanted) return;
    }
  }

  Result<void> Scale(const AVFrame& frame, Scaler& scaler, int width_px, int height_px, AVPixelFormat to,
                     std::uint8_t* out, int row_bytes) {
    scaler.reset(sws_getCachedContext(scaler.release(), frame.width, frame.height,
                                      static_cast<AVPixelFormat>(frame.format), width_px, height_px, to,
                                      SWS_AREA | SWS_ACCURATE_RND | SWS_BITEXACT, nullptr, nullptr, nullptr));
    if (!scaler) return NoFilm(path, "its pixels are of a kind that cannot be converted");
    if (to == AV_PIX_FMT_RGB24) TakeColoursOf(frame, scaler.get());
    const std::array<std::uint8_t*, 4> planes{out, nullptr, nullptr, nullptr};
    const std::array<int, 4> strides{row_bytes, 0, 0, 0};
    sws_scale(scaler.get(), frame.data, frame.linesize, 0, frame.height, planes.data(), strides.data());
    return {};
  }
};

VideoFile::VideoFile(std::unique_ptr<Streams> streams) : streams_(std::move(streams)) {}
VideoFile::VideoFile(VideoFile&&) noexcept = default;
VideoFile& VideoFile::operator=(VideoFile&&) noexcept = default;
VideoFile::~VideoFile() = default;

Result<VideoFile> VideoFile::Open(const std::filesystem::path& path, int threads) {
  av_log_set_level(AV_LOG_QUIET);  // what is wrong is said by our own errors
  auto streams = std::make_unique<Streams>();
  streams->path = path;
  SKYQUILT_TRY_ASSIGN(streams->format, OpenFormat(path));
  const AVCodec* decoder = nullptr;
  streams->video = av_find_best_stream(streams->format.get(), AVMEDIA_TYPE_VIDEO, -1, -1, &decoder, 0);
  if (streams->video < 0 || decoder == nullptr) return NoFilm(path, "no moving picture in it");
  const AVStream& stream = *streams->format->streams[streams->video];
  streams->codec = Owned<Codec>(avcodec_alloc_context3(decoder));
  if (avcodec_parameters_to_context(streams->codec.get(), stream.codecpar) < 0) throw std::bad_alloc();
  streams->codec->thread_count = std::clamp(threads, 1, 16);
  streams->codec->max_pixels = std::int64_t{kMaxFrameSidePx} * kMaxFrameSidePx;
  const int opened = avcodec_open2(streams->codec.get(), decoder, nullptr);
  if (opened < 0) return NoFilm(path, Words(opened));
  streams->current = Owned<Frame>(av_frame_alloc());
  streams->kept = Owned<Frame>(av_frame_alloc());
  streams->packet = Owned<Packet>(av_packet_alloc());
  VideoFacts facts;
  facts.width_px = stream.codecpar->width;
  facts.height_px = stream.codecpar->height;
  if (facts.width_px < 1 || facts.height_px < 1) return NoFilm(path, "frames of no size");
  if (facts.width_px > kMaxFrameSidePx || facts.height_px > kMaxFrameSidePx) {
    return flight::Because(ErrorCode::kTooLarge, {flight::RemarkCode::kFilmTooLarge,
                                                  {{"file", path.filename().string()},
                                                   {"width_px", facts.width_px},
                                                   {"height_px", facts.height_px},
                                                   {"most_side_px", kMaxFrameSidePx}}});
  }
  if (stream.duration > 0)
    facts.duration_s = static_cast<double>(stream.duration) * av_q2d(stream.time_base);
  else if (streams->format->duration > 0)
    facts.duration_s = static_cast<double>(streams->format->duration) / AV_TIME_BASE;
  facts.created_at = CreatedAt(*streams->format);
  VideoFile file(std::move(streams));
  file.facts_ = facts;
  return file;
}

Result<bool> VideoFile::Next() {
  for (;;) {
    const int received = avcodec_receive_frame(streams_->codec.get(), streams_->current.get());
    if (received == 0) {
      const AVFrame& frame = *streams_->current;
      if (streams_->first_pts == AV_NOPTS_VALUE) streams_->first_pts = frame.best_effort_timestamp;
      ++streams_->number;
      return true;
    }
    if (received == AVERROR_EOF) {
      if (streams_->number < 0) return Damaged(streams_->path, "not one frame came out");
      return false;
    }
    if (received == AVERROR(ENOMEM)) throw std::bad_alloc();
    if (streams_->is_drained)
      return streams_->number < 0 ? Result<bool>(Damaged(streams_->path, Words(received))) : false;
    streams_->Feed();
  }
}

double VideoFile::time_s() const { return streams_->TimeOf(*streams_->current); }
std::int64_t VideoFile::number() const { return streams_->number; }

Result<GrayFrame> VideoFile::Gray(int width_px) {
  const AVFrame& frame = *streams_->current;
  SKYQUILT_CHECK(frame.width > 0, "Precondition: Next gave a frame");
  GrayFrame gray;
  gray.width_px = std::min(width_px, frame.width);
  gray.height_px = std::max(
      1, static_cast<int>(std::lround(static_cast<double>(frame.height) * gray.width_px / frame.width)));
  gray.gray.resize(static_cast<std::size_t>(gray.width_px) * static_cast<std::size_t>(gray.height_px));
  SKYQUILT_TRY(streams_->Scale(frame, streams_->to_gray, gray.width_px, gray.height_px, AV_PIX_FMT_GRAY8,
                               gray.gray.data(), gray.width_px));
  return gray;
}

void VideoFile::Keep() {
  av_frame_unref(streams_->kept.get());
  if (av_frame_ref(streams_->kept.get(), streams_->current.get()) < 0) throw std::bad_alloc();
}

Result<image::DecodedImage> VideoFile::Kept() {
  const AVFrame& frame = *streams_->kept;
  SKYQUILT_CHECK(frame.width > 0, "Precondition: Keep was called");
  image::DecodedImage image;
  image.width_px = frame.width;
  image.height_px = frame.height;
  image.rgb.resize(3 * static_cast<std::size_t>(frame.width) * static_cast<std::size_t>(frame.height));
  SKYQUILT_TRY(streams_->Scale(frame, streams_->to_rgb, frame.width, frame.height, AV_PIX_FMT_RGB24,
                               image.rgb.data(), 3 * frame.width));
  return image;
}

Result<std::string> VideoFile::Subtitles(const std::filesystem::path& path) {
  constexpr std::size_t kMaxBytes = std::size_t{64} << 20;
  SKYQUILT_TRY_ASSIGN(const Format format, OpenFormat(path));
  const int track = av_find_best_stream(format.get(), AVMEDIA_TYPE_SUBTITLE, -1, -1, nullptr, 0);
  if (track < 0) return std::string();
  for (unsigned i = 0; i < format->nb_streams; ++i)
    format->streams[i]->discard = static_cast<int>(i) == track ? AVDISCARD_DEFAULT : AVDISCARD_ALL;
  const AVStream& stream = *format->streams[track];
  const Packet packet = Owned<Packet>(av_packet_alloc());
  const auto stamp = [](double time_s) {
    const auto ms = static_cast<std::int64_t>(std::llround(1e3 * std::max(0.0, time_s)));
    return fmt::format("{:02}:{:02}:{:02},{:03}", ms / 3'600'000, ms / 60'000 % 60, ms / 1000 % 60,
                       ms % 1000);
  };
  std::string text;
  for (int cue = 1; text.size() < kMaxBytes && av_read_frame(format.get(), packet.get()) >= 0;) {
    if (packet->stream_index == track && packet->size > 0 && packet->pts != AV_NOPTS_VALUE) {
      std::string_view said(reinterpret_cast<const char*>(packet->data),
                            static_cast<std::size_t>(packet->size));
      // 3GPP timed text puts the length before the words and styles behind them.
      if (stream.codecpar->codec_id == AV_CODEC_ID_MOV_TEXT && said.size() >= 2) {
        const std::size_t size = static_cast<std::size_t>(packet->data[0]) << 8 | packet->data[1];
        said = said.substr(2, size);
      }
      const double start_s = static_cast<double>(packet->pts) * av_q2d(stream.time_base);
      const double end_s = start_s + static_cast<double>(packet->duration) * av_q2d(stream.time_base);
      if (!said.empty()) {
        text += fmt::format("{}\n{} --> {}\n{}\n\n", cue, stamp(start_s), stamp(end_s), said);
        ++cue;
      }
    }
    av_packet_unref(packet.get());
  }
  return text;
}

}  // namespace skyquilt::video
