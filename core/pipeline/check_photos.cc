#include "core/pipeline/check_photos.h"

#include <fmt/core.h>

#include <algorithm>
#include <atomic>
#include <nlohmann/json.hpp>
#include <utility>

#include "core/alignment/scene/matches.h"
#include "core/base/parallel_for.h"
#include "core/base/scoped_timer.h"
#include "core/base/trace.h"
#include "core/base/try.h"
#include "core/flight/read_flight.h"
#include "core/flight/remarks/because.h"
#include "core/pipeline/place_flight.h"
#include "core/pipeline/report/cbor_values.h"

namespace skyquilt::pipeline {

namespace {

Result<CheckedPhoto> Check(const flight::Photo& photo, const flight::PhotoSource& source,
                           bool with_features) {
  int denominator = render::ThumbnailDenominator(photo);
  if (with_features) denominator = std::min(denominator, alignment::DenominatorOf(photo));
  double decode_s = 0.0;
  SKYQUILT_TRY_ASSIGN(const image::DecodedImage decoded, [&] {
    const TraceSpan span("decode small", photo.name);
    ScopedTimer timer(decode_s);
    return source.Decode(photo, denominator);
  }());
  const TraceSpan span("thumbnail and features", photo.name);
  CheckedPhoto checked{render::MakeThumbnail(photo, decoded), {}};
  if (!with_features) return checked;
  // A photo too small for features is a matter of the alignment, not of whether it is damaged.
  if (auto found = alignment::FeaturesOf(photo, decoded)) {
    checked.features = *std::move(found);
    checked.features->decode_s = decode_s;
  }
  return checked;
}

}  // namespace

Result<CheckedFlight> CheckPhotos(flight::Flight flight, const flight::PhotoSource& source,
                                  bool with_features, int threads, Progress& progress, CheckedPhotos known) {
  const std::size_t count = flight.photos.size();
  std::vector<std::optional<Result<CheckedPhoto>>> made(count);
  std::atomic<std::size_t> done{0};
  ParallelFor(count, threads, [&](std::size_t i) {
    if (progress.IsCancelled()) return;
    if (const auto found = known.find(flight.photos[i].name); found != known.end()) {
      made[i] = std::move(found->second);  // names are unique: no other thread takes this one
      ++done;
      return;
    }
    made[i] = Check(flight.photos[i], source, with_features);
    const std::size_t finished = ++done;
    progress.Report(static_cast<double>(finished) / static_cast<double>(count),
                    fmt::format("photo {} of {}", finished, count));
  });
  if (progress.IsCancelled()) return Error{ErrorCode::kCancelled, "The job was cancelled.", ""};
  std::vector<flight::Photo> photos = std::move(flight.photos);
  CheckedFlight checked;
  checked.flight = std::move(flight);  // the logs and all else as they are
  checked.flight.photos.clear();
  for (std::size_t i = 0; i < count; ++i) {
    if (made[i]->ok()) {
      checked.flight.photos.push_back(std::move(photos[i]));
      CheckedPhoto& one = **made[i];
      checked.thumbnails.push_back(std::move(one.thumbnail));
      if (one.features) checked.features.emplace(checked.flight.photos.back().name, *std::move(one.features));
    } else {
      checked.flight.left_out.push_back(
          {photos[i].name, made[i]->error().code, flight::WhyOf(made[i]->error())});
    }
  }
  return checked;
}

namespace {

using Cbor = nlohmann::json;

// Raised whenever the meaning, a name or what is found changes.
constexpr int kFoundVersion = 2;

[[noreturn]] void ThrowOfFound(const char* what) { throw Cbor::other_error::create(500, what, nullptr); }

Cbor OfFeatures(const alignment::PhotoFeatures& features) {
  return {{"keypoints", CborOfValues<Cbor>(features.keypoints)},
          {"descriptors", CborOfValues<Cbor>(features.descriptors)},
          {"width_px", features.thumbnail.width_px},
          {"height_px", features.thumbnail.height_px},
          {"grey", CborOfValues<Cbor>(features.thumbnail.grey)},
          {"sigma_px", features.sigma_px},
          {"detail", CborOfValues<Cbor>(features.detail)},
          {"decode_s", features.decode_s},
          {"detect_s", features.detect_s}};
}

alignment::PhotoFeatures ToFeatures(const Cbor& json) {
  alignment::PhotoFeatures features;
  features.keypoints = ValuesOfCbor<alignment::Keypoint>(json.at("keypoints"));
  features.descriptors = ValuesOfCbor<alignment::Descriptor>(json.at("descriptors"));
  features.thumbnail = {json.at("width_px"), json.at("height_px"),
                        ValuesOfCbor<std::uint8_t>(json.at("grey"))};
  features.sigma_px = json.at("sigma_px");
  features.detail = ValuesOfCbor<alignment::DetailCell>(json.at("detail"));
  features.decode_s = json.at("decode_s");
  features.detect_s = json.at("detect_s");
  const auto& thumbnail = features.thumbnail;
  constexpr int kMaxSidePx = 1 << 14;
  const std::size_t cells = features.detail.size();
  constexpr std::size_t kWholeDetail = std::size_t{alignment::kDetailCells} * alignment::kDetailCells;
  if (cells != 0 && cells != kWholeDetail) ThrowOfFound("the detail of a picture is not of its size");
  if (features.keypoints.size() > alignment::kMaxKeypoints)
    ThrowOfFound("more keypoints than can be matched");
  if (features.descriptors.size() != features.keypoints.size()) ThrowOfFound("a keypoint is not described");
  if (thumbnail.width_px < 0 || thumbnail.height_px < 0 || thumbnail.width_px > kMaxSidePx ||
      thumbnail.height_px > kMaxSidePx ||
      thumbnail.grey.size() != static_cast<std::size_t>(thumbnail.width_px) * thumbnail.height_px) {
    ThrowOfFound("a picture is not of its size");
  }
  return features;
}

void ParseFiles(std::string_view bytes, FoundFiles& found) {
  const Cbor json = Cbor::from_cbor(bytes);
  if (json.at("version") != kFoundVersion) ThrowOfFound("another version wrote it");
  for (const Cbor& file : json.at("files")) {
    std::string name = TextOfCbor(file.at("name"));
    found.digests[name] = DigestOfCbor(file.at("digest"));
    if (!file.contains("jpeg")) continue;
    CheckedPhoto photo;
    photo.thumbnail = {name, file.at("width_px"), file.at("height_px"), file.at("jpeg").get_binary()};
    if (file.contains("features")) photo.features = ToFeatures(file.at("features"));
    found.photos.insert_or_assign(std::move(name), std::move(photo));
  }
}

}  // namespace

Result<FoundFiles> FindInPhotos(const std::vector<flight::InputFile>& files, const MosaicOptions& options,
                                const flight::PhotoSource& source, Progress& progress) {
  std::vector<std::optional<flight::Photo>> photos(files.size());
  std::vector<std::optional<Digest>> digests(files.size());
  ParallelFor(files.size(), options.threads, [&](std::size_t i) {
    if (auto digest = DigestOfFile(files[i].path)) digests[i] = *digest;
    if (auto photo = flight::ReadPhoto(files[i])) photos[i] = *std::move(photo);
  });
  FoundFiles found;
  flight::Flight part;
  for (std::size_t i = 0; i < files.size(); ++i) {
    if (digests[i]) found.digests.emplace(files[i].name, *digests[i]);
    // Photos that are drawn in a range of the whole flight are looked at where the whole flight is.
    if (photos[i] && photos[i]->sample_kind == flight::SampleKind::kBytes)
      part.photos.push_back(*std::move(photos[i]));
  }
  SKYQUILT_TRY_ASSIGN(CheckedFlight checked, CheckPhotos(std::move(part), source, MayGoByImages(options),
                                                         options.threads, progress));
  for (std::size_t i = 0; i < checked.flight.photos.size(); ++i) {
    const std::string& name = checked.flight.photos[i].name;
    CheckedPhoto photo{std::move(checked.thumbnails[i]), {}};
    if (const auto features = checked.features.find(name); features != checked.features.end())
      photo.features = std::move(features->second);
    found.photos.emplace(name, std::move(photo));
  }
  return found;
}

std::string WriteFound(const FoundFiles& found) {
  Cbor files = Cbor::array();
  for (const auto& [name, digest] : found.digests) {
    Cbor file = {{"name", CborOfText<Cbor>(name)}, {"digest", CborOfDigest<Cbor>(digest)}};
    if (const auto photo = found.photos.find(name); photo != found.photos.end()) {
      const render::Thumbnail& thumbnail = photo->second.thumbnail;
      file["width_px"] = thumbnail.width_px;
      file["height_px"] = thumbnail.height_px;
      file["jpeg"] = CborOfValues<Cbor>(thumbnail.jpeg);
      if (photo->second.features) file["features"] = OfFeatures(*photo->second.features);
    }
    files.push_back(std::move(file));
  }
  const std::vector<std::uint8_t> bytes =
      Cbor::to_cbor({{"version", kFoundVersion}, {"files", std::move(files)}});
  return {bytes.begin(), bytes.end()};
}

Result<void> ParseFound(std::string_view bytes, FoundFiles& found) {
  try {
    ParseFiles(bytes, found);
    return {};
  } catch (const Cbor::exception& broken) {
    return Error{ErrorCode::kCorrupt,
                 "What was found in some of the photos is damaged. Stitch the flight again.", broken.what()};
  }
}

}  // namespace skyquilt::pipeline
