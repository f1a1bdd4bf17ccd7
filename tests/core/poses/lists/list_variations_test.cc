// Lists in the many ways in which the world writes them, five hundred of each kind: every photo lies where
// its row says, to a metre, or the list is refused and the cause named. None is silently wrong: such a list
// is printed with its seed.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cctype>
#include <map>

#include "core/flight/read_flight.h"
#include "core/flight/remarks/remark_words.h"
#include "core/geo/local_frame.h"
#include "core/poses/estimate_poses.h"
#include "core/poses/lists/compare_sources.h"
#include "tests/core/poses/lists/generated_list.h"
#include "tests/support/temporary_folder.h"

namespace skyquilt::testing {
namespace {

constexpr std::uint32_t kListsOfAKind = 500;
constexpr std::size_t kShown = 10;  // of the failures of a kind

// Where the program puts what a list is about, and all that it says.
struct Outcome {
  std::map<std::string, geo::Wgs84> places;
  std::vector<std::string> words;
};

void TakePoses(const flight::Flight& flight, Outcome& outcome) {
  poses::EstimatePosesOptions options;
  options.keep_unplaced = true;
  const auto posed = poses::EstimatePoses(flight, options);
  if (!posed) {
    outcome.words.push_back(posed.error().message);
    return;
  }
  for (const flight::Remark& said : posed->warnings) outcome.words.push_back(InWords(said));
  if (!posed->is_placed) return;
  for (const poses::PosedPhoto& photo : posed->photos)
    outcome.places.emplace(photo.photo.name,
                           posed->frame.Wgs84FromEnu(photo.cam_from_enu.TargetOriginInSource()));
}

Outcome ReadAndPlace(const GeneratedList& list, bool is_control, const test::TemporaryFolder& folder) {
  SilentProgress progress;
  auto flight = flight::ReadFlight({{list.file_name, folder.Write(list.file_name, list.bytes)}}, 1, progress);
  Outcome outcome;
  if (!flight) {
    outcome.words.push_back(flight.error().message);
    return outcome;
  }
  outcome.words = InWords(flight->warnings);
  for (const flight::LeftOutPhoto& file : flight->left_out)
    outcome.words.push_back(file.name + ": " + InWords(file.reason));
  flight->left_out.clear();
  flight->photos = list.photos;
  const std::size_t said = flight->warnings.size();
  if (const Result<void> compared = poses::CompareSources(*flight); !compared) {
    outcome.words.push_back(compared.error().message);
    return outcome;
  }
  for (std::size_t i = said; i < flight->warnings.size(); ++i)
    outcome.words.push_back(InWords(flight->warnings[i]));
  if (!is_control) {
    TakePoses(*flight, outcome);
    return outcome;
  }
  for (const flight::GcpList& points : flight->gcp_lists) {
    for (const flight::GcpPoint& point : points.points)
      outcome.places.emplace(point.name, geo::Wgs84{point.position.lat_deg, point.position.lon_deg, 0.0});
  }
  return outcome;
}

bool Holds(std::string text, std::string part) {
  const auto lower = [](std::string& word) {
    std::transform(word.begin(), word.end(), word.begin(),
                   [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  };
  lower(text);
  lower(part);
  return text.find(part) != std::string::npos;
}

// One sentence that names the file and why. That nothing in it is known is no cause.
bool IsToldWhy(const GeneratedList& list, const Outcome& outcome) {
  return std::any_of(outcome.words.begin(), outcome.words.end(), [&](const std::string& words) {
    return Holds(words, list.file_name) && !Holds(words, "nothing in it is known") &&
           std::any_of(list.causes.begin(), list.causes.end(),
                       [&](const std::string& cause) { return Holds(words, cause); });
  });
}

double ApartM(const geo::Wgs84& a, const geo::Wgs84& b) {
  return geo::LocalFrame({a.lat_deg, a.lon_deg, 0.0}).EnuFromWgs84({b.lat_deg, b.lon_deg, 0.0}).norm();
}

// The heights of the placed photos, each less the true one, from the lowest to the highest: 0 where all count
// from one zero.
double HeightSpreadM(const GeneratedList& list, const Outcome& outcome) {
  double low = 1e9, high = -1e9;
  for (const TruePlace& truth : list.truth) {
    const double off_m = outcome.places.at(truth.name).height_ellipsoid_m - truth.at.height_ellipsoid_m;
    low = std::min(low, off_m);
    high = std::max(high, off_m);
  }
  return high - low;
}

struct Verdict {
  bool is_right = false;  // every row where it says
  std::string problem;    // empty where it is right, or refused with its cause
};

Verdict Judge(const GeneratedList& list, const Outcome& outcome) {
  bool is_whole = true;
  for (const TruePlace& truth : list.truth) {
    if (!truth.has_row) continue;
    const auto found = outcome.places.find(truth.name);
    if (found == outcome.places.end()) {
      is_whole = false;
      continue;
    }
    const double off_m = ApartM(truth.at, found->second);
    if (off_m <= list.tolerance_m) continue;
    is_whole = false;
    const auto photo = std::find_if(list.photos.begin(), list.photos.end(),
                                    [&](const flight::Photo& p) { return p.name == truth.name; });
    if (photo != list.photos.end() && photo->position) {
      const geo::LatLon& own = photo->position->position;
      if (ApartM({own.lat_deg, own.lon_deg, 0.0}, found->second) < 1.0) continue;
    }
    return {false, fmt::format("{} lies {:.1f} m from where its row says, and not where it says itself",
                               truth.name, off_m)};
  }
  if (is_whole && list.has_heights && HeightSpreadM(list, outcome) > 1.0) {
    return {false, fmt::format("the heights differ by {:.1f} m from what the list says",
                               HeightSpreadM(list, outcome))};
  }
  if (list.is_of_another_flight) {
    return {is_whole, IsToldWhy(list, outcome) ? "" : "it is of another flight, and nothing says so"};
  }
  if (is_whole || IsToldWhy(list, outcome)) return {is_whole, ""};
  return {false, "it is not used, and no word names the cause"};
}

// `share`: of the lists, what is right at least: refusing everything would be no answer either.
void ExpectRightOrRefused(GeneratedList (*generate)(std::uint32_t), double share, bool is_control = false) {
  const test::TemporaryFolder folder;
  std::size_t wrong = 0, right = 0;
  for (std::uint32_t seed = 1; seed <= kListsOfAKind; ++seed) {
    const GeneratedList list = generate(seed);
    const Outcome outcome = ReadAndPlace(list, is_control, folder);
    const Verdict verdict = Judge(list, outcome);
    right += verdict.is_right ? 1 : 0;
    if (verdict.problem.empty() || ++wrong > kShown) continue;
    std::string said;
    for (const std::string& words : outcome.words) said += "  " + words + "\n";
    ADD_FAILURE() << "seed " << seed << ", " << list.file_name << ": " << verdict.problem << "\nsaid:\n"
                  << said << list.text.substr(0, 1200);
  }
  EXPECT_EQ(wrong, 0u) << "of " << kListsOfAKind << " lists";
  EXPECT_GE(static_cast<double>(right), share * kListsOfAKind);
}

TEST(ListVariations, ListsOfPositions) { ExpectRightOrRefused(GeneratePositions, 0.75); }
TEST(ListVariations, TablesWithHeaders) { ExpectRightOrRefused(GenerateTable, 0.75); }
TEST(ListVariations, TracksAndEvents) { ExpectRightOrRefused(GenerateTrack, 0.75); }
// An eighth names no system, an eighth is in another unit than its system: for neither is a datum guessed.
TEST(ListVariations, SurveyedPoints) { ExpectRightOrRefused(GenerateControl, 2.0 / 3.0, true); }

}  // namespace
}  // namespace skyquilt::testing
