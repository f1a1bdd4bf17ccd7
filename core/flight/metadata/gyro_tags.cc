#include "core/flight/metadata/gyro_tags.h"

#include <cmath>
#include <cstddef>
#include <cstdint>

#include "core/flight/bytes/log_bytes.h"
#include "core/flight/metadata/base64.h"

namespace skyquilt::flight {
namespace {

constexpr std::size_t kRecordBytes = 24;
constexpr std::size_t kMaxRecords = 4096;
constexpr double kFastestRadps = 35.0;  // the range of the gyros in cameras: 2000 degrees per second
constexpr double kLongestGapS = 0.02;   // between records: no shaking may be missed
constexpr double kMaxOffsetS = 1.0;     // from the first record to the first row

// The gyro's axes are the body's (x ahead, y right, z down) of a camera that looks down with its image top
// ahead, as its angles are recorded too.
Eigen::Vector3d InCam(const Eigen::Vector3d& in_body) { return {in_body.y(), -in_body.x(), in_body.z()}; }

}  // namespace

std::optional<RecordedTurning> TurningFromTags(const XmpTags& xmp, std::vector<Remark>& notes) {
  const std::string* text = xmp.Find("Camera:IMUAngularVelocity");
  if (text == nullptr || text->empty()) return std::nullopt;
  const auto refuse = [&](RemarkCode why) -> std::optional<RecordedTurning> {
    notes.push_back({RemarkCode::kGyroNotUsed, {{"why", Remark(why)}}});
    return std::nullopt;
  };
  const auto offset_ns = xmp.Number("Camera:IMUTimeOffset");
  const double offset_s = 1e-9 * offset_ns.value_or(0.0);
  const bool is_odd = !offset_ns && xmp.Find("Camera:IMUTimeOffset") != nullptr;
  if (is_odd || std::abs(offset_s) > kMaxOffsetS) return refuse(RemarkCode::kGyroAtImpossibleTime);
  const auto bytes = FromBase64(*text, kRecordBytes * kMaxRecords);
  if (!bytes || bytes->size() % kRecordBytes != 0) return refuse(RemarkCode::kGyroDamaged);
  if (bytes->size() < 2 * kRecordBytes) return refuse(RemarkCode::kGyroTooShort);
  RecordedTurning turning;
  const auto first_us = LoadLittle<std::uint64_t>(bytes->data());
  for (std::size_t at = 0; at < bytes->size(); at += kRecordBytes) {
    const std::uint8_t* record = bytes->data() + at;
    const auto us = LoadLittle<std::uint64_t>(record);
    Eigen::Vector3d in_body;
    for (int axis = 0; axis < 3; ++axis)
      in_body[axis] = LoadLittle<float>(record + 8 + std::ptrdiff_t{4} * axis);
    // Compared so that no NaN passes.
    if (!(in_body.cwiseAbs().maxCoeff() <= kFastestRadps) || !in_body.allFinite())
      return refuse(RemarkCode::kGyroImpossibleRates);
    if (us < first_us) return refuse(RemarkCode::kGyroBackwards);
    const double time_s = 1e-6 * static_cast<double>(us - first_us) - offset_s;
    if (!turning.samples.empty()) {
      const double step_s = time_s - turning.samples.back().time_s;
      if (!(step_s > 0.0)) return refuse(RemarkCode::kGyroBackwards);
      if (step_s > kLongestGapS) return refuse(RemarkCode::kGyroWithGaps);
    }
    turning.samples.push_back({time_s, InCam(in_body)});
  }
  return turning;
}

}  // namespace skyquilt::flight
