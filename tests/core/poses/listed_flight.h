// A flight of lines of photos, and lists of it as others write them.
#pragma once

#include <gmock/gmock.h>

#include <cmath>
#include <string>
#include <utility>

#include "core/flight/remarks/remark_words.h"
#include "core/geo/crs/map_projection.h"
#include "core/geo/geodesic.h"
#include "core/poses/lists/compare_sources.h"
#include "core/poses/lists/list_words.h"

namespace skyquilt::poses {

using flight::Flight;
using flight::FlightLog;
using flight::ListFault;
using geo::LatLon;
using ::testing::Contains;
using ::testing::HasSubstr;

inline constexpr LatLon kDuluth{46.8426, -91.9945};
inline constexpr LatLon kZurich{47.4, 8.5};
inline constexpr LatLon kSydney{-33.86, 151.21};
inline constexpr LatLon kLaPaz{-16.5, -68.15};

inline LatLon Beside(const LatLon& place, double east_m, double north_m) {
  const double lat_deg = place.lat_deg + north_m / 111'200.0;
  return {lat_deg, place.lon_deg + east_m / (111'320.0 * std::cos(geo::DegToRad(lat_deg)))};
}

// Lines of six photos, 20 m apart, there and back; no symmetric layout.
inline LatLon TakenAt(const LatLon& place, int k) {
  const int line = k / 6, along = line % 2 == 0 ? k % 6 : 5 - k % 6;
  return Beside(place, 20.0 * along + 3.0 * line, 31.0 * line + 1.5 * along);
}

inline std::string NameOf(int k) { return "DJI_" + std::to_string(100 + k) + ".JPG"; }

inline Flight FlightAt(const LatLon& place, int count = 18, bool has_positions = true) {
  Flight flight;
  for (int k = 0; k < count; ++k) {
    flight::Photo& photo = flight.photos.emplace_back();
    photo.name = NameOf(k);
    if (has_positions) photo.position.emplace().position = TakenAt(place, k);
  }
  return flight;
}

// A list of the flight as `write` puts each place.
template <typename Write>
FlightLog ListOf(const LatLon& place, int count, const Write& write, const std::string& system = "",
                 const std::string& format = "geo_txt") {
  FlightLog log;
  log.format = format;
  log.file_name = "list.txt";
  log.written_system = system;
  for (int k = 0; k < count; ++k) {
    flight::CameraEvent& event = log.events.emplace_back();
    event.t_s = k;
    event.has_time = false;
    event.image_name = NameOf(k);
    event.written = write(Beside(TakenAt(place, k), 4.0, 0.0));
    const auto plain = LatLon::Make(event.written->y, event.written->x);
    if (plain) event.position = *plain;
    event.yaw_pitch_roll_rad = Eigen::Vector3d(0.1, 0.2, 0.3);
  }
  return log;
}

inline flight::WrittenPlace AsDegrees(const LatLon& at) { return {at.lon_deg, at.lat_deg}; }
inline flight::WrittenPlace AsLatLon(const LatLon& at) { return {at.lat_deg, at.lon_deg}; }

// In a system of metres or feet.
inline auto In(int epsg) {
  return [epsg](const LatLon& at) {
    const auto there = geo::MapProjection::OfEpsg(epsg)->PlaceOf(at);
    return flight::WrittenPlace{there->x(), there->y()};
  };
}

template <typename Write>
auto NorthFirst(const Write& write) {
  return [write](const LatLon& at) {
    const flight::WrittenPlace there = write(at);
    return flight::WrittenPlace{there.y, there.x};
  };
}

// A flight after a list was held against it.
inline Flight Compared(Flight flight, FlightLog list) {
  flight.logs = {std::move(list)};
  EXPECT_TRUE(CompareSources(flight).ok());
  return flight;
}
inline Flight Compared(const LatLon& place, FlightLog list, bool has_positions = true) {
  return Compared(FlightAt(place, 18, has_positions), std::move(list));
}

// Every row 4 m east of the photos, whatever was written.
inline void ExpectTaken(const Flight& flight, const LatLon& place, const std::string& what) {
  ASSERT_EQ(flight.list_uses.size(), 1u) << what;
  EXPECT_EQ(flight.list_uses[0].fault, ListFault::kNone) << what << UseInWords(flight.list_uses[0]);
  EXPECT_EQ(flight.list_uses[0].rows_used, flight.logs[0].events.size()) << what;
  for (std::size_t k = 0; k < flight.logs[0].events.size(); ++k) {
    const auto& at = flight.logs[0].events[k].position;
    ASSERT_TRUE(at) << what;
    EXPECT_LT(geo::MetresApart(*at, Beside(TakenAt(place, static_cast<int>(k)), 4.0, 0.0)), 1.0) << what;
  }
}

inline void ExpectRefused(const Flight& flight, ListFault fault, const std::string& words) {
  ASSERT_EQ(flight.list_uses.size(), 1u);
  EXPECT_EQ(flight.list_uses[0].fault, fault);
  EXPECT_THAT(InWords(flight.warnings), Contains(HasSubstr(words)));
  for (const flight::CameraEvent& event : flight.logs[0].events) {
    EXPECT_FALSE(event.position);
    EXPECT_FALSE(event.yaw_pitch_roll_rad) << "angles of another flight are as wrong";
  }
}

}  // namespace skyquilt::poses
