#include "core/bands/read_radiometry.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <numbers>
#include <utility>

#include "core/base/median.h"
#include "core/flight/bytes/log_bytes.h"
#include "core/flight/metadata/exif.h"

namespace skyquilt::bands {
namespace {

constexpr std::size_t kRecordBytes = 28;
constexpr std::size_t kMaxRecords = 4096;
constexpr std::array<double, 4> kGains = {1.0, 25.0, 428.0, 9876.0};
constexpr double kSaturatedCounts = 60'000.0;
constexpr double kLastSeconds = 2.0;

}  // namespace

std::optional<std::vector<SunshineRecord>> ReadIrradianceList(std::string_view text) {
  const auto bytes = flight::FromBase64(text, kRecordBytes * kMaxRecords);
  if (!bytes || bytes->size() < kRecordBytes) return std::nullopt;
  std::vector<SunshineRecord> records;
  // Padding may be missing: what is behind the last whole record is of no use.
  for (std::size_t at = 0; at + kRecordBytes <= bytes->size(); at += kRecordBytes) {
    const std::uint8_t* record = bytes->data() + at;
    const double time_s = 1e-6 * static_cast<double>(flight::LoadLittle<std::uint64_t>(record));
    const double counts = flight::LoadLittle<std::uint16_t>(record + 8);
    const std::size_t gain = flight::LoadLittle<std::uint16_t>(record + 12);
    const double integration_ms = flight::LoadLittle<std::uint16_t>(record + 14);
    if (gain >= kGains.size() || !(integration_ms > 0.0) || counts >= kSaturatedCounts || counts <= 0.0)
      continue;
    records.push_back({time_s, counts / integration_ms / kGains[gain]});
  }
  if (records.empty()) return std::nullopt;
  return records;
}

std::optional<double> CalibrationCounts(std::string_view text) {
  constexpr std::size_t kNumbersAGain = 4;
  const auto numbers = flight::AllXmpNumbers(text);
  if (!numbers || numbers->size() % kNumbersAGain != 0) return std::nullopt;
  std::optional<double> best;
  double best_gain = 0.0;
  for (std::size_t at = 0; at < numbers->size(); at += kNumbersAGain) {
    const double index = (*numbers)[at], integration_ms = (*numbers)[at + 1], counts = (*numbers)[at + 2];
    if (!(index >= 0.0) || !(index < static_cast<double>(kGains.size())) || index != std::floor(index))
      continue;
    if (!(integration_ms > 0.0) || !(counts > 0.0) || counts >= kSaturatedCounts) continue;
    const double gain = kGains[static_cast<std::size_t>(index)];
    if (gain < best_gain) continue;
    best_gain = gain;
    best = counts / integration_ms / gain;
  }
  return best;
}

double LastCounts(const std::vector<SunshineRecord>& records) {
  double last_s = 0.0;
  for (const SunshineRecord& record : records) last_s = std::max(last_s, record.time_s);
  std::vector<double> counts;
  for (const SunshineRecord& record : records) {
    if (record.time_s >= last_s - kLastSeconds) counts.push_back(record.counts_per_ms);
  }
  return Median(std::move(counts));
}

namespace {

using flight::AllXmpNumbers;
using flight::ExifIfd;
using flight::ExifTable;
using flight::XmpTags;

constexpr std::uint16_t kBlackLevelTag = 0xC61A;
constexpr std::uint16_t kModelTag = 0x0110, kSoftwareTag = 0x0131;
constexpr std::uint16_t kBitsTag = 0x0102;
constexpr double kLevels16 = 65536.0;
// Samples of 8 bits are spread over 16 when they are decoded.
constexpr double kLevelsOfEightBits = 256.0, kSixteenOfEightBits = 257.0;
constexpr double kLevelsOfTenBits = 64.0;  // 16-bit levels in one of 10 bits
constexpr double kIsoOfGainOne = 100.0;

std::optional<double> Positive(std::optional<double> value) {
  return value && *value > 0.0 && std::isfinite(*value) ? value : std::nullopt;
}

// Seconds and gain; nothing where either is not known.
struct Exposure {
  double time_s = 1.0;
  double gain = 1.0;
};
std::optional<Exposure> ExposureOf(const ExifTable& exif) {
  const auto time_s = flight::ExposureTimeS(exif);
  const auto iso = flight::IsoOf(exif);
  if (!time_s) return std::nullopt;
  return Exposure{*time_s, iso ? *iso / kIsoOfGainOne : 1.0};
}

// Of the four pixels of the sensor's pattern; one number holds for all.
void ReadBlackLevel(const ExifTable& exif, const XmpTags& xmp, Radiometry& radiometry) {
  std::array<std::optional<double>, 4> levels;
  for (std::size_t i = 0; i < levels.size(); ++i) levels[i] = exif.Number(ExifIfd::kImage, kBlackLevelTag, i);
  if (!levels[0]) levels[0] = xmp.Number("drone-dji:BlackLevel");
  if (!levels[0]) levels[0] = xmp.Number("drone-dji:BlackCurrent");
  if (!levels[0]) levels[0] = xmp.Number("Camera:BlackCurrent");
  const bool has_eight_bits = exif.Number(ExifIfd::kImage, kBitsTag) == 8.0;
  for (std::size_t i = 0; i < levels.size(); ++i) {
    double level = levels[i].value_or(levels[0].value_or(0.0));
    if (has_eight_bits && level < kLevelsOfEightBits) level *= kSixteenOfEightBits;
    radiometry.black[i] = level >= 0.0 && level < kLevels16 ? level : 0.0;
  }
}

BandVignetting PlaneVignetting(const XmpTags& xmp) {
  BandVignetting vignetting;
  const auto powers = AllXmpNumbers(xmp.Text("Camera:VignettingPolynomial2DName"));
  const auto factors = AllXmpNumbers(xmp.Text("Camera:VignettingPolynomial2D"));
  constexpr double kMaxPower = 16.0;
  if (!powers || !factors || powers->size() != 2 * factors->size()) return vignetting;
  if (std::any_of(powers->begin(), powers->end(), [](double power) {
        return !(power >= 0.0) || power > kMaxPower || power != std::floor(power);
      }))
    return vignetting;
  for (std::size_t i = 0; i < factors->size(); ++i) {
    vignetting.terms.push_back(
        {static_cast<int>((*powers)[2 * i]), static_cast<int>((*powers)[2 * i + 1]), (*factors)[i]});
  }
  vignetting.kind = BandVignetting::Kind::kPlaneDivides;
  return vignetting;
}

BandVignetting RadialVignetting(const std::string& polynomial, std::optional<double> center_x_px,
                                std::optional<double> center_y_px, BandVignetting::Kind kind) {
  BandVignetting vignetting;
  constexpr std::size_t kMaxTerms = 10;
  auto factors = AllXmpNumbers(polynomial);
  if (!factors || factors->size() > kMaxTerms || !center_x_px || !center_y_px) return vignetting;
  vignetting.radial = *std::move(factors);
  vignetting.center_x_px = *center_x_px;
  vignetting.center_y_px = *center_y_px;
  vignetting.kind = kind;
  return vignetting;
}

BandVignetting CameraRadialVignetting(const XmpTags& xmp, BandVignetting::Kind kind) {
  const auto center = AllXmpNumbers(xmp.Text("Camera:VignettingCenter"), 2);
  if (!center) return {};
  return RadialVignetting(xmp.Text("Camera:VignettingPolynomial"), (*center)[0], (*center)[1], kind);
}

bool ReadSequoia(const ExifTable& exif, const XmpTags& xmp, Radiometry& radiometry) {
  const auto sensor = AllXmpNumbers(xmp.Text("Camera:SensorModel"), 3);
  const auto measured = AllXmpNumbers(xmp.Text("Camera:CalibrationMeasurement"), 3);
  const auto exposure = ExposureOf(exif);
  if ((!sensor && !measured) || !exposure) return false;
  radiometry.vignetting = PlaneVignetting(xmp);
  const auto sunlight = ReadIrradianceList(xmp.Text("Camera:IrradianceList"));
  const auto calibration_counts = CalibrationCounts(xmp.Text("Camera:IrradianceCalibrationMeasurement"));
  const double dark = xmp.Number("Camera:BlackCurrent").value_or(0.0);  // of 10 bits
  if (!exif.Number(ExifIfd::kImage, kBlackLevelTag))
    radiometry.black.fill(std::clamp(dark * kLevelsOfTenBits, 0.0, kLevels16));
  const bool is_measured = measured && (*measured)[0] > 0.0 && (*measured)[1] > 0.0 && (*measured)[2] > dark;
  if (is_measured && sunlight && calibration_counts) {
    const double calibration_rate =
        ((*measured)[2] - dark) * kLevelsOfTenBits / ((*measured)[0] * (*measured)[1]);
    const double sun = LastCounts(*sunlight) / *calibration_counts;
    radiometry.per_level = 1.0 / (exposure->time_s * exposure->gain * calibration_rate * sun);
    radiometry.sunlight = sun;
    radiometry.calibration = Calibration::kRelative;
    radiometry.method =
        "the factory's measurement of camera and sunshine sensor under one light (Parrot SEQ-AN-01, SEQ-AN-02)";
    return true;
  }
  // A and C beside each other count the speed as ISO, not as a gain.
  const double iso_s = exposure->time_s * exposure->gain * kIsoOfGainOne;
  if (sensor && (*sensor)[0] * iso_s + (*sensor)[2] > 0.0) {
    constexpr std::uint16_t kFNumberTag = 0x829D;
    const double f_number = Positive(exif.Number(ExifIfd::kExif, kFNumberTag)).value_or(1.0);
    radiometry.black.fill(std::clamp((*sensor)[1], 0.0, kLevels16));
    radiometry.per_level = f_number * f_number / ((*sensor)[0] * iso_s + (*sensor)[2]);
    radiometry.method = "the sensor model (Parrot SEQ-AN-01)";
  } else {
    radiometry.per_level = 1.0 / (kLevels16 * exposure->time_s * exposure->gain);
    radiometry.method = "exposure and gain";
  }
  radiometry.calibration = Calibration::kRadiance;
  if (sunlight) {
    radiometry.sunlight = LastCounts(*sunlight);
    radiometry.per_level /= *radiometry.sunlight;
    radiometry.calibration = Calibration::kRelative;
    radiometry.method += " over the sunshine sensor (Parrot SEQ-AN-02)";
  }
  return true;
}

// Early firmwares of RedEdge wrote this time for one that had been longer.
double MicaSenseExposureS(const ExifTable& exif, double written_s) {
  constexpr double kWrongS = 1.0 / 6329.0, kTrueS = 0.000274, kSameS = 1e-8;
  const bool is_rededge = exif.Text(ExifIfd::kImage, kModelTag).starts_with("RedEdge");
  return is_rededge && std::abs(written_s - kWrongS) < kSameS ? kTrueS : written_s;
}

// Some firmwares worked the irradiance of a level ground out wrongly from what the light sensor had measured.
bool IsHorizontalIrradianceRight(const ExifTable& exif) {
  using Version = std::array<int, 3>;
  const std::string model = exif.Text(ExifIfd::kImage, kModelTag);
  const std::string software = exif.Text(ExifIfd::kImage, kSoftwareTag);
  const std::size_t digit = software.find_first_of("0123456789");
  Version version{};
  if (digit == std::string::npos ||
      std::sscanf(software.c_str() + digit, "%3d.%3d.%3d", &version[0], &version[1], &version[2]) != 3)
    return true;
  if (model == "Altum") return version >= Version{1, 2, 3};
  if (model == "RedEdge" || model == "RedEdge-M") return version >= Version{5, 1, 7};
  return true;
}

struct Irradiance {
  double si = 1.0;             // W/m^2/nm
  bool is_as_measured = true;  // by the sensor as it was tilted, not of level ground
};
std::optional<Irradiance> MicaSenseIrradiance(const ExifTable& exif, const XmpTags& xmp) {
  const auto first_of = [&](const char* name) {
    const auto number = xmp.Number(std::string("Camera:") + name);
    return number ? number : xmp.Number(std::string("DLS:") + name);
  };
  // The second light sensor, which alone tells of level ground, counts in uW/cm^2/nm.
  constexpr double kSiOfMicrowatts = 0.01;
  const auto horizontal = first_of("HorizontalIrradiance");
  const double scale =
      Positive(first_of("IrradianceScaleToSIUnits")).value_or(horizontal ? kSiOfMicrowatts : 1.0);
  if (Positive(horizontal) && IsHorizontalIrradianceRight(exif))
    return Irradiance{*horizontal * scale, false};
  for (const char* name : {"DLS:SpectralIrradiance", "Camera:SpectralIrradiance", "Camera:Irradiance"}) {
    if (const auto measured = Positive(xmp.Number(name))) return Irradiance{*measured * scale, true};
  }
  return std::nullopt;
}

bool ReadMicaSense(const ExifTable& exif, const XmpTags& xmp, Radiometry& radiometry) {
  const auto a = AllXmpNumbers(xmp.Text("MicaSense:RadiometricCalibration"), 3);
  const auto exposure = ExposureOf(exif);
  if (!a || !exposure || !((*a)[0] > 0.0)) return false;
  radiometry.vignetting = CameraRadialVignetting(xmp, BandVignetting::Kind::kRadialDivides);
  radiometry.rows = {MicaSenseExposureS(exif, exposure->time_s), (*a)[1], (*a)[2]};
  radiometry.per_level = (*a)[0] / exposure->gain / kLevels16;
  double mean = 0.0;  // the model takes the mean of the four
  for (const double black : radiometry.black) mean += 0.25 * black;
  radiometry.black.fill(mean);
  radiometry.calibration = Calibration::kRadiance;
  radiometry.method = "the radiometric calibration model for MicaSense sensors";
  if (const auto irradiance = MicaSenseIrradiance(exif, xmp)) {
    radiometry.per_level *= std::numbers::pi / irradiance->si;
    radiometry.sunlight = irradiance->si;
    radiometry.calibration = Calibration::kReflectance;
    radiometry.method += ", over the light sensor";
    if (irradiance->is_as_measured) radiometry.method += " as it was tilted";
  }
  return true;
}

bool ReadDji(const XmpTags& xmp, Radiometry& radiometry) {
  const auto gain = Positive(xmp.Number("drone-dji:SensorGain"));
  const auto exposure_us = Positive(xmp.Number("drone-dji:ExposureTime"));
  if (!gain || !exposure_us) return false;
  radiometry.vignetting = RadialVignetting(
      xmp.Text("drone-dji:VignettingData"), xmp.Number("drone-dji:CalibratedOpticalCenterX"),
      xmp.Number("drone-dji:CalibratedOpticalCenterY"), BandVignetting::Kind::kRadialMultiplies);
  if (radiometry.vignetting.kind == BandVignetting::Kind::kNone)
    radiometry.vignetting = CameraRadialVignetting(xmp, BandVignetting::Kind::kRadialMultiplies);
  constexpr double kMicro = 1e-6;
  radiometry.per_level = 1.0 / ((kLevels16 - 1.0) * *gain * *exposure_us * kMicro);
  radiometry.calibration = Calibration::kRadiance;
  radiometry.method = "DJI's image processing guide";
  const auto adjustment = Positive(xmp.Number("drone-dji:SensorGainAdjustment"));
  auto sunlight = Positive(xmp.Number("drone-dji:Irradiance"));
  if (!sunlight) sunlight = Positive(xmp.Number("Camera:Irradiance"));
  // 0: a dongle at the aircraft's port covers it.
  const bool is_sensor_free = xmp.Number("drone-dji:LS_status") != 0.0;
  if (adjustment && sunlight && is_sensor_free) {
    radiometry.per_level *= *adjustment / *sunlight;
    radiometry.sunlight = sunlight;
    radiometry.calibration = Calibration::kRelative;
    radiometry.method += ", over the sunlight sensor";
  }
  return true;
}

}  // namespace

Radiometry ReadRadiometry(const ExifTable& exif, const XmpTags& xmp) {
  Radiometry radiometry;
  ReadBlackLevel(exif, xmp, radiometry);
  if (ReadMicaSense(exif, xmp, radiometry)) return radiometry;
  if (ReadSequoia(exif, xmp, radiometry)) return radiometry;
  if (ReadDji(xmp, radiometry)) return radiometry;
  radiometry.per_level = 1.0 / kLevels16;
  radiometry.method = "stored levels";
  if (const auto exposure = ExposureOf(exif)) {
    radiometry.per_level /= exposure->time_s * exposure->gain;
    radiometry.calibration = Calibration::kRadiance;
    radiometry.method = "exposure and gain of EXIF";
  }
  return radiometry;
}

}  // namespace skyquilt::bands
