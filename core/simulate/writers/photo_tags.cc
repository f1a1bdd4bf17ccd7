#include "core/simulate/writers/photo_tags.h"

#include <fmt/chrono.h>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string_view>

#include "core/geo/geoid.h"
#include "core/simulate/writers/write_logs.h"

namespace skyquilt::simulate {
namespace {

constexpr double kPixelPitchMm = 0.0024;

// One image file directory in the making: entries sorted by tag, values beyond four bytes after the entries.
class Directory {
 public:
  void Ascii(std::uint16_t tag, std::string_view text) {
    std::vector<std::uint8_t> bytes(text.begin(), text.end());
    bytes.push_back(0);
    Bytes(tag, 2, std::move(bytes));
  }
  void Bytes(std::uint16_t tag, std::uint16_t type, std::vector<std::uint8_t> bytes) {
    const auto count = static_cast<std::uint32_t>(bytes.size());
    entries_.push_back({tag, type, count, std::move(bytes)});
  }
  void Short(std::uint16_t tag, std::uint16_t value) {
    entries_.push_back({tag, 3, 1, ByteWriter().Put(value).bytes()});
  }
  void Long(std::uint16_t tag, std::uint32_t value) {
    entries_.push_back({tag, 4, 1, ByteWriter().Put(value).bytes()});
  }
  void Rationals(std::uint16_t tag, const std::vector<std::pair<std::uint32_t, std::uint32_t>>& values) {
    ByteWriter bytes;
    for (const auto& [numerator, denominator] : values) bytes.Put(numerator).Put(denominator);
    entries_.push_back({tag, 5, static_cast<std::uint32_t>(values.size()), std::move(bytes.bytes())});
  }
  std::size_t Size() const {
    std::size_t size = 2 + 12 * entries_.size() + 4;
    for (const Entry& entry : entries_) size += entry.bytes.size() > 4 ? Even(entry.bytes.size()) : 0;
    return size;
  }
  // The directory's bytes when it begins at `offset` of the TIFF structure.
  std::vector<std::uint8_t> Build(std::size_t offset) {
    std::sort(entries_.begin(), entries_.end(), [](const Entry& a, const Entry& b) { return a.tag < b.tag; });
    ByteWriter writer;
    std::vector<std::uint8_t>& head = writer.bytes();
    std::vector<std::uint8_t> tail;
    writer.Put(static_cast<std::uint16_t>(entries_.size()));
    const std::size_t tail_at = offset + 2 + 12 * entries_.size() + 4;
    for (const Entry& entry : entries_) {
      writer.Put(entry.tag).Put(entry.type).Put(entry.count);
      if (entry.bytes.size() > 4) {
        writer.Put(static_cast<std::uint32_t>(tail_at + tail.size()));
        tail.insert(tail.end(), entry.bytes.begin(), entry.bytes.end());
        tail.resize(Even(tail.size()));
      } else {
        head.insert(head.end(), entry.bytes.begin(), entry.bytes.end());
        head.resize(head.size() + 4 - entry.bytes.size());
      }
    }
    writer.Put(std::uint32_t{0});  // no next directory
    head.insert(head.end(), tail.begin(), tail.end());
    return std::move(head);
  }

