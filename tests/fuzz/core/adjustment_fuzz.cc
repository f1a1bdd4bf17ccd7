// libFuzzer: the whole alignment of flights and pictures of any kind. Checked: it ends, and
// what comes out and is plausible has a pose of numbers.
#include <map>

#include "core/alignment/align_flight.h"
#include "core/base/check.h"
#include "tests/fuzz/core/flight_from_bytes.h"

namespace {

using namespace skyquilt;

class Pictures final : public flight::PhotoSource {
 public:
  Pictures(fuzz::Bytes& bytes, const alignment::AlignedFlight& flight) {
    for (const alignment::AlignedPhoto& photo : flight.photos) {
      pictures_[photo.photo.name] =
          fuzz::PictureFrom(bytes, photo.intrinsics.width_px, photo.intrinsics.height_px);
    }
  }
  Result<image::DecodedImage> Decode(const flight::Photo& photo, int denominator) const override {
    const image::DecodedImage& whole = pictures_.at(photo.name);
    image::DecodedImage image;
    image.width_px = (whole.width_px + denominator - 1) / denominator;
    image.height_px = (whole.height_px + denominator - 1) / denominator;
    for (int y = 0; y < image.height_px; ++y) {
      for (int x = 0; x < image.width_px; ++x) {
        const std::uint8_t* pixel = whole.Row(y * denominator) + 3 * x * denominator;
        image.rgb.insert(image.rgb.end(), pixel, pixel + 3);
      }
    }
    return image;
  }

 private:
  std::map<std::string, image::DecodedImage> pictures_;
};

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  fuzz::Bytes bytes(data, size);
  const alignment::AlignedFlight made = fuzz::FlightFrom(bytes);
  const Pictures pictures(bytes, made);
  poses::PosedFlight posed;
  posed.frame = made.frame;
  for (const alignment::AlignedPhoto& photo : made.photos) {
    poses::PosedPhoto one;
    one.photo = photo.photo;
    one.cam_from_enu = photo.cam_from_enu;
    one.height_above_ground_m = photo.height_above_ground_m;
    one.covariance = poses::Matrix6d::Identity() * (bytes.Below(4) == 0 ? 0.0 : 0.01);
    one.error_radius_m = 1.0;
    posed.photos.push_back(std::move(one));
  }
  // As EstimatePoses hands them on.
  poses::LeaveOutImplausible(
      posed.frame,
      [](const poses::PosedPhoto& photo) {
        return poses::CameraStand{photo.photo.intrinsics, photo.cam_from_enu, photo.height_above_ground_m};
      },
      posed.photos, posed.left_out);
  if (posed.photos.empty()) return 0;
  alignment::AlignOptions options;
  options.threads = 1;
  SilentProgress progress;
  alignment::AlignReport report;
  const auto aligned = alignment::AlignFlight(posed, pictures, options, report, progress);
  if (!aligned) SKYQUILT_CHECK(aligned.error().message.size() > 20, "a refusal without a reason");
  return 0;
}
