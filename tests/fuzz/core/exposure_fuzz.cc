// libFuzzer: EstimateExposure of flights and pictures of any kind. Checked: gains that pixels can be
// multiplied with.
#include "core/base/check.h"
#include "core/render/exposure/estimate_exposure.h"
#include "tests/fuzz/core/flight_from_bytes.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace skyquilt;
  fuzz::Bytes bytes(data, size);
  const alignment::AlignedFlight flight = fuzz::PlausibleFlightFrom(bytes);
  const auto thumbnails = fuzz::ThumbnailsFrom(bytes, flight);
  const auto ground = ground::GroundSurface::Plane(0.0);
  const render::ExposureModel model = render::EstimateExposure(flight, ground, thumbnails);
  SKYQUILT_CHECK(model.tones.size() == flight.photos.size(), "a photo without a tone");
  for (const render::PhotoTone& tone : model.tones) {
    for (const double gain : tone.gain) SKYQUILT_CHECK(gain > 0.0 && gain < 100.0, "an impossible gain");
    for (const auto& channel : tone.shade.terms) {
      for (const float term : channel) SKYQUILT_CHECK(std::isfinite(term), "an impossible shade");
    }
  }
  if (flight.photos.size() > 1) {
    render::KnownExposure known{model.light, model.photos};
    known.photos.pop_back();
    SKYQUILT_CHECK(
        render::ExtendExposure(flight, ground, thumbnails, known).tones.size() == flight.photos.size(),
        "a photo without a tone");
  }
  return 0;
}
