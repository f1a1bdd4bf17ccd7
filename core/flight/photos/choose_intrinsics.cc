#include "core/flight/photos/choose_intrinsics.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <optional>
#include <string>
#include <utility>

#include "core/camera/fit_fisheye.h"
#include "core/camera/sensor_database.h"

namespace skyquilt::flight {
namespace {

using camera::Intrinsics;

// From 150 degrees of view to a long tele lens.
bool IsPlausible(double focal_px, int width_px, int height_px) {
  const double side = std::max(width_px, height_px);
  return std::isfinite(focal_px) && focal_px > 0.13 * side && focal_px < 60.0 * side;
}

// Of a picture, in its pixels, in x or y.
bool IsCentre(const std::optional<double>& center_px) {
  constexpr double kSmallest = 100.0, kLargest = 20000.0;
  return center_px && *center_px > kSmallest && *center_px < kLargest;
}

// Of a calibration, whose focal lengths in x and y are nearly one.
bool HasPlausibleAxes(const Intrinsics& camera) {
  constexpr double kAxesApart = 0.05;
  return IsPlausible(camera.focal_x_px, camera.width_px, camera.height_px) &&
         IsPlausible(camera.focal_y_px, camera.width_px, camera.height_px) &&
         !(std::abs(camera.focal_x_px / camera.focal_y_px - 1.0) > kAxesApart);
}

// Of an image against the size to which DJI's calibrated pixels belong.
double DjiScale(int width_px, int height_px, const XmpTags& xmp) {
  const auto center_x = xmp.Number("drone-dji:CalibratedOpticalCenterX");
  const auto center_y = xmp.Number("drone-dji:CalibratedOpticalCenterY");
  if (!IsCentre(center_x) || !IsCentre(center_y)) return 1.0;
  return camera::ScaleFromNative(width_px, height_px, static_cast<int>(std::round(2.0 * *center_x)),
                                 static_cast<int>(std::round(2.0 * *center_y)));
}

std::optional<Intrinsics> FromDewarpData(int width_px, int height_px, const XmpTags& xmp) {
  std::string text = xmp.Text("drone-dji:DewarpData");
  // "2018-09-04;fx,fy,cx,cy,k1,k2,p1,p2,k3": a date, then the numbers.
  if (const auto semicolon = text.find(';'); semicolon != std::string::npos) text.erase(0, semicolon + 1);
  const auto items = ParseXmpNumbers(text);
  if (items.size() < 9 || std::any_of(items.begin(), items.begin() + 9, [](const auto& v) { return !v; })) {
    return std::nullopt;
  }
  const double scale = DjiScale(width_px, height_px, xmp);
  Intrinsics camera = Intrinsics::Centered(width_px, height_px, *items[0] * scale);
  camera.focal_y_px = *items[1] * scale;
  if (!HasPlausibleAxes(camera)) return std::nullopt;
  const double offset_x_px = *items[2] * scale;
  const double offset_y_px = *items[3] * scale;
  if (std::abs(offset_x_px) > 0.1 * width_px || std::abs(offset_y_px) > 0.1 * height_px) return std::nullopt;
  camera.center_x_px += offset_x_px;
  camera.center_y_px += offset_y_px;
  if (xmp.Number("drone-dji:DewarpFlag") == 1.0) return camera;  // with no distortion left
  camera.k1 = *items[4];
  camera.k2 = *items[5];
  camera.p1 = *items[6];
  camera.p2 = *items[7];
  camera.k3 = *items[8];
  return camera;
}

std::optional<Intrinsics> FromCalibratedFocalLength(int width_px, int height_px, const XmpTags& xmp) {
  const auto focal_px = xmp.Number("drone-dji:CalibratedFocalLength");
  if (!focal_px) return std::nullopt;
  const double scaled = *focal_px * DjiScale(width_px, height_px, xmp);
  if (!IsPlausible(scaled, width_px, height_px)) return std::nullopt;
  return Intrinsics::Centered(width_px, height_px, scaled);
}

// One side of what Skydio writes as a structure of X and Y; programs that copy tags join the names.
std::optional<double> SkydioSide(const XmpTags& xmp, const std::string& name, char side) {
  const std::string whole = "drone-skydio:" + name;
  if (const auto value = xmp.Number(whole + "/drone-skydio:" + side)) return value;
  return xmp.Number(whole + side);
}

// Skydio's, in pixels of the picture as the camera wrote it, whose size the centre tells. Its distortion is
// left to the images: of which model it is, is not documented.
std::optional<Intrinsics> FromSkydioCalibration(int width_px, int height_px, const XmpTags& xmp) {
  const auto focal_x = SkydioSide(xmp, "CalibratedFocalLength", 'X');
  if (!focal_x) return std::nullopt;
  const double focal_y = SkydioSide(xmp, "CalibratedFocalLength", 'Y').value_or(*focal_x);
  const auto center_x = SkydioSide(xmp, "CalibratedOpticalCenter", 'X');
  const auto center_y = SkydioSide(xmp, "CalibratedOpticalCenter", 'Y');
  double scale = 1.0;
  if (IsCentre(center_x) && IsCentre(center_y)) {
    scale = camera::ScaleFromNative(width_px, height_px, static_cast<int>(std::lround(2.0 * *center_x + 1.0)),
                                    static_cast<int>(std::lround(2.0 * *center_y + 1.0)));
    constexpr double kOffCentre = 0.05;  // a centre beside the middle is no other size
    if (std::abs(scale - 1.0) < kOffCentre) scale = 1.0;
  }
  Intrinsics camera = Intrinsics::Centered(width_px, height_px, *focal_x * scale);
  camera.focal_y_px = focal_y * scale;
  if (!HasPlausibleAxes(camera)) return std::nullopt;
  return camera;
}

// What tells how large the sensor is, and so what a lens in millimetres is worth.
struct SensorSource {
  FocalSource focal;
  double centre_within;  // of a side: a centre further from the middle is not believed, but is the middle
};
constexpr double kCentreWithin = 0.1;
constexpr SensorSource kSensorByTag{FocalSource::kXmpCamera, kCentreWithin};
// A sensor that is given another size than its maker gave it moves a centre by half of the difference.
constexpr SensorSource kSensorByTable{FocalSource::kXmpCamera, 0.01};
constexpr SensorSource kSensorByRoundedNumber{FocalSource::k35mmEquivalent, 0.0};

std::optional<ChosenIntrinsics> FromXmpCamera(int width_px, int height_px, const ExifRecord& exif,
                                              const SensorSource& sensor, const XmpTags& xmp,
                                              std::vector<Remark>& notes) {
  const auto focal = xmp.Number("Camera:PerspectiveFocalLength");
  if (!focal) return std::nullopt;
  const std::string unit = xmp.Text("Camera:PerspectiveFocalLengthUnits");
  // MicaSense's firmwares before 3 write pixels and no unit.
  constexpr double kLongestLensMm = 200.0;
  const bool is_in_pixels = unit.starts_with("p") || (unit.empty() && *focal > kLongestLensMm);
  if (!is_in_pixels && !exif.focal_plane_x_px_per_mm) return std::nullopt;
  const double px_per_unit = is_in_pixels ? 1.0 : *exif.focal_plane_x_px_per_mm;
  const double focal_px = *focal * px_per_unit;
  if (!IsPlausible(focal_px, width_px, height_px)) return std::nullopt;
  const FocalSource source = is_in_pixels ? FocalSource::kXmpCamera : sensor.focal;
  Intrinsics camera = Intrinsics::Centered(width_px, height_px, focal_px);
  if (xmp.Text("Camera:ModelType").starts_with("fish")) {
    notes.push_back(RemarkCode::kFisheyeAsPlain);
    return ChosenIntrinsics{camera, source};
  }
  if (const auto center = AllXmpNumbers(xmp.Text("Camera:PrincipalPoint"), 2)) {
    const auto take = [&](double px_per_x, double px_per_y, double within) {
      const double x_px = (*center)[0] * px_per_x - 0.5;
      const double y_px = (*center)[1] * px_per_y - 0.5;
      if (!(std::abs(x_px / width_px - 0.5) < within) || !(std::abs(y_px / height_px - 0.5) < within))
        return false;
      camera.center_x_px = x_px;
      camera.center_y_px = y_px;
      return true;
    };
    // Beside a focal length in pixels it is in millimetres too, as MicaSense has it.
    const std::optional<double>& per_mm = exif.focal_plane_x_px_per_mm;
    const bool is_taken = is_in_pixels && take(1.0, 1.0, kCentreWithin);
    if (!is_taken && per_mm)
      take(*per_mm, exif.focal_plane_y_px_per_mm.value_or(*per_mm), sensor.centre_within);
  }
  // R1, R2, R3, T1, T2.
  if (const auto bend = AllXmpNumbers(xmp.Text("Camera:PerspectiveDistortion"), 5);
      bend && std::all_of(bend->begin(), bend->end(), [](double v) { return std::abs(v) < 10; })) {
    const std::array terms{&camera.k1, &camera.k2, &camera.k3, &camera.p1, &camera.p2};
    for (std::size_t i = 0; i < terms.size(); ++i) *terms[i] = (*bend)[i];
  }
  return ChosenIntrinsics{camera, source};
}

// Pix4D's fisheye: the affine matrix is in pixels a right angle, the principal point in mm, and the
// polynomial of degree 3 (Sequoia) or 4 (ANAFI Ai).
std::optional<Intrinsics> FromFisheye(int width_px, int height_px, const ExifRecord& exif,
                                      const SensorSource& sensor, const XmpTags& xmp,
                                      std::vector<Remark>& notes) {
  constexpr std::size_t kAffineNumbers = 4, kFewestOfPolynomial = 4;
  const auto affine = AllXmpNumbers(xmp.Text("Camera:FisheyeAffineMatrix"), kAffineNumbers);
  const auto bend = AllXmpNumbers(xmp.Text("Camera:FisheyePolynomial"));
  const auto middle_mm = AllXmpNumbers(xmp.Text("Camera:PrincipalPoint"), 2);
  if (!affine || !bend || !middle_mm || !exif.focal_plane_x_px_per_mm) return std::nullopt;
  camera::FisheyeLens fisheye;
  if (bend->size() < kFewestOfPolynomial || bend->size() > fisheye.polynomial.size()) return std::nullopt;
  fisheye.px_per_right_angle_x = (*affine)[0];
  fisheye.px_per_right_angle_y = (*affine)[3];
  std::copy(bend->begin(), bend->end(), fisheye.polynomial.begin());
  const auto centre_px = [&](double mm, double px_per_mm, int side_px) {
    const double px = mm * px_per_mm - 0.5;
    const bool is_believed =
        sensor.centre_within >= kCentreWithin || std::abs(px / side_px - 0.5) < sensor.centre_within;
    return is_believed ? px : 0.5 * (side_px - 1);
  };
  const double x_px_per_mm = *exif.focal_plane_x_px_per_mm;
  fisheye.center_x_px = centre_px((*middle_mm)[0], x_px_per_mm, width_px);
  fisheye.center_y_px =
      centre_px((*middle_mm)[1], exif.focal_plane_y_px_per_mm.value_or(x_px_per_mm), height_px);
  const auto fitted = camera::FitFisheye(fisheye, width_px, height_px);
  if (!fitted || !IsPlausible(fitted->lens.focal_x_px, width_px, height_px)) return std::nullopt;
  constexpr double kWorthSayingPx = 1.0;
  if (fitted->worst_px > kWorthSayingPx) {
    notes.push_back({RemarkCode::kFisheyeFitted, {{"worst_px", fitted->worst_px}}});
  }
  return fitted->lens;
}

std::optional<double> FromFocalPlane(int width_px, int height_px, const ExifRecord& exif,
                                     std::vector<Remark>& notes) {
  if (!exif.focal_length_mm || !exif.focal_plane_x_px_per_mm) return std::nullopt;
  // The tag is a pixel pitch, and by it a cropped image keeps its focal length. Where the size on record
  // differs from the image's, the program that changed the image left the tags alone, and only the images can
  // tell a crop from a smaller copy.
  if (exif.recorded_width_px && std::max(width_px, height_px) != *exif.recorded_width_px) {
    notes.push_back({RemarkCode::kSizeNotAsRecorded,
                     {{"recorded_px", *exif.recorded_width_px}, {"side_px", std::max(width_px, height_px)}}});
  }
  return *exif.focal_length_mm * *exif.focal_plane_x_px_per_mm;
}

std::optional<double> FromSensorTable(int width_px, int height_px, const ExifRecord& exif) {
  const auto sensor = camera::FindSensor(exif.model);
  if (!exif.focal_length_mm || !sensor) return std::nullopt;
  const double native_px = *exif.focal_length_mm / sensor->width_mm * sensor->native_width_px;
  return native_px *
         camera::ScaleFromNative(width_px, height_px, sensor->native_width_px, sensor->native_height_px);
}

// Equivalents are whole millimetres, and of the width or the diagonal.
constexpr double kFocalTolerance = 1.2;

bool IsNear(double ratio, double wanted) {
  return ratio > wanted / kFocalTolerance && ratio < wanted * kFocalTolerance;
}

bool IsNearer(double ratio, double wanted, double other) {
  return IsNear(ratio, wanted) && std::abs(std::log(ratio / wanted)) < std::abs(std::log(ratio / other));
}

std::optional<double> FromEquivalent(int width_px, int height_px, const ExifRecord& exif) {
  if (!exif.focal_length_35mm_mm) return std::nullopt;
  return FocalPxFrom35mm(*exif.focal_length_35mm_mm, width_px, height_px);
}

// Pixels of the picture in a millimetre of its sensor, as the table of sensors has it.
std::optional<double> PxPerMmByTable(int width_px, int height_px, const ExifRecord& exif) {
  const auto sensor = camera::FindSensor(exif.model);
  if (!sensor) return std::nullopt;
  return sensor->native_width_px / sensor->width_mm *
         camera::ScaleFromNative(width_px, height_px, sensor->native_width_px, sensor->native_height_px);
}

// As the 35 mm equivalent has it.
std::optional<double> PxPerMmByEquivalent(int width_px, int height_px, const ExifRecord& exif) {
  const auto equivalent_px = FromEquivalent(width_px, height_px, exif);
  if (!equivalent_px || !exif.focal_length_mm || exif.digital_zoom > 1.0) return std::nullopt;
  return *equivalent_px / *exif.focal_length_mm;
}

// Where no tag says it: the table's, else the equivalent's. Nothing where the two contradict each other (a
// picture of a part of its sensor), or the lens in XMP what EXIF says of it, or a zoom comes between.
std::optional<double> PxPerMmUntagged(int width_px, int height_px, const ExifRecord& exif,
                                      const XmpTags& xmp) {
  if (exif.digital_zoom > 1.0) return std::nullopt;
  const auto by_table = PxPerMmByTable(width_px, height_px, exif);
  const auto by_equivalent = PxPerMmByEquivalent(width_px, height_px, exif);
  if (by_table && by_equivalent && !IsNear(*by_table / *by_equivalent, 1.0)) return std::nullopt;
  const auto px_per_mm = by_table ? by_table : by_equivalent;
  const auto lens_mm = xmp.Number("Camera:PerspectiveFocalLength");
  if (!px_per_mm || !lens_mm) return px_per_mm;
  if (exif.focal_length_mm && !IsNear(*lens_mm / *exif.focal_length_mm, 1.0)) return std::nullopt;
  const auto equivalent_px = FromEquivalent(width_px, height_px, exif);
  if (equivalent_px && !IsNear(*lens_mm * *px_per_mm / *equivalent_px, 1.0)) return std::nullopt;
  return px_per_mm;
}

// Whether a zoom is recorded that is more than what nominal focal lengths differ by.
bool IsZoomed(const ExifRecord& exif) { return exif.digital_zoom > kFocalTolerance; }

ChosenIntrinsics DoubtedForZoom(const Intrinsics& camera, const ExifRecord& exif,
                                std::vector<Remark>& notes) {
  notes.push_back({RemarkCode::kZoomDoubtful,
                   {{"zoom_percent", 100.0 * exif.digital_zoom}, {"focal_px", camera.MeanFocalPx()}}});
  return {camera, FocalSource::kDoubtful};
}

// Calibrations are of the lens, and some writers have counted the digital zoom in them: which it is the
// sensor and the lens tell, else the 35 mm equivalent where that alone counts the zoom.
ChosenIntrinsics CalibratedWithZoom(Intrinsics camera, FocalSource source, const ExifRecord& exif,
                                    std::vector<Remark>& notes) {
  if (!IsZoomed(exif)) return {camera, source};
  const double zoom = exif.digital_zoom;
  const double focal_px = camera.MeanFocalPx();
  const auto of_lens_px = FromSensorTable(camera.width_px, camera.height_px, exif);
  if (of_lens_px && IsNearer(focal_px / *of_lens_px, zoom, 1.0)) return {camera, source};
  const auto equivalent_px = FromEquivalent(camera.width_px, camera.height_px, exif);
  const bool is_of_lens = (of_lens_px && IsNearer(focal_px / *of_lens_px, 1.0, zoom)) ||
                          (equivalent_px && IsNearer(*equivalent_px / focal_px, zoom, 1.0));
  if (!is_of_lens || !IsPlausible(zoom * focal_px, camera.width_px, camera.height_px))
    return DoubtedForZoom(camera, exif, notes);
  // What is left of the image lies around its middle.
  const double middle_x_px = 0.5 * (camera.width_px - 1), middle_y_px = 0.5 * (camera.height_px - 1);
  camera.center_x_px = middle_x_px + zoom * (camera.center_x_px - middle_x_px);
  camera.center_y_px = middle_y_px + zoom * (camera.center_y_px - middle_y_px);
  camera.focal_x_px *= zoom;
  camera.focal_y_px *= zoom;
  notes.push_back(
      {RemarkCode::kZoomCounted, {{"zoom_percent", 100.0 * zoom}, {"focal_px", zoom * focal_px}}});
  return {camera, source};
}

// The focal length by the sensor against the 35 mm equivalent, which is of the picture: where that is longer,
// the camera used a part of its sensor (a crop mode).
ChosenIntrinsics BySensorOrCrop(const Intrinsics& by_sensor, const ExifRecord& exif,
                                std::vector<Remark>& notes) {
  constexpr double kStrongestCrop = 2.2;  // of full frame to four thirds
  const auto equivalent_px = FromEquivalent(by_sensor.width_px, by_sensor.height_px, exif);
  if (!equivalent_px || IsZoomed(exif) || IsNear(*equivalent_px / by_sensor.focal_x_px, 1.0))
    return {by_sensor, FocalSource::kSensorTable};
  const bool is_crop = *equivalent_px > by_sensor.focal_x_px &&
                       *equivalent_px < kStrongestCrop * by_sensor.focal_x_px &&
                       IsPlausible(*equivalent_px, by_sensor.width_px, by_sensor.height_px);
  notes.push_back({is_crop ? RemarkCode::kCropOfSensor : RemarkCode::kFocalLengthsApart,
                   {{"equivalent_px", *equivalent_px}, {"sensor_px", by_sensor.focal_x_px}}});
  if (!is_crop) return {by_sensor, FocalSource::kDoubtful};
  return {Intrinsics::Centered(by_sensor.width_px, by_sensor.height_px, *equivalent_px),
          FocalSource::k35mmEquivalent};
}

// Whether a picture has the shape of a whole one: its camera's, or one that is usual.
bool HasShapeOfWhole(int width_px, int height_px, const std::optional<camera::SensorSize>& sensor) {
  constexpr double kRounded = 0.005;
  const auto shape_of = [](double a, double b) { return std::max(a, b) / std::min(a, b); };
  const auto is = [&](double whole) {
    return std::abs(shape_of(width_px, height_px) / whole - 1.0) < kRounded;
  };
  if (sensor && is(shape_of(sensor->native_width_px, sensor->native_height_px))) return true;
  return is(4.0 / 3.0) || is(3.0 / 2.0) || is(16.0 / 9.0);
}

// The size of APS-C on record and decoded, and the pixels of the whole sensor in a millimetre: a crop mode of
// a full-frame camera. Copies are seldom made just as much smaller.
bool HasSizeOfCropMode(int width_px, int height_px, const ExifRecord& exif,
                       const std::optional<camera::SensorSize>& sensor) {
  constexpr double kFullFrameMm = 35.0, kMinCrop = 1.515, kMaxCrop = 1.55, kPitchWithin = 0.03;
  const int side_px = std::max(width_px, height_px);
  if (!sensor || !exif.focal_plane_x_px_per_mm || sensor->width_mm < kFullFrameMm ||
      exif.recorded_width_px != side_px)
    return false;
  const double native_px_per_mm = sensor->native_width_px / sensor->width_mm;
  const double crop = static_cast<double>(sensor->native_width_px) / side_px;
  return crop > kMinCrop && crop < kMaxCrop &&
         std::abs(*exif.focal_plane_x_px_per_mm / native_px_per_mm - 1.0) < kPitchWithin;
}

// Inches for centimetres and the like, or the pixels of a picture of another size: why the focal plane's
// resolution is not what it says, by the sensor and the lens that the other tags tell of, or by a sensor that
// no camera has.
std::optional<Remark> WhyPlaneIsWrong(int width_px, int height_px, const ExifRecord& exif) {
  if (!exif.focal_plane_x_px_per_mm) return std::nullopt;
  const double side_px = std::max(width_px, height_px);
  const double recorded_px = exif.recorded_width_px.value_or(side_px);
  const double sensor_mm = recorded_px / *exif.focal_plane_x_px_per_mm;
  struct Other {
    std::optional<double> px_per_mm;
    RemarkCode name;
  };
  const auto sensor = camera::FindSensor(exif.model);
  auto of_table = PxPerMmByTable(width_px, height_px, exif);
  // The table knows whole pictures: of this one the equivalent alone tells.
  if (HasSizeOfCropMode(width_px, height_px, exif, sensor)) of_table.reset();
  const auto of_equivalent = PxPerMmByEquivalent(width_px, height_px, exif);
  std::optional<Remark> why;
  for (const Other& other :
       {Other{of_table, RemarkCode::kSensorAsKnown}, Other{of_equivalent, RemarkCode::kSensorByEquivalent}}) {
    if (!other.px_per_mm) continue;
    const double as_written = *exif.focal_plane_x_px_per_mm / *other.px_per_mm;
    // A crop keeps the pixels of the tag, a smaller copy does not.
    const double as_smaller_copy = as_written * side_px / recorded_px;
    if (IsNear(as_written, 1.0) || IsNear(as_smaller_copy, 1.0)) return std::nullopt;
    constexpr double kUnits[] = {2.54, 10.0, 25.4};
    const bool is_unit = std::any_of(std::begin(kUnits), std::end(kUnits), [&](double factor) {
      return IsNear(as_smaller_copy, factor) || IsNear(as_smaller_copy, 1.0 / factor);
    });
    // Fewer pixels than by the tag: a copy of the whole that was made smaller, else a part, which keeps them.
    constexpr double kClearlyApart = 1.4;
    const bool is_of_other_size =
        as_smaller_copy < 1.0 / kClearlyApart ||
        (as_smaller_copy > kClearlyApart && HasShapeOfWhole(width_px, height_px, sensor));
    if (!is_unit && !is_of_other_size) continue;
    why = {is_unit ? RemarkCode::kSensorOfWrongUnit : RemarkCode::kSensorOfOtherSize,
           {{"written_mm", sensor_mm},
            {"sensor_mm", sensor_mm * as_smaller_copy},
            {"known", Remark(other.name)}}};
  }
  constexpr double kNarrowestMm = 1.5, kWidestMm = 60.0;
  if (why || (sensor_mm > kNarrowestMm && sensor_mm < kWidestMm)) return why;
  return Remark{RemarkCode::kSensorImpossible, {{"written_mm", sensor_mm}}};
}

// FLIR's thermal cameras write the sides of their sensor, which have the picture's shape, where its pixels in
// a millimetre are due, which are as many one way as the other.
void TakeSidesOfSensor(int width_px, int height_px, ExifRecord& exif) {
  constexpr double kShapeWithin = 0.01, kMinOblong = 1.05;
  // Finer ones do not see waves of 8 to 14 micrometres: a Zenmuse XT2 writes sides that make 6.
  constexpr double kMinPixelMm = 0.008, kMaxPixelMm = 0.1;
  if (!exif.focal_plane_x_mm || !exif.focal_plane_y_mm) return;
  const double shape = *exif.focal_plane_x_mm / *exif.focal_plane_y_mm;
  const double of_picture = static_cast<double>(width_px) / height_px;
  const double pixel_mm = *exif.focal_plane_x_mm / width_px;
  if (shape < kMinOblong || std::abs(shape / of_picture - 1.0) > kShapeWithin || pixel_mm < kMinPixelMm ||
      pixel_mm > kMaxPixelMm)
    return;
  exif.focal_plane_x_px_per_mm = exif.focal_plane_y_px_per_mm = 1.0 / pixel_mm;
}

}  // namespace

double FocalPxFrom35mm(double focal_35mm, int width_px, int height_px) {
  const double width = std::max(width_px, height_px);
  double height = std::min(width_px, height_px);
  if (width > 1.6 * height) height = 0.75 * width;
  return focal_35mm / std::hypot(36.0, 24.0) * std::hypot(width, height);
}

ChosenIntrinsics ChooseIntrinsics(int width_px, int height_px, const ExifRecord& recorded, const XmpTags& xmp,
                                  std::vector<Remark>& notes) {
  if (const auto camera = FromDewarpData(width_px, height_px, xmp))
    return CalibratedWithZoom(*camera, FocalSource::kDewarpData, recorded, notes);
  if (const auto camera = FromCalibratedFocalLength(width_px, height_px, xmp))
    return CalibratedWithZoom(*camera, FocalSource::kCalibrated, recorded, notes);
  if (const auto camera = FromSkydioCalibration(width_px, height_px, xmp))
    return CalibratedWithZoom(*camera, FocalSource::kCalibrated, recorded, notes);
  ExifRecord exif = recorded;
  // Of an upright picture the width on record is the shorter side.
  if (exif.recorded_width_px == std::min(width_px, height_px))
    exif.recorded_width_px = std::max(width_px, height_px);
  TakeSidesOfSensor(width_px, height_px, exif);
  if (auto why = WhyPlaneIsWrong(width_px, height_px, exif)) {
    notes.push_back(*std::move(why));
    exif.focal_plane_x_px_per_mm.reset();
    exif.focal_plane_y_px_per_mm.reset();
  }
  ExifRecord measured = exif;  // with the sensor's size, wherever it is known from
  if (!measured.focal_plane_x_px_per_mm)
    measured.focal_plane_x_px_per_mm = PxPerMmUntagged(width_px, height_px, exif, xmp);
  const SensorSource sensor = exif.focal_plane_x_px_per_mm     ? kSensorByTag
                              : camera::FindSensor(exif.model) ? kSensorByTable
                                                               : kSensorByRoundedNumber;
  if (const auto found = FromXmpCamera(width_px, height_px, measured, sensor, xmp, notes)) return *found;
  if (const auto camera = FromFisheye(width_px, height_px, measured, sensor, xmp, notes)) {
    return {*camera, FocalSource::kXmpCamera};
  }
  const auto chosen = [&](std::optional<double> focal_px,
                          FocalSource source) -> std::optional<ChosenIntrinsics> {
    if (!focal_px || !IsPlausible(*focal_px, width_px, height_px)) return std::nullopt;
    return ChosenIntrinsics{Intrinsics::Centered(width_px, height_px, *focal_px), source};
  };
  std::vector<Remark> focal_plane_notes;
  auto focal_plane = FromFocalPlane(width_px, height_px, exif, focal_plane_notes);
  auto table = FromSensorTable(width_px, height_px, exif);
  if (exif.digital_zoom > 1.0) {
    if (focal_plane) *focal_plane *= exif.digital_zoom;
    if (table) *table *= exif.digital_zoom;
  }
  if (const auto found = chosen(focal_plane, FocalSource::kFocalPlane)) {
    notes.insert(notes.end(), focal_plane_notes.begin(), focal_plane_notes.end());
    return *found;
  }
  if (const auto found = chosen(table, FocalSource::kSensorTable))
    return BySensorOrCrop(found->intrinsics, exif, notes);
  const auto equivalent = FromEquivalent(width_px, height_px, exif);
  if (const auto found = chosen(equivalent, FocalSource::k35mmEquivalent)) {
    // Some count the digital zoom in it (phones), some do not.
    return IsZoomed(exif) ? DoubtedForZoom(found->intrinsics, exif, notes) : *found;
  }
  constexpr double kUsualFocalPerSide = 0.8;
  notes.push_back(RemarkCode::kNoFocalLength);
  return {Intrinsics::Centered(width_px, height_px, kUsualFocalPerSide * std::max(width_px, height_px)),
          FocalSource::kAssumed};
}

}  // namespace skyquilt::flight
