// Which of several rows of one photo holds, and what is said of the others.
#include "core/poses/lists/choose_rows.h"

#include <chrono>

#include "core/poses/photo_rows.h"
#include "core/poses/time/join_logs.h"
#include "tests/core/poses/listed_flight.h"

namespace skyquilt::poses {
namespace {

using Sigma = std::optional<Eigen::Vector3d>;

constexpr int kListed = 12;
const Sigma kCentimetres = Eigen::Vector3d(0.02, 0.02, 0.03);

LatLon EastOfPhoto(int k, double east_m) { return Beside(TakenAt(kZurich, k), east_m, 0.0); }

Flight Flown(std::vector<FlightLog> lists = {}) {
  Flight flight = FlightAt(kZurich, kListed);
  flight.logs = std::move(lists);
  return flight;
}

void AddRows(double east_m, const Sigma& sigma_in_ned_m, FlightLog& list) {
  for (int k = 0; k < kListed; ++k) {
    const LatLon at = EastOfPhoto(k, east_m);
    flight::CameraEvent& row = list.events.emplace_back();
    row.has_time = false;
    row.image_name = NameOf(k);
    row.written = AsDegrees(at);
    row.position = at;
    row.sigma_in_ned_m = sigma_in_ned_m;
  }
}

FlightLog NamedList(const std::string& name, double east_m, const Sigma& sigma_in_ned_m = {}) {
  FlightLog list;
  list.format = "geo_txt";
  list.file_name = name;
  list.written_system = "EPSG:4326";
  AddRows(east_m, sigma_in_ned_m, list);
  return list;
}

// As EstimatePoses has them.
void TakeLists(Flight& flight) {
  ASSERT_TRUE(CompareSources(flight).ok());
  ApplyPhotoRows(flight.logs, flight.photos);
}

void ExpectStand(const Flight& flight, double east_m, const std::string& source) {
  for (int k = 0; k < kListed; ++k) {
    const auto& position = flight.photos[static_cast<std::size_t>(k)].position;
    ASSERT_TRUE(position);
    EXPECT_LT(geo::MetresApart(position->position, EastOfPhoto(k, east_m)), 0.1) << k;
    EXPECT_EQ(position->source, source);
  }
}

const flight::ListUse& UseOf(const Flight& flight, const std::string& name) {
  for (const flight::ListUse& use : flight.list_uses) {
    if (use.file_name == name) return use;
  }
  ADD_FAILURE() << name;
  return flight.list_uses.front();
}

TEST(ChooseRows, TakesTheListOfBetterAccuracyWhateverTheFilesAreCalled) {
  for (const auto& [better, other] : {std::pair{"a.csv", "b.csv"}, {"b.csv", "a.csv"}}) {
    Flight flight = Flown({NamedList(better, 1.0, kCentimetres), NamedList(other, 30.0)});
    if (std::string(better) > other) std::swap(flight.logs[0], flight.logs[1]);
    TakeLists(flight);
    ExpectStand(flight, 1.0, better);
    EXPECT_EQ(UseOf(flight, better).rows_used, 12u);
    EXPECT_EQ(UseOf(flight, other).rows_used, 0u);
    EXPECT_THAT(UseInWords(UseOf(flight, other)),
                HasSubstr(std::string("0 of 12 rows used (those of ") + better + " hold)"));
    EXPECT_THAT(InWords(flight.warnings), Contains(HasSubstr("both say where 12 photos were taken")));
    EXPECT_THAT(InWords(flight.warnings), Contains(HasSubstr("for its accuracy is the better one")));
  }
}

TEST(ChooseRows, TakesTheNearerListWhereNoneSaysHowGoodItIs) {
  for (const double first_east_m : {3.0, 30.0}) {
    Flight flight = Flown({NamedList("a.txt", first_east_m), NamedList("b.txt", 33.0 - first_east_m)});
    TakeLists(flight);
    ExpectStand(flight, 3.0, first_east_m < 10.0 ? "a.txt" : "b.txt");
    EXPECT_THAT(InWords(flight.warnings), Contains(HasSubstr("nearer to the photos' own positions")));
  }
}

TEST(ChooseRows, SaysNothingOfListsThatAgree) {
  Flight flight = Flown({NamedList("a.txt", 1.0), NamedList("b.txt", 2.0)});
  TakeLists(flight);
  ExpectStand(flight, 1.0, "a.txt");
  EXPECT_TRUE(flight.warnings.empty());
}

// By chance each of the two is the nearer one of every second photo.
TEST(ChooseRows, LetsNoNeighboursHangOnDifferentLists) {
  Flight flight = Flown({NamedList("a.txt", 3.0), NamedList("b.txt", -3.0)});
  for (int k = 0; k < kListed; ++k)
    flight.photos[static_cast<std::size_t>(k)].position->position = EastOfPhoto(k, k % 2 == 0 ? 4.0 : -4.0);
  TakeLists(flight);
  for (const flight::Photo& photo : flight.photos)
    EXPECT_EQ(photo.position->source, flight.photos[0].position->source);
}

TEST(ChooseRows, TakesOneOfTwoSolutionsInOneFileAndCountsItAlone) {
  for (const bool is_better_first : {true, false}) {
    FlightLog list = NamedList("geo.txt", is_better_first ? 0.5 : 12.0);
    AddRows(is_better_first ? 12.0 : 0.5, {}, list);
    Flight flight = Flown({list});
    TakeLists(flight);
    ExpectStand(flight, 0.5, "geo.txt");
    EXPECT_EQ(UseOf(flight, "geo.txt").rows, 24u);
    EXPECT_EQ(UseOf(flight, "geo.txt").rows_used, 12u);
    EXPECT_THAT(InWords(flight.warnings), Contains(HasSubstr("12 rows name photos that other rows")));
  }
}

TEST(ChooseRows, TakesARowOfAFixBeforeOneWithoutInABetterList) {
  Flight flight = Flown(
      {NamedList("a.txt", 1.0, kCentimetres), NamedList("b.txt", 1.5, Eigen::Vector3d(0.05, 0.05, 0.1))});
  flight.logs[0].events[3].sigma_in_ned_m = Eigen::Vector3d(2.0, 2.0, 3.0);
  TakeLists(flight);
  EXPECT_EQ(flight.photos[2].position->source, "a.txt");
  EXPECT_EQ(flight.photos[3].position->source, "b.txt");
}

TEST(JoinLogs, TakesTheListThatKeptItsPositions) {
  std::vector<FlightLog> logs = {NamedList("a.txt", 1.0), NamedList("b.txt", 2.0)};
  for (FlightLog& log : logs) {
    log.utc_at_zero = flight::UtcTime(std::chrono::seconds(1'717'243'200));
    for (std::size_t k = 0; k < log.events.size(); ++k) {
      log.events[k].has_time = true;
      log.events[k].t_s = static_cast<double>(k);
    }
  }
  for (flight::CameraEvent& event : logs[0].events) event.position.reset();
  const auto joined = JoinLogs(logs, {});
  ASSERT_TRUE(joined);
  EXPECT_TRUE(joined->log.events.front().position);
}

}  // namespace
}  // namespace skyquilt::poses
