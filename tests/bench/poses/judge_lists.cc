// What it costs to judge a list of 1,000 photos before it is believed; the bar is 50 ms. The list as ODM
// writes it, degrees below a system of metres, and one that nothing else places.
#include <benchmark/benchmark.h>
#include <fmt/format.h>

#include <string>

#include "core/flight/logs/read_log.h"
#include "core/geo/local_frame.h"
#include "core/poses/lists/compare_sources.h"

namespace skyquilt::poses {
namespace {

constexpr int kPhotos = 1000;
constexpr geo::LatLon kField{47.4, 8.5};

flight::Flight FlightWithList(std::string_view system, bool with_positions) {
  flight::Flight flight;
  std::string text = fmt::format("{}\n", system);
  const geo::LocalFrame frame({kField.lat_deg, kField.lon_deg, 500.0});
  for (int k = 0; k < kPhotos; ++k) {
    const geo::Wgs84 at = frame.Wgs84FromEnu({20.0 * (k % 32), 20.0 * (k / 32), 60.0});
    flight::Photo photo;
    photo.name = fmt::format("DJI_{:04}.JPG", k);
    if (with_positions) {
      photo.position.emplace();
      photo.position->position = {at.lat_deg, at.lon_deg};
    }
    flight.photos.push_back(std::move(photo));
    text +=
        fmt::format("DJI_{:04}.JPG {:.8f} {:.8f} {:.3f}\n", k, at.lon_deg, at.lat_deg, at.height_ellipsoid_m);
  }
  auto log = flight::ParseLog("geo.txt", {reinterpret_cast<const std::uint8_t*>(text.data()), text.size()});
  if (log) flight.logs.push_back(*std::move(log));
  return flight;
}

void JudgeList1000(benchmark::State& state, std::string_view system, bool with_positions) {
  const flight::Flight given = FlightWithList(system, with_positions);
  for (auto _ : state) {
    state.PauseTiming();
    flight::Flight flight = given;
    state.ResumeTiming();
    benchmark::DoNotOptimize(CompareSources(flight).ok());
  }
  state.counters["lists"] = static_cast<double>(given.logs.size());
}
BENCHMARK_CAPTURE(JudgeList1000, as_written, "EPSG:4326", true)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(JudgeList1000, degrees_below_metres, "EPSG:32632", true)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(JudgeList1000, nothing_else_places_it, "EPSG:4326", false)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace skyquilt::poses

BENCHMARK_MAIN();
