// libFuzzer: EstimateExposure of flights and pictures of any kind. Checked: gains that pixels can be
// multiplied with.
#include <cstdint>

#include "core/base/check.h"
#include "core/render/exposure/estimate_exposure.h"
#include "core/render/exposure/extend_exposure.h"
#include "tests/fuzz/core/flight_from_bytes.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace skyquilt;
  fuzz::Bytes bytes(data, size);
  const alignment::AlignedFlight flight = fuzz::PlausibleFlightFrom(bytes);
  const auto thumbnails = fuzz::ThumbnailsFrom(bytes, flight);
  const auto ground = ground::GroundSurface::Plane(0.0);
  const render::ExposureModel model = render::EstimateExposure(flight, ground, thumbnails);
  SKYQUILT_CHECK(model.photos.size() == flight.photos.size(), "a photo without a tone");
  for (const render::PhotoTone& tone : model.photos) {
    for (const double gain : tone.gain) SKYQUILT_CHECK(gain > 0.0 && gain < 100.0, "an impossible gain");
  }
  if (flight.photos.size() > 1) {
    const std::vector<render::PhotoTone> known(model.photos.begin(), model.photos.end() - 1);
    SKYQUILT_CHECK(
        render::ExtendExposure(flight, ground, thumbnails, known).photos.size() == flight.photos.size(),
        "a photo without a tone");
  }
  return 0;
}
