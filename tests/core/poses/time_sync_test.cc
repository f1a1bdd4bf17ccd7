#include "core/poses/time/time_sync.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <random>
#include <utility>

#include "core/geo/local_frame.h"
#include "core/poses/time/event_alignment.h"
#include "tests/support/value_of.h"

namespace skyquilt::poses {
namespace {

using flight::CameraEvent;
using flight::FlightLog;
using flight::Photo;
using flight::UtcTime;
using test::ErrorOf;
using test::ValueOf;

constexpr double kZeroUnixS = 1.7e9;  // UTC at the log's zero

// A survey of back-and-forth legs that slows down into its turns.
struct Survey {
  std::vector<double> track_s;  // 20 Hz from t = 100 s
  std::vector<Eigen::Vector2d> track_m;
  std::vector<double> exposures_s;
  std::vector<Eigen::Vector2d> exposures_m;
};

Survey Fly(unsigned seed, bool by_distance, double interval) {
  std::mt19937 random(seed);
  std::normal_distribution<double> noise(0.0, 1.0);
  Survey survey;
  Eigen::Vector2d position(0.0, 0.0);
  double speed = 0.0, wanted = 8.0, gust = 0.0;
  double since_trigger = 0.0, travelled = 0.0;
  int leg = 0;
  for (int k = 0; k < 20 * 300; ++k) {
    const double t = 100.0 + k * 0.05;
    const bool turning = travelled > 250.0;
    wanted = turning ? 2.0 : 8.0;
    gust += 0.05 * (-gust / 2.0) + 0.1 * std::sqrt(0.05) * noise(random);
    speed += 0.05 * (wanted - speed) / 0.8;
    Eigen::Vector2d direction(0.0, leg % 4 == 0 ? 1.0 : -1.0);
    if (leg % 2 == 1) direction = {1.0, 0.0};
    const double step = std::max(0.0, speed + gust) * 0.05;
    position += direction * step;
    travelled += step;
    since_trigger += by_distance ? step : 0.05;
    if ((leg % 2 == 0 && travelled > 252.0) || (leg % 2 == 1 && travelled > 30.0)) {
      ++leg;
      travelled = 0.0;
    }
    survey.track_s.push_back(t);
    survey.track_m.push_back(position);
    const bool fires = since_trigger >= interval && t > 103.0 && t < 395.0;
    if (fires) {
      survey.exposures_s.push_back(t);
      survey.exposures_m.push_back(position);
      since_trigger = by_distance ? 0.0 : since_trigger - interval;
    }
  }
  return survey;
}

geo::LatLon At(const Eigen::Vector2d& position) {
  const geo::LocalFrame frame(geo::Wgs84{47.0, 8.0, 0.0});
  const auto wgs84 = frame.Wgs84FromEnu({position.x(), position.y(), 0.0});
  return {wgs84.lat_deg, wgs84.lon_deg};
}

// Photos whose stamps are cut to `resolution_s` on a clock that is `ahead_s` ahead of UTC.
std::vector<Photo> PhotosOf(const std::vector<double>& times_s, double ahead_s, double resolution_s) {
  std::vector<Photo> photos;
  for (std::size_t i = 0; i < times_s.size(); ++i) {
    Photo photo;
    photo.name = "IMG_" + std::to_string(1000 + i) + ".JPG";
    const double stamp = std::floor((kZeroUnixS + times_s[i] + ahead_s) / resolution_s + 1e-6) * resolution_s;
    photo.captured_at = UtcTime(std::chrono::microseconds(std::llround(stamp * 1e6)));
    photos.push_back(std::move(photo));
  }
  return photos;
}

FlightLog LogOf(const Survey& survey, const std::vector<double>& events_s, double gnss_noise_m,
                unsigned seed) {
  std::mt19937 random(seed);
  std::normal_distribution<double> noise(0.0, gnss_noise_m);
  FlightLog log;
  log.format = "test";
  log.file_name = "flight.BIN";
  log.utc_at_zero = UtcTime(std::chrono::microseconds(static_cast<std::int64_t>(kZeroUnixS * 1e6)));
  log.utc_sigma_s = 0.1;
  for (std::size_t i = 0; i < survey.track_s.size(); i += 4) {
    flight::GnssSample sample;
    sample.t_s = survey.track_s[i];
    sample.position = At(survey.track_m[i] + Eigen::Vector2d(noise(random), noise(random)));
    log.gnss.push_back(sample);
  }
  for (const double t : events_s) {
    CameraEvent event;
    event.t_s = t;
    log.events.push_back(event);
  }
  return log;
}

// Exposures 50 +- 15 ms after their triggers vary by 15 ms about the feedback.
std::vector<double> Jittered(std::vector<double> times_s, unsigned seed, double sigma_s) {
  std::mt19937 random(seed);
  std::normal_distribution<double> noise(0.0, sigma_s);
  for (double& t : times_s) t += noise(random);
  return times_s;
}

TEST(MatchPhotosToLog, FindsAClockAnHourOffFromEventsOfTheSameCount) {
  for (unsigned seed = 1; seed <= 5; ++seed) {
    const Survey survey = Fly(seed, true, 16.0);
    ASSERT_GT(survey.exposures_s.size(), 60u);
    const auto photos = PhotosOf(Jittered(survey.exposures_s, seed, 0.015), 3607.3, 1.0);
    const auto sync = ValueOf(MatchPhotosToLog(photos, LogOf(survey, survey.exposures_s, 1.0, seed)));
    EXPECT_EQ(sync.method, TimeSyncMethod::kEventCount);
    EXPECT_NEAR(*sync.camera_ahead_of_utc_s, 3607.3, 0.05);
    EXPECT_LT(sync.sigma_s, 0.05);
    for (std::size_t i = 0; i < photos.size(); ++i) EXPECT_EQ(sync.photos.at(i)->event, i);
  }
}

TEST(MatchPhotosToLog, SurvivesLostAndDoubledEvents) {
  for (unsigned seed = 1; seed <= 10; ++seed) {
    const Survey survey = Fly(seed, true, 16.0);
    std::mt19937 random(seed + 100);
    std::vector<double> events;
    std::vector<std::optional<std::size_t>> truth;
    for (const double t : survey.exposures_s) {
      const auto dice = random() % 20;
      if (dice == 0) {  // lost
        truth.push_back(std::nullopt);
        continue;
      }
      truth.push_back(events.size());
      events.push_back(t);
      if (dice == 1) events.push_back(t + 0.35);  // doubled
    }
    events.push_back(survey.exposures_s.back() + 7.0);  // a photo that was deleted
    const auto photos = PhotosOf(Jittered(survey.exposures_s, seed, 0.015), 3607.3, 1.0);
    const auto sync = ValueOf(MatchPhotosToLog(photos, LogOf(survey, events, 1.0, seed)));
    EXPECT_EQ(sync.method, TimeSyncMethod::kEventPattern);
    EXPECT_NEAR(*sync.camera_ahead_of_utc_s, 3607.3, 0.05) << seed;
    std::size_t right = 0;
    for (std::size_t i = 0; i < photos.size(); ++i) {
      ASSERT_TRUE(sync.photos.at(i).has_value());
      EXPECT_NEAR(sync.photos.at(i)->t_s, survey.exposures_s[i], 0.8) << "seed " << seed << " photo " << i;
      right += sync.photos.at(i)->event == truth[i] ? 1 : 0;
    }
    EXPECT_GE(right * 100, photos.size() * 97) << seed;
  }
}

TEST(MatchPhotosToLog, SaysWhenAConstantIntervalLeavesTheShiftOpen) {
  const Survey survey = Fly(3, false, 2.0);
  // The first event and the last photo are missing: any shift of one interval fits as well.
  std::vector<double> events(survey.exposures_s.begin() + 1, survey.exposures_s.end());
  const auto photos = PhotosOf({survey.exposures_s.begin(), survey.exposures_s.end() - 1}, 50.0, 1.0);
  const auto sync = ValueOf(MatchPhotosToLog(photos, LogOf(survey, events, 1.0, 3)));
  EXPECT_LT(std::abs(*sync.camera_ahead_of_utc_s - 50.0), 3.0 * sync.sigma_s + 0.1) << "the sigma admits it";
}

TEST(MatchPhotosToLog, UsesNamesThatEventsCarry) {
  const Survey survey = Fly(4, true, 16.0);
  auto photos = PhotosOf(survey.exposures_s, 0.0, 1.0);
  FlightLog log = LogOf(survey, survey.exposures_s, 1.0, 4);
  for (std::size_t i = 0; i < photos.size(); ++i)
    log.events[i].image_name = "100MEDIA/img_" + std::to_string(1000 + i) + ".jpg";
  std::reverse(photos.begin(), photos.end());
  const auto sync = ValueOf(MatchPhotosToLog(photos, log));
  EXPECT_EQ(sync.method, TimeSyncMethod::kEventNames);
  for (std::size_t i = 0; i < photos.size(); ++i) EXPECT_EQ(sync.photos.at(i)->event, photos.size() - 1 - i);
}

TEST(MatchPhotosToLog, UsesNamesOfRowsThatPlaceFewOfThePhotos) {
  const Survey survey = Fly(4, true, 16.0);
  auto photos = PhotosOf(survey.exposures_s, 0.0, 1.0);
  for (Photo& photo : photos) photo.captured_at.reset();
  FlightLog log = LogOf(survey, {survey.exposures_s[2], survey.exposures_s[3]}, 1.0, 4);
  log.gnss.clear();
  for (std::size_t i = 0; i < 2; ++i) log.events[i].image_name = photos[i + 2].name;
  EXPECT_FALSE(MatchPhotosToLog(photos, log).ok()) << "names of another flight, as likely";
  for (std::size_t i = 0; i < 2; ++i) log.events[i].position = At(survey.exposures_m[i + 2]);
  const auto sync = ValueOf(MatchPhotosToLog(photos, log));
  EXPECT_EQ(sync.method, TimeSyncMethod::kEventNames);
  EXPECT_EQ(sync.photos.at(3)->event, 1u);
  EXPECT_FALSE(sync.photos.at(0));
}

TEST(MatchPhotosToLog, LaysPhotoPositionsOnTheTrackWithoutEvents) {
  double square = 0.0, worst_sigma = 0.0;
  for (unsigned seed = 1; seed <= 10; ++seed) {
    const Survey survey = Fly(seed, false, 2.07);
    auto photos = PhotosOf(survey.exposures_s, -7200.0 + 4.25, 1.0);
    std::mt19937 random(seed);
    std::normal_distribution<double> noise(0.0, 0.4);
    for (std::size_t i = 0; i < photos.size(); ++i) {
      flight::RecordedPosition position;
      position.position = At(survey.exposures_m[i] + Eigen::Vector2d(noise(random), noise(random)));
      photos[i].position = position;
    }
    const auto sync = ValueOf(MatchPhotosToLog(photos, LogOf(survey, {}, 0.3, seed)));
    EXPECT_EQ(sync.method, TimeSyncMethod::kPositions);
    const double error = *sync.camera_ahead_of_utc_s - (-7195.75);
    EXPECT_LT(std::abs(error), 0.13) << "seed " << seed;
    EXPECT_LT(std::abs(error), 4.0 * sync.sigma_s + 0.02);
    square += error * error;
    worst_sigma = std::max(worst_sigma, sync.sigma_s);
    for (std::size_t i = 0; i < photos.size(); ++i)
      EXPECT_NEAR(sync.photos.at(i)->t_s, survey.exposures_s[i], 0.2);
  }
  EXPECT_LT(std::sqrt(square / 10.0), 0.05);
  EXPECT_LT(worst_sigma, 0.2);
}

TEST(MatchPhotosToLog, LaysPhotoPositionsOnATrackOfAFixInThreeSeconds) {
  const Survey survey = Fly(1, false, 2.07);
  auto photos = PhotosOf(survey.exposures_s, 4.25, 1.0);
  for (std::size_t i = 0; i < photos.size(); ++i)
    photos[i].position.emplace().position = At(survey.exposures_m[i]);
  FlightLog log = LogOf(survey, {}, 0.3, 1);
  std::vector<flight::GnssSample> slow;
  for (std::size_t i = 0; i < log.gnss.size(); i += 15) slow.push_back(log.gnss[i]);
  log.gnss = std::move(slow);
  const auto sync = ValueOf(MatchPhotosToLog(photos, log));
  EXPECT_EQ(sync.method, TimeSyncMethod::kPositions);
  EXPECT_NEAR(*sync.camera_ahead_of_utc_s, 4.25, 0.5);
}

// Photos of these moments that say where they were, on a clock an hour ahead, and the log until a time.
Result<TimeSync> TiedInPart(const Survey& survey, double log_until_s,
                            const std::function<bool(double t_s)>& is_taken) {
  std::vector<double> times_s;
  std::vector<geo::LatLon> places;
  for (std::size_t i = 0; i < survey.exposures_s.size(); ++i) {
    if (!is_taken(survey.exposures_s[i])) continue;
    times_s.push_back(survey.exposures_s[i]);
    places.push_back(At(survey.exposures_m[i]));
  }
  std::vector<Photo> photos = PhotosOf(times_s, 3600.4, 1.0);
  for (std::size_t i = 0; i < photos.size(); ++i) photos[i].position.emplace().position = places[i];
  FlightLog log = LogOf(survey, {}, 0.3, 5);
  std::erase_if(log.gnss, [&](const flight::GnssSample& sample) { return sample.t_s > log_until_s; });
  return MatchPhotosToLog(photos, log);
}

TEST(MatchPhotosToLog, KnowsByPositionsThatAClockIsAnHourOffWhereTheLogEndsInFlight) {
  const Survey survey = Fly(5, false, 2.07);
  // Three fifths of the photos: fewer than the search over all offsets asks for.
  const auto sync = ValueOf(TiedInPart(survey, 280.0, [](double) { return true; }));
  EXPECT_EQ(sync.method, TimeSyncMethod::kPositions);
  EXPECT_NEAR(*sync.camera_ahead_of_utc_s, 3600.4, 0.5);
  // Two flights with the log of the first stand where they say.
  const auto two = TiedInPart(survey, 210.0, [](double t_s) { return t_s < 200.0 || t_s > 300.0; });
  EXPECT_FALSE(two.ok());
}

// How many of a second camera's photos, at every other moment of the first, are tied to the log of the first.
std::size_t TiedOfSecondCamera(const Survey& survey, double share_of_way, const Eigen::Vector2d& moved_m) {
  std::vector<Photo> photos = PhotosOf(survey.exposures_s, 4.25, 1.0);
  const std::size_t of_first = photos.size();
  for (std::size_t i = 0; i < of_first; ++i) {
    photos[i].camera_key = "first";
    photos[i].position.emplace().position = At(survey.exposures_m[i]);
  }
  for (std::size_t i = 0; i < of_first; i += 2) {
    Photo photo = photos[i];
    photo.name = "second_" + photo.name;
    photo.camera_key = "second";
    photo.position->position = At(share_of_way * survey.exposures_m[i] + moved_m);
    photos.push_back(std::move(photo));
  }
  const auto sync = ValueOf(MatchPhotosToLog(photos, LogOf(survey, {}, 0.3, 3)));
  EXPECT_EQ(sync.method, TimeSyncMethod::kPositions);
  const auto second = sync.photos.begin() + static_cast<std::ptrdiff_t>(of_first);
  EXPECT_EQ(std::count(sync.photos.begin(), second, std::nullopt), 0);
  return photos.size() - of_first -
         static_cast<std::size_t>(std::count(second, sync.photos.end(), std::nullopt));
}

TEST(MatchPhotosToLog, LeavesPhotosOfAnotherAircraftWhereTheyWere) {
  const Survey survey = Fly(3, false, 2.07);
  const std::size_t all = (survey.exposures_s.size() + 1) / 2;
  EXPECT_EQ(TiedOfSecondCamera(survey, 1.0, {0.0, 0.0}), all) << "two cameras of one aircraft";
  EXPECT_EQ(TiedOfSecondCamera(survey, 1.0, {300.0, 0.0}), 0u);
  EXPECT_EQ(TiedOfSecondCamera(survey, 0.0, {300.0, 0.0}), all) << "a place that all repeat says nothing";
}

TEST(MatchPhotosToLog, AdmitsThatWholeSecondIntervalsHideTheFraction) {
  const Survey survey = Fly(2, false, 2.0);
  auto photos = PhotosOf(survey.exposures_s, 4.25, 1.0);
  for (std::size_t i = 0; i < photos.size(); ++i) {
    flight::RecordedPosition position;
    position.position = At(survey.exposures_m[i]);
    photos[i].position = position;
  }
  const auto sync = ValueOf(MatchPhotosToLog(photos, LogOf(survey, {}, 0.3, 2)));
  EXPECT_GT(sync.sigma_s, 0.2);
  EXPECT_LT(std::abs(*sync.camera_ahead_of_utc_s - 4.25), 0.6);
}

TEST(MatchPhotosToLog, FallsBackToTheClocksAndSaysSo) {
  const Survey survey = Fly(6, true, 16.0);
  auto photos = PhotosOf(survey.exposures_s, 0.4, 1.0);
  const auto utc = ValueOf(MatchPhotosToLog(photos, LogOf(survey, {}, 1.0, 6)));
  EXPECT_EQ(utc.method, TimeSyncMethod::kClocks);
  EXPECT_GE(utc.sigma_s, 1.0);
  photos = PhotosOf(survey.exposures_s, 2.0 * 3600.0 + 0.4, 1.0);
  for (Photo& photo : photos) photo.captured_at_is_local = true;
  const auto local = ValueOf(MatchPhotosToLog(photos, LogOf(survey, {}, 1.0, 6)));
  EXPECT_NEAR(*local.camera_ahead_of_utc_s, 7200.0, 1.0) << "only one zone puts the photos into the log";
  EXPECT_FALSE(local.notes.empty());
}

TEST(MatchPhotosToLog, LeavesPhotosTheirClockBesideMoreFramesOfAFilm) {
  const Survey survey = Fly(6, true, 16.0);
  std::vector<double> times_s;
  for (std::size_t i = 0; i < survey.exposures_s.size(); i += 3) times_s.push_back(survey.exposures_s[i]);
  std::vector<Photo> all = PhotosOf(times_s, 2.0 * 3600.0 + 0.4, 1.0);
  for (Photo& photo : all) {
    photo.make = photo.camera_key = "Maker";
    photo.captured_at_is_local = true;
  }
  for (Photo& frame : PhotosOf(survey.exposures_s, 0.4, 1.0)) {
    frame.name = "film_" + frame.name;
    frame.camera_key = "film";
    frame.captured_at_is_local = true;
    all.push_back(std::move(frame));
    times_s.push_back(survey.exposures_s[times_s.size() - (survey.exposures_s.size() + 2) / 3]);
  }
  const auto sync = ValueOf(MatchPhotosToLog(all, LogOf(survey, {}, 1.0, 6)));
  EXPECT_NEAR(*sync.camera_ahead_of_utc_s, 7200.0, 1.0);
  for (std::size_t i = 0; i < all.size(); ++i) {
    ASSERT_TRUE(sync.photos[i]) << all[i].name;
    EXPECT_NEAR(sync.photos[i]->t_s, times_s[i], 1.5) << all[i].name;
  }
}

TEST(MatchPhotosToLog, ExplainsWhenNothingTiesThem) {
  const Survey survey = Fly(7, true, 16.0);
  std::vector<Photo> photos(5);
  const Error without_stamps = ErrorOf(MatchPhotosToLog(photos, LogOf(survey, survey.exposures_s, 1.0, 7)));
  EXPECT_EQ(without_stamps.code, ErrorCode::kUnprocessable);
  const auto other_day =
      MatchPhotosToLog(PhotosOf(survey.exposures_s, 864'000.0, 1.0), LogOf(survey, {}, 1.0, 7));
  EXPECT_FALSE(other_day.ok());
  EXPECT_FALSE(MatchPhotosToLog({}, LogOf(survey, {}, 1.0, 7)).ok());
}

TEST(RefineByTriggerInterval, TurnsWholeSecondsIntoHundredths) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> start(0.0, 1.0), interval(1.5, 3.5);
  std::normal_distribution<double> jitter(0.0, 0.008);
  double square = 0.0;
  std::size_t count = 0;
  for (int round = 0; round < 50; ++round) {
    const double first = start(random);
    const double step = interval(random);
    std::vector<double> truth, stamps;
    for (int i = 0; i < 96; ++i) {
      truth.push_back(first + i * step + jitter(random));
      stamps.push_back(std::floor(truth.back()));
    }
    const RefinedStamps refined = RefineByTriggerInterval(stamps, 1.0);
    if (refined.refined < 96) continue;  // an interval of almost whole seconds tells nothing
    double mean = 0.0;
    for (int i = 0; i < 96; ++i)
      mean += (refined.times_s[static_cast<std::size_t>(i)] - truth[static_cast<std::size_t>(i)]) / 96.0;
    square += mean * mean;
    ++count;
  }
  ASSERT_GE(count, 40u);
  EXPECT_LT(std::sqrt(square / static_cast<double>(count)), 0.03) << "0.29 without";
}

TEST(FitOffset, IsConsistentWithItsSigma) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> uniform(0.0, 300.0);
  std::normal_distribution<double> jitter(0.0, 0.02);
  double nees = 0.0;
  for (int round = 0; round < 100; ++round) {
    std::vector<double> differences;
    for (int i = 0; i < 80; ++i) {
      const double t = uniform(random);
      differences.push_back(std::floor(t + 12.34 + jitter(random)) - t);
    }
    const OffsetFit fit = FitOffset(differences, {1.0, 0.02});
    EXPECT_NEAR(fit.offset_s, 12.34, 0.05);
    nees += std::pow((fit.offset_s - 12.34) / fit.sigma_s, 2) / 100.0;
  }
  EXPECT_GT(nees, 0.5);
  EXPECT_LT(nees, 2.0);
}

TEST(AlignEvents, IsNotFooledByUnrelatedEvents) {
  std::mt19937 random(9);
  std::uniform_real_distribution<double> uniform(0.0, 1000.0);
  std::vector<double> stamps, events;
  for (int i = 0; i < 50; ++i) {
    stamps.push_back(std::floor(uniform(random)));
    events.push_back(uniform(random));
  }
  std::sort(stamps.begin(), stamps.end());
  std::sort(events.begin(), events.end());
  EXPECT_FALSE(AlignEvents(stamps, events, {1e-3, 0.02}).has_value());
}

}  // namespace
}  // namespace skyquilt::poses
