#include "core/render/bands/register_bands.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <limits>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "core/base/median.h"
#include "core/base/parallel_for.h"
#include "core/flight/remarks/because.h"
#include "core/render/bands/band_patches.h"
#include "core/render/bands/fit_band_cameras.h"

namespace skyquilt::render {
namespace {

using alignment::AlignedPhoto;

constexpr std::int64_t kBytesAPixel = 4 * 20;  // of four pictures, with their edges
// Where lenses and rigs are as recorded, a hundredth of the picture; bands without any record of their rig
// are found too.
struct Search {
  PatchSearch patches;
  double scale_px;  // of the full size: how far sightings of one capture may differ
};
constexpr std::array<Search, 2> kSearches = {{{{4, 16, 200.0}, 6.0}, {{2, 8, 130.0}, 3.0}}};
// A peak is seen truly where it lies near the middle of what is searched: so full size is searched twice.
constexpr double kLastScalePx = 1.0;
constexpr std::array<Search, 2> kLastSearches = {{{{1, 6, 150.0}, 1.5}, {{1, 3, 500.0}, kLastScalePx}}};
// So many captures are searched from the recorded rig; the others from where those found the bands.
constexpr std::size_t kFirstCaptures = 4;
// So many, all over the flight, tell how the lenses are before all are searched at full size.
constexpr std::size_t kLensCaptures = 8;

struct Picture {
  std::optional<BandEdges> edges;
  std::optional<flight::Remark> failure;
};

Picture EdgesOf(const flight::PhotoSource& source, const flight::Photo& photo,
                std::span<const Search> searches) {
  Result<image::SampleImage> samples = source.DecodeSamples(photo);
  if (!samples) return {std::nullopt, flight::WhyOf(samples.error())};
  return {BandEdges(*samples, searches.back().patches.denominator, searches.front().patches.denominator),
          std::nullopt};
}

// One band of one capture while it is registered.
struct Member {
  const bands::BandPhoto* photo = nullptr;  // nothing: the capture lacks the band
  std::size_t lens = 0;                     // of Work::lenses
  bool is_reference = false;
  bool is_measured = false;
  BandStand stand;
  int looked_at = 0;
  std::optional<flight::Remark> failure;
};

struct Work {
  std::vector<std::vector<Member>> captures;  // by reference, then by band
  std::vector<BandLens> lenses;               // by physical camera
};

AlignedPhoto CameraOf(const AlignedPhoto& reference, const bands::BandPhoto& photo,
                      const camera::Intrinsics& lens, const BandStand& stand) {
  AlignedPhoto camera = reference;
  camera.photo = photo.photo;
  camera.intrinsics = lens;
  camera.cam_from_enu.rotation = (stand.band_from_reference * reference.cam_from_enu.rotation).normalized();
  camera.cam_from_enu.translation =
      stand.band_from_reference * reference.cam_from_enu.translation + stand.shift_in_band_m;
  return camera;
}

// Recorded, with what the alignment found of the reference's focal length: it goes with the height.
camera::Intrinsics FirstLens(const AlignedPhoto& reference, const flight::Photo& photo) {
  camera::Intrinsics lens = photo.intrinsics;
  const double scale = reference.intrinsics.MeanFocalPx() / reference.photo.intrinsics.MeanFocalPx();
  if (scale > 0.5 && scale < 2.0) {
    lens.focal_x_px *= scale;
    lens.focal_y_px *= scale;
  }
  return lens;
}

// Which captures are searched, and how: the whole way, or its last steps alone from where the bands are known
// to stand. What is not found so is searched the whole way.
struct Pass {
  std::span<const Search> searches;  // coarse to fine
  std::size_t first_step = 0;        // of searches
  std::vector<std::size_t> captures;
  double progress_from = 0.0, progress_to = 1.0;
};

// The searches of one picture from a step on, each from where the one before left the camera.
void SearchPicture(const AlignedPhoto& reference, const BandEdges& reference_edges, const BandEdges& edges,
                   const ground::GroundSurface& ground, const BandLens& lens, const Pass& pass,
                   std::size_t first_step, Member& member) {
  for (const Search& search : pass.searches.subspan(first_step)) {
    const AlignedPhoto camera = CameraOf(reference, *member.photo, lens.intrinsics, member.stand);
    BandMeasurement measured =
        MeasureBand(reference, reference_edges, camera, lens.field, edges, ground, search.patches);
    member.stand.sightings = std::move(measured.sightings);
    member.looked_at = measured.looked_at;
    // A coarse search that finds too little may still be followed by a finer one that does.
    member.is_measured = FitStand(lens, search.scale_px, member.stand);
  }
}

void RegisterCapture(const AlignedPhoto& reference, const ground::GroundSurface& ground,
                     const flight::PhotoSource& source, const std::vector<BandLens>& lenses, const Pass& pass,
                     std::vector<Member>& members) {
  const Picture reference_picture = EdgesOf(source, reference.photo, pass.searches);
  for (Member& member : members) {
    if (member.photo == nullptr || member.is_reference) continue;
    const Picture picture = EdgesOf(source, member.photo->photo, pass.searches);
    member.failure = picture.failure;
    if (!picture.edges || !reference_picture.edges) continue;
    const BandStand known = member.stand;
    SearchPicture(reference, *reference_picture.edges, *picture.edges, ground, lenses[member.lens], pass,
                  pass.first_step, member);
    if (member.is_measured || pass.first_step == 0) continue;
    member.stand = known;
    SearchPicture(reference, *reference_picture.edges, *picture.edges, ground, lenses[member.lens], pass, 0,
                  member);
  }
}

bool RegisterAll(const alignment::AlignedFlight& references, const ground::GroundSurface& ground,
                 const flight::PhotoSource& source, const RegisterOptions& options, const Pass& pass,
                 Work& work, Progress& progress) {
  std::int64_t largest_pixels = 1;
  for (const AlignedPhoto& photo : references.photos) {
    largest_pixels =
        std::max(largest_pixels, std::int64_t{photo.intrinsics.width_px} * photo.intrinsics.height_px);
  }
  const std::int64_t fit = std::max<std::int64_t>(1, options.max_bytes / (kBytesAPixel * largest_pixels));
  const int threads = static_cast<int>(std::min<std::int64_t>(fit, ThreadCount(options.threads)));
  std::atomic<std::size_t> done{0};
  const std::size_t count = pass.captures.size();
  ParallelFor(count, threads, [&](std::size_t k) {
    if (progress.IsCancelled()) return;
    const std::size_t i = pass.captures[k];
    RegisterCapture(references.photos[i], ground, source, work.lenses, pass, work.captures[i]);
    const std::size_t finished = ++done;
    const double share = static_cast<double>(finished) / static_cast<double>(count);
    progress.Report(pass.progress_from + share * (pass.progress_to - pass.progress_from),
                    fmt::format("bands of capture {} of {}", finished, count));
  });
  return !progress.IsCancelled();
}

// All pictures of one physical camera.
template <typename Visit>
void VisitMembers(Work& work, std::size_t lens, const Visit& visit) {
  for (auto& members : work.captures) {
    for (Member& member : members) {
      if (member.photo != nullptr && !member.is_reference && member.lens == lens) visit(member);
    }
  }
}

// Where a picture's stand shows the ground beside where another's does: across, down and about the axis, in
// radians. A little turn and a little shift are hardly told apart from above, so that they count together.
Eigen::Vector3d Beside(const BandStand& stand, const BandStand& other) {
  std::vector<double> depths_m;
  depths_m.reserve(stand.sightings.size());
  for (const BandSighting& sighting : stand.sightings) depths_m.push_back(sighting.in_reference_cam.z());
  const double depth_m = MedianIfAny(std::move(depths_m)).value_or(0.0);
  Eigen::Vector2d shift_rad = Eigen::Vector2d::Zero();
  if (depth_m > 0.0) shift_rad = (stand.shift_in_band_m - other.shift_in_band_m).head<2>() / depth_m;
  const Eigen::Vector3d turn =
      geo::VectorFromRotation(stand.band_from_reference * other.band_from_reference.conjugate());
  return {turn.y() + shift_rad.x(), shift_rad.y() - turn.x(), turn.z()};
}

// Of a camera: how it stands beside the reference in its middlemost picture, and how far from that another
// picture may show the ground. Further than an aircraft turns between two shutters, and than several times
// what most captures of this flight differ, patches agree on one texture taken for another.
struct UsualStand {
  BandStand stand;
  double reach_rad = std::numeric_limits<double>::infinity();
};

std::optional<UsualStand> FindUsual(std::size_t lens, Work& work) {
  constexpr std::size_t kMinCaptures = 3;  // of fewer, nobody knows which is wrong
  constexpr double kMinReachRad = 0.004, kSpreads = 5.0;
  std::vector<const BandStand*> stands;
  VisitMembers(work, lens, [&](const Member& member) {
    if (member.is_measured) stands.push_back(&member.stand);
  });
  if (stands.empty()) return std::nullopt;
  std::vector<Eigen::Vector3d> places;
  std::array<std::vector<double>, 3> axes;
  for (const BandStand* stand : stands) {
    places.push_back(Beside(*stand, *stands[0]));
    for (Eigen::Index axis = 0; axis < 3; ++axis)
      axes[static_cast<std::size_t>(axis)].push_back(places.back()[axis]);
  }
  const Eigen::Vector3d middle(Median(axes[0]), Median(axes[1]), Median(axes[2]));
  std::size_t nearest = 0;
  std::vector<double> apart;
  for (std::size_t i = 0; i < places.size(); ++i) {
    apart.push_back((places[i] - middle).norm());
    if (apart[i] < apart[nearest]) nearest = i;
  }
  UsualStand usual{{{}, stands[nearest]->band_from_reference, stands[nearest]->shift_in_band_m}};
  if (stands.size() >= kMinCaptures)
    usual.reach_rad = std::max(kMinReachRad, kSpreads * Median(std::move(apart)));
  return usual;
}

// Pictures that found nothing, or stand apart from all others of the camera, take its usual stand.
void TakeUsual(std::size_t lens, Work& work) {
  const std::optional<UsualStand> usual = FindUsual(lens, work);
  if (!usual) return;
  VisitMembers(work, lens, [&](Member& member) {
    if (member.is_measured && Beside(member.stand, usual->stand).norm() > usual->reach_rad)
      member.is_measured = false;
    if (!member.is_measured) member.stand = usual->stand;
  });
}

// Stands and lens in turn, from the sightings that are there; the field last, from what the lens leaves.
void Refine(std::size_t lens, Work& work) {
  constexpr int kLensTurns = 10, kTurns = 14;
  TakeUsual(lens, work);
  work.lenses[lens].field = {};
  for (int turn = 0; turn < kTurns; ++turn) {
    std::vector<BandStand> stands;
    VisitMembers(work, lens, [&](const Member& member) {
      if (member.is_measured) stands.push_back(member.stand);
    });
    if (stands.empty()) return;
    if (turn < kLensTurns) {
      work.lenses[lens] = FitBandLens(work.lenses[lens], stands);
    } else {
      work.lenses[lens].field = FitBandField(work.lenses[lens].intrinsics, stands);
    }
    VisitMembers(work, lens, [&](Member& member) {
      if (member.is_measured) FitStand(work.lenses[lens], kLastScalePx, member.stand);
    });
  }
  TakeUsual(lens, work);
}

BandRegistration Describe(std::size_t band, const Work& work) {
  BandRegistration registration;
  double squares = 0.0;
  for (const auto& members : work.captures) {
    const Member& member = members[band];
    if (member.photo == nullptr || member.failure) continue;
    ++registration.pictures;
    if (member.is_reference) ++registration.measured;
    if (!member.is_measured) continue;
    ++registration.measured;
    for (const BandSighting& sighting : member.stand.sightings) {
      const double miss_px = MissOf(work.lenses[member.lens], member.stand, sighting);
      if (miss_px > kWrongSightingPx) continue;
      squares += miss_px * miss_px;
      ++registration.patches;
    }
  }
  if (registration.patches > 0) registration.residual_px = std::sqrt(squares / registration.patches);
  return registration;
}

std::vector<std::size_t> Between(std::size_t from, std::size_t to) {
  std::vector<std::size_t> captures;
  for (std::size_t i = from; i < to; ++i) captures.push_back(i);
  return captures;
}

// At most so many, evenly over the flight.
std::vector<std::size_t> Spread(std::size_t count, std::size_t most) {
  std::vector<std::size_t> captures;
  for (std::size_t k = 0; k < std::min(count, most); ++k)
    captures.push_back(count <= most ? k : k * count / most);
  return captures;
}

Work Prepare(const alignment::AlignedFlight& references, const bands::Captures& captures) {
  Work work;
  std::map<std::string, const bands::Capture*> by_reference;
  for (const bands::Capture& capture : captures.captures) by_reference[capture.reference] = &capture;
  std::map<std::string, std::size_t> band_index;
  for (std::size_t i = 0; i < captures.bands.size(); ++i) band_index[captures.bands[i].name] = i;
  std::map<std::string, std::size_t> lens_of;  // by camera
  for (const AlignedPhoto& reference : references.photos) {
    std::vector<Member>& members = work.captures.emplace_back(captures.bands.size());
    const auto found = by_reference.find(reference.photo.name);
    if (found == by_reference.end()) continue;
    for (const bands::BandPhoto& photo : found->second->photos) {
      const std::size_t band = band_index.at(photo.facts.name);
      members[band].photo = &photo;
      members[band].is_reference = photo.photo.name == reference.photo.name;
      const auto [lens, is_new] =
          lens_of.try_emplace(photo.photo.camera_key + "|" + photo.facts.name, work.lenses.size());
      if (is_new) work.lenses.push_back({FirstLens(reference, photo.photo), {}});
      members[band].lens = lens->second;
    }
  }
  return work;
}

}  // namespace

Result<BandCameras> RegisterBands(const alignment::AlignedFlight& references,
                                  const ground::GroundSurface& ground, const bands::Captures& captures,
                                  const flight::PhotoSource& source, const RegisterOptions& options,
                                  Progress& progress) {
  Work work = Prepare(references, captures);
  const Error cancelled{ErrorCode::kCancelled, "The job was cancelled.", ""};
  const std::size_t bands = captures.bands.size();
  const std::size_t count = references.photos.size();
  const auto run = [&](const Pass& pass) {
    return RegisterAll(references, ground, source, options, pass, work, progress);
  };
  const auto refine = [&] {
    for (std::size_t lens = 0; lens < work.lenses.size(); ++lens) Refine(lens, work);
  };
  const std::size_t first = std::min(count, kFirstCaptures);
  if (!run({kSearches, 0, Between(0, first), 0.0, 0.1})) return cancelled;
  for (std::size_t lens = 0; lens < work.lenses.size(); ++lens) TakeUsual(lens, work);
  if (!run({kSearches, kSearches.size() - 1, Between(first, count), 0.1, 0.3})) return cancelled;
  refine();
  if (!run({kLastSearches, 0, Spread(count, kLensCaptures), 0.3, 0.4})) return cancelled;
  refine();
  if (!run({kLastSearches, 0, Between(0, count), 0.4, 1.0})) return cancelled;
  refine();
  BandCameras cameras;
  for (std::size_t band = 0; band < bands; ++band) {
    cameras.registrations.push_back(Describe(band, work));
    const BandRegistration& registration = cameras.registrations.back();
    if (registration.measured < registration.pictures) {
      cameras.warnings.push_back({registration.patches > 0 ? flight::RemarkCode::kBandLaidAsOthers
                                                           : flight::RemarkCode::kBandLaidAsReference,
                                  {{"failed", registration.pictures - registration.measured},
                                   {"captures", registration.pictures},
                                   {"band", captures.bands[band].name}}});
    }
  }
  for (std::size_t i = 0; i < references.photos.size(); ++i) {
    BandedCapture& capture = cameras.captures.emplace_back();
    for (std::size_t band = 0; band < bands; ++band) {
      const Member& member = work.captures[i][band];
      std::optional<BandCamera>& camera = capture.cameras.emplace_back();
      if (member.photo == nullptr) continue;
      if (member.failure) {
        cameras.warnings.push_back({flight::RemarkCode::kBandWithoutValues,
                                    {{"photo", member.photo->photo.name}, {"why", *member.failure}}});
        continue;
      }
      const AlignedPhoto& reference = references.photos[i];
      const BandLens& lens = work.lenses[member.lens];
      camera = member.is_reference
                   ? BandCamera{reference, {}, member.photo->facts.radiometry}
                   : BandCamera{CameraOf(reference, *member.photo, lens.intrinsics, member.stand), lens.field,
                                member.photo->facts.radiometry};
    }
  }
  return cameras;
}

}  // namespace skyquilt::render
