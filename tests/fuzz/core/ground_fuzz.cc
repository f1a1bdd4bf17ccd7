// libFuzzer: ModelGround of flights and tie points of any kind. Checked: a surface whose height is known
// wherever it is asked, of bounded size.
#include "core/base/check.h"
#include "core/ground/model_ground.h"
#include "tests/fuzz/core/flight_from_bytes.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace skyquilt;
  fuzz::Bytes bytes(data, size);
  const alignment::AlignedFlight flight = fuzz::PlausibleFlightFrom(bytes);
  ground::ModelGroundReport report;
  const ground::GroundSurface surface = ground::ModelGround(flight, report);
  SKYQUILT_CHECK(surface.IsPlane() || surface.Heights().size() < (std::size_t{1} << 24), "a huge grid");
  for (const Eigen::Vector2d& place : {Eigen::Vector2d(0.0, 0.0), Eigen::Vector2d(1e9, -1e9)})
    SKYQUILT_CHECK(std::isfinite(surface.HeightAt(place)), "a ground without a height");
  return 0;
}