 private:
  struct Entry {
    std::uint16_t tag, type;
    std::uint32_t count;
    std::vector<std::uint8_t> bytes;
  };
  static std::size_t Even(std::size_t n) { return n + (n & 1); }
  std::vector<Entry> entries_;
};

using Rational = std::pair<std::uint32_t, std::uint32_t>;

// Degrees, minutes and seconds; the seconds to 1e-7 (3 micrometres).
std::vector<Rational> DegreesMinutesSeconds(double degrees) {
  constexpr std::uint32_t kParts = 10000000;
  const auto total = static_cast<std::uint64_t>(std::llround(std::abs(degrees) * 3600.0 * kParts));
  const std::uint64_t whole_seconds = total / kParts;
  return {{static_cast<std::uint32_t>(whole_seconds / 3600), 1},
          {static_cast<std::uint32_t>(whole_seconds / 60 % 60), 1},
          {static_cast<std::uint32_t>(total - whole_seconds / 60 * 60 * kParts), kParts}};
}

// The height written as AbsoluteAltitude: over the ellipsoid with RTK, over the sea otherwise (over the
// ellipsoid where no geoid grid is installed).
double AbsoluteAltitudeM(const RecordedPose& recorded) {
  const geo::Wgs84& position = *recorded.position;
  if (recorded.is_rtk_fixed) return position.height_ellipsoid_m;
  return position.height_ellipsoid_m - geo::GeoidHeightM({position.lat_deg, position.lon_deg}).value_or(0.0);
}

void AddGps(const RecordedPose& recorded, Directory& gps) {
  const geo::Wgs84& position = *recorded.position;
  const double altitude_m = AbsoluteAltitudeM(recorded);
  const auto at = recorded.captured_at;
  const auto day = std::chrono::floor<std::chrono::days>(at);
  const auto of_day = at - day;
  const auto hours = std::chrono::floor<std::chrono::hours>(of_day);
  const auto minutes = std::chrono::floor<std::chrono::minutes>(of_day - hours);
  const auto rest = of_day - hours - minutes;
  gps.Bytes(0, 1, {2, 3, 0, 0});
  gps.Ascii(1, position.lat_deg < 0.0 ? "S" : "N");
  gps.Rationals(2, DegreesMinutesSeconds(position.lat_deg));
  gps.Ascii(3, position.lon_deg < 0.0 ? "W" : "E");
  gps.Rationals(4, DegreesMinutesSeconds(position.lon_deg));
  gps.Bytes(5, 1, {static_cast<std::uint8_t>(altitude_m < 0.0 ? 1 : 0)});
  gps.Rationals(6, {{static_cast<std::uint32_t>(std::llround(std::abs(altitude_m) * 10000.0)), 10000}});
  if (!recorded.is_clock_utc) return;
  gps.Rationals(7, {{static_cast<std::uint32_t>(hours.count()), 1},
                    {static_cast<std::uint32_t>(minutes.count()), 1},
                    {static_cast<std::uint32_t>(rest.count()), 1000000}});
  gps.Ascii(29, fmt::format("{:%Y:%m:%d}", fmt::gmtime(std::chrono::system_clock::to_time_t(at))));
}

std::vector<std::uint8_t> WithSignature(std::string_view signature, std::string_view body) {
  std::vector<std::uint8_t> payload(signature.begin(), signature.end());
  payload.push_back(0);
  payload.insert(payload.end(), body.begin(), body.end());
  return payload;
}

std::string Base64(const std::vector<std::uint8_t>& bytes) {
  constexpr std::string_view kSigns = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  for (std::size_t at = 0; at < bytes.size(); at += 3) {
    const std::size_t count = std::min<std::size_t>(3, bytes.size() - at);
    std::uint32_t three = 0;
    for (std::size_t k = 0; k < 3; ++k) three = (three << 8) | (k < count ? bytes[at + k] : 0u);
    for (std::size_t k = 0; k < 4; ++k) text += k <= count ? kSigns[(three >> (18 - 6 * k)) & 63u] : '=';
  }
  return text;
}

// As a Parrot Sequoia writes its gyro: records of microseconds, rates about the body's axes, and a flag.
std::string GyroTags(const RecordedPose& recorded) {
  constexpr std::uint64_t kBootedUs = 277'000'000;
  const std::vector<flight::TurnRate>& samples = recorded.turning->samples;
  ByteWriter bytes;
  for (const flight::TurnRate& sample : samples) {
    bytes.Put(kBootedUs +
              static_cast<std::uint64_t>(std::llround(1e6 * (sample.time_s - samples.front().time_s))));
    for (const double rate : {-sample.in_cam_radps.y(), sample.in_cam_radps.x(), sample.in_cam_radps.z()})
      bytes.Put(static_cast<float>(rate));
    bytes.Put(std::uint32_t{1});
  }
  return fmt::format(
      "\n   Camera:LineReadoutTime=\"{}\"\n   Camera:IMUFrequency=\"1000\"\n   Camera:IMUSampleSize=\"{}\"\n"
      "   Camera:IMUTimeOffset=\"{}\"\n   Camera:IMUAngularVelocity=\"&#xA;{}&#xA;\"",
      std::llround(1e9 * recorded.readout_s / recorded.intrinsics.height_px), samples.size(),
      std::llround(-1e9 * samples.front().time_s), Base64(bytes.bytes()));
}

// The TIFF structure with EXIF and GPS, and as the first image's tags whatever `add_image` puts there; it is
// told how long the structure becomes.
template <typename AddImage>
std::vector<std::uint8_t> TiffStructure(const RecordedPose& recorded, const Rational& exposure_s,
                                        std::uint16_t iso, const AddImage& add_image) {
  const camera::Intrinsics& lens = recorded.intrinsics;
  const auto seconds = std::chrono::floor<std::chrono::seconds>(recorded.captured_at);
  const std::string time =
      fmt::format("{:%Y:%m:%d %H:%M:%S}", fmt::gmtime(std::chrono::system_clock::to_time_t(seconds)));
  const auto micros = (recorded.captured_at - seconds).count();
  const double focal_mm = lens.MeanFocalPx() * kPixelPitchMm;
  const double focal_35mm =
      lens.MeanFocalPx() * std::hypot(36.0, 24.0) / std::hypot(lens.width_px, lens.height_px);

  const auto make_root = [&](std::size_t exif_offset, std::size_t gps_offset, std::size_t end) {
    Directory root;
    add_image(root, end);
    root.Ascii(0x010F, kCameraMake);
    root.Ascii(0x0110, kCameraModel);
    root.Short(0x0112, 1);
    root.Ascii(0x0131, "skyquilt simulate");
    root.Ascii(0x0132, time);
    root.Long(0x8769, static_cast<std::uint32_t>(exif_offset));
    if (recorded.position) root.Long(0x8825, static_cast<std::uint32_t>(gps_offset));
    return root;
  };

  Directory exif;
  exif.Rationals(0x829A, {exposure_s});
  exif.Rationals(0x829D, {{static_cast<std::uint32_t>(std::lround(10.0 * kFNumber)), 10}});
  exif.Short(0x8827, iso);
  exif.Bytes(0x9000, 7, {'0', '2', '3', '1'});
  exif.Ascii(0x9003, time);
  exif.Ascii(0x9004, time);
  if (recorded.is_clock_utc) {
    exif.Ascii(0x9011, "+00:00");
    exif.Ascii(0x9291, fmt::format("{:06}", micros));
  }
  exif.Rationals(0x920A, {{static_cast<std::uint32_t>(std::llround(focal_mm * 1e5)), 100000}});
  exif.Short(0xA001, 1);
  exif.Long(0xA002, static_cast<std::uint32_t>(lens.width_px));
  exif.Long(0xA003, static_cast<std::uint32_t>(lens.height_px));
  exif.Short(0xA405, static_cast<std::uint16_t>(std::clamp(std::lround(focal_35mm), 1L, 65535L)));

  Directory gps;
  if (recorded.position) AddGps(recorded, gps);

  // Sizes first: the offsets that the root directory holds do not change its own size.
  const std::size_t exif_at = 8 + make_root(0, 0, 0).Size();
  const std::size_t gps_at = exif_at + exif.Size();
  const std::size_t end = gps_at + (recorded.position ? gps.Size() : 0);

  std::vector<std::uint8_t> structure = {'I', 'I', 42, 0, 8, 0, 0, 0};
  const auto append = [&structure](const std::vector<std::uint8_t>& bytes) {
    structure.insert(structure.end(), bytes.begin(), bytes.end());
  };
  append(make_root(exif_at, gps_at, end).Build(8));
  append(exif.Build(exif_at));
  if (recorded.position) append(gps.Build(gps_at));
  return structure;
}

// The packet with what every photo says, and `more` attributes of `more_spaces`.
std::string XmpPacket(const RecordedPose& recorded, std::string_view more_spaces, std::string_view more) {
  const camera::Intrinsics& lens = recorded.intrinsics;
  std::string tags;
  const auto add = [&tags](std::string_view name, const std::string& value) {
    tags += fmt::format("\n   drone-dji:{}=\"{}\"", name, value);
  };
  const auto degrees = [](double rad) { return fmt::format("{:+.9f}", geo::RadToDeg(rad)); };
  if (recorded.position) {
    add("GpsLatitude", fmt::format("{:.11f}", recorded.position->lat_deg));
    add("GpsLongitude", fmt::format("{:.11f}", recorded.position->lon_deg));
    add("AltitudeType", recorded.is_rtk_fixed ? "RtkAlt" : "GPSFusionAlt");
    add("AbsoluteAltitude", fmt::format("{:+.5f}", AbsoluteAltitudeM(recorded)));
  }
  if (recorded.height_above_takeoff_m)
    add("RelativeAltitude", fmt::format("{:+.5f}", *recorded.height_above_takeoff_m));
  if (recorded.gimbal) {
    add("GimbalYawDegree", degrees(recorded.gimbal->yaw_rad));
    add("GimbalPitchDegree", degrees(recorded.gimbal->pitch_rad));
    add("GimbalRollDegree", degrees(recorded.gimbal->roll_rad));
  }
  if (recorded.airframe) {
    add("FlightYawDegree", degrees(recorded.airframe->yaw_rad));
    add("FlightPitchDegree", degrees(recorded.airframe->pitch_rad));
    add("FlightRollDegree", degrees(recorded.airframe->roll_rad));
  }
  if (recorded.velocity_in_enu_mps) {
    add("FlightXSpeed", fmt::format("{:+.2f}", recorded.velocity_in_enu_mps->y()));
    add("FlightYSpeed", fmt::format("{:+.2f}", recorded.velocity_in_enu_mps->x()));
    add("FlightZSpeed", fmt::format("{:+.2f}", -recorded.velocity_in_enu_mps->z()));
  }
  if (recorded.is_rtk_fixed) {
    add("RtkFlag", "50");
    add("RtkStdLon", "0.01500");
    add("RtkStdLat", "0.01500");
    add("RtkStdHgt", "0.02500");
  }
  add("CalibratedFocalLength", fmt::format("{:.6f}", lens.MeanFocalPx()));
  add("CalibratedOpticalCenterX", fmt::format("{:.6f}", 0.5 * lens.width_px));
  add("CalibratedOpticalCenterY", fmt::format("{:.6f}", 0.5 * lens.height_px));
  if (recorded.is_lens_recorded) {
    add("DewarpFlag", "0");
    add("DewarpData",
        fmt::format("2024-01-01;{:.6f},{:.6f},{:.6f},{:.6f},{:.12g},{:.12g},{:.12g},{:.12g},{:.12g}",
                    lens.focal_x_px, lens.focal_y_px, lens.center_x_px - 0.5 * (lens.width_px - 1),
                    lens.center_y_px - 0.5 * (lens.height_px - 1), lens.k1, lens.k2, lens.p1, lens.p2,
                    lens.k3));
  }
  std::string spaces = "xmlns:drone-dji=\"http://www.dji.com/drone-dji/1.0/\"";
  if (recorded.turning) {
    spaces += " xmlns:Camera=\"http://pix4d.com/camera/1.0/\"";
    tags += GyroTags(recorded);
  }
  spaces += more_spaces;
  tags += more;
  return fmt::format(
      "<?xpacket begin=\"\xEF\xBB\xBF\" id=\"W5M0MpCehiHzreSzNTczkc9d\"?>\n"
      "<x:xmpmeta xmlns:x=\"adobe:ns:meta/\">\n"
      " <rdf:RDF xmlns:rdf=\"http://www.w3.org/1999/02/22-rdf-syntax-ns#\">\n"
      "  <rdf:Description rdf:about=\"\" {}{}/>\n"
      " </rdf:RDF>\n</x:xmpmeta>\n<?xpacket end=\"w\"?>",
      spaces, tags);
}

// Levels of a picture as the bytes of a strip.
std::vector<std::uint8_t> StripOf(const image::SampleImage& picture) {
  ByteWriter strip;
  strip.bytes().reserve(2 * picture.samples.size());
  for (const std::uint16_t sample : picture.samples) strip.Put(sample);
  return std::move(strip.bytes());
}

std::string BandXmp(const RigBand& band, const BandExposure& exposure) {
  std::string vignetting;
  for (const double k : band.vignetting)
    vignetting += fmt::format("{}{:.12g}", vignetting.empty() ? "" : ",", k);
  std::string tags;
  const auto add = [&tags](std::string_view name, const std::string& value) {
    tags += fmt::format("\n   {}=\"{}\"", name, value);
  };
  add("Camera:BandName", band.name);
  add("Camera:CentralWavelength", fmt::format("{}", band.wavelength_nm));
  add("Camera:WavelengthFWHM", fmt::format("{}", band.width_nm));
  add("Camera:RigCameraIndex", fmt::format("{}", band.index));
  add("Camera:VignettingCenter", fmt::format("{:.6f},{:.6f}", band.vignetting_x_px, band.vignetting_y_px));
  add("Camera:VignettingPolynomial", vignetting);
  add("MicaSense:CaptureId", exposure.capture_id);
  add("MicaSense:RadiometricCalibration", fmt::format("{:.12g},{:.12g},{:.12g}", band.a1, band.a2, band.a3));
  add("DLS:SpectralIrradiance", fmt::format("{:.9g}", exposure.irradiance));
  return tags;
}

}  // namespace

std::vector<std::uint8_t> ExifPayload(const RecordedPose& recorded) {
  std::vector<std::uint8_t> payload = {'E', 'x', 'i', 'f', 0, 0};
  const std::vector<std::uint8_t> structure =
      TiffStructure(recorded, {1, static_cast<std::uint32_t>(std::llround(1.0 / recorded.exposure_time_s))},
                    100, [](Directory& /*root*/, std::size_t /*end*/) {});
  payload.insert(payload.end(), structure.begin(), structure.end());
  return payload;
}

std::vector<std::uint8_t> XmpPayload(const RecordedPose& recorded) {
  return WithSignature("http://ns.adobe.com/xap/1.0/", XmpPacket(recorded, "", ""));
}

std::vector<std::uint8_t> BandTiffBytes(const RecordedPose& recorded, const RigBand& band,
                                        const BandExposure& exposure, const image::SampleImage& picture) {
  const std::string xmp = XmpPacket(recorded,
                                    " xmlns:Camera=\"http://pix4d.com/camera/1.0/\" "
                                    "xmlns:MicaSense=\"http://micasense.com/MicaSense/1.0/\" "
                                    "xmlns:DLS=\"http://micasense.com/DLS/1.0/\"",
                                    BandXmp(band, exposure));
  const std::vector<std::uint8_t> strip = StripOf(picture);
  std::vector<std::uint8_t> file = TiffStructure(
      recorded, {exposure.exposure_us, 1'000'000}, exposure.iso, [&](Directory& root, std::size_t end) {
        root.Long(0x0100, static_cast<std::uint32_t>(picture.width_px));
        root.Long(0x0101, static_cast<std::uint32_t>(picture.height_px));
        root.Short(0x0102, 16);
        root.Short(0x0103, 1);  // not compressed
        root.Short(0x0106, 1);  // black is zero
        root.Long(0x0111, static_cast<std::uint32_t>(end));
        root.Short(0x0115, 1);
        root.Long(0x0116, static_cast<std::uint32_t>(picture.height_px));
        root.Long(0x0117, static_cast<std::uint32_t>(strip.size()));
        root.Bytes(0x02BC, 1, {xmp.begin(), xmp.end()});
        root.Short(0xC61A, band.black_level);
      });
  file.insert(file.end(), strip.begin(), strip.end());
  return file;
}

}  // namespace skyquilt::simulate
