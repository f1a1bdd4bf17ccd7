#include "core/flight/photos/read_photo.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <string_view>
#include <utility>

#include "core/base/try.h"
#include "core/camera/sensor_database.h"
#include "core/flight/aside/alike.h"
#include "core/flight/aside/aside.h"
#include "core/flight/bytes/text_fields.h"
#include "core/flight/metadata/attitude_tags.h"
#include "core/flight/metadata/capture_time.h"
#include "core/flight/metadata/exif.h"
#include "core/flight/metadata/position_tags.h"
#include "core/flight/metadata/xmp.h"
#include "core/flight/photos/choose_intrinsics.h"
#include "core/flight/photos/image_header.h"
#include "core/flight/read_flight.h"

namespace skyquilt::flight {
namespace {

constexpr std::uint16_t kMakerNoteTag = 0x927C, kTimeTag = 0x9003, kDigitizedTag = 0x9004;
constexpr double kLongestReadoutS = 0.5;

std::optional<DjiMakerNote> ReadMakerNote(const ExifTable& exif) {
  const ExifValue* note = exif.Find(ExifIfd::kExif, kMakerNoteTag);
  if (note == nullptr) return std::nullopt;
  return ReadDjiMakerNote(note->bytes, note->is_big_endian);
}

// Photos of one physical camera at one size and one focal length.
std::string CameraKey(const Photo& photo, const ExifRecord& exif, const XmpTags& xmp) {
  std::string serial = xmp.Text("drone-dji:CameraSerialNumber");
  if (serial.empty()) serial = exif.serial_number;
  // One camera of a rig of several.
  std::string rig = xmp.Text("Camera:RigCameraIndex");
  if (rig.empty()) rig = xmp.Text("Camera:BandName");
  return fmt::format("{}|{}|{}|{}|{}x{}|{:.2f}mm", photo.make, photo.model, serial, rig,
                     photo.intrinsics.width_px, photo.intrinsics.height_px,
                     exif.focal_length_mm.value_or(0.0) * exif.digital_zoom);
}

// As makers write it, cameras in colour too, and Zenmuse XT and XT2 in FLIR's tags.
std::string WrittenBandName(const XmpTags& xmp) {
  for (const char* tag : {"Camera:BandName", "drone-dji:BandName", "FLIR:BandName"}) {
    if (std::string name = xmp.Text(tag); !name.empty()) return name;
  }
  return "";
}

// Of a camera that takes one band a picture; empty for colour.
std::string BandNameOf(const ImageHeader& header, const XmpTags& xmp) {
  constexpr std::uint16_t kSamplesPerPixelTag = 0x0115;
  if (!header.flir.empty()) return "LWIR";  // in colours for looking, with the sensor's levels beside
  const bool is_stored_as_levels =
      header.sample_kind == SampleKind::kBytes || header.sample_kind == SampleKind::kLevels;
  if (header.exif.Number(ExifIfd::kImage, kSamplesPerPixelTag) != 1.0 || !is_stored_as_levels) return "";
  const std::string name = WrittenBandName(xmp);
  return name.find_first_of(",;") == std::string::npos ? name : "";
}

Lens LensOf(const ImageHeader& header, const XmpTags& xmp) {
  if (!header.flir.empty()) return Lens::kThermal;
  const std::string band = LowerCase(WrittenBandName(xmp));
  const std::string source = LowerCase(xmp.Text("drone-dji:ImageSource"));
  // FLIR's Duo Pro R names the band of its thermal camera in the pictures of the visible one too.
  const bool may_be_thermal = static_cast<double>(header.width_px) * header.height_px <= kMaxThermalPx;
  if (HoldsOneOf(source, {"infrared", "thermal"}) ||
      (may_be_thermal && band.find("lwir") != std::string::npos))
    return Lens::kThermal;
  if (HoldsOneOf(source, {"zoom", "tele"})) return Lens::kZoom;
  return HoldsOneOf(source, {"wide", "visible"}) ? Lens::kWide : Lens::kUnsaid;
}

bool NamesAnEditor(const std::string& program) {
  constexpr std::array<std::string_view, 39> kEditors = {
      "photoshop",     "lightroom",    "adobe",         "gimp",
      "snapseed",      "capture one",  "darktable",     "rawtherapee",
      "affinity",      "luminar",      "photolab",      "dxo",
      "pixelmator",    "paint.net",    "paintshop",     "irfanview",
      "xnview",        "faststone",    "imagemagick",   "graphicsmagick",
      "photoscape",    "digikam",      "krita",         "polarr",
      "picsart",       "vsco",         "canva",         "acdsee",
      "picasa",        "photo viewer", "windows photo", "microsoft photo",
      "google photos", "apple photos", "aurora hdr",    "photomatix",
      "topaz",         "zoner",        "photodirector"};
  return HoldsOneOf(LowerCase(program), kEditors);
}

PictureOrigin OriginOf(const ImageHeader& header, const ExifRecord& exif, const XmpTags& xmp) {
  constexpr std::array<std::string_view, 8> kMakers = {
      "drone-", "Camera:", "sensefly:", "MicaSense:", "DLS:", "FLIR:", "Autel", "autel"};
  PictureOrigin origin;
  // A file's own date is that of its last change.
  const bool is_of_exposure = header.exif.Find(ExifIfd::kExif, kTimeTag) != nullptr ||
                              header.exif.Find(ExifIfd::kExif, kDigitizedTag) != nullptr ||
                              header.exif.Find(ExifIfd::kImage, kTimeTag) != nullptr;
  if (is_of_exposure) origin.clock = exif.taken_at;
  origin.is_edited = NamesAnEditor(exif.software) || NamesAnEditor(xmp.Text("xmp:CreatorTool"));
  const bool has_xmp = std::any_of(xmp.values().begin(), xmp.values().end(),
                                   [&](const auto& value) { return StartsWithOneOf(value.first, kMakers); });
  origin.makers_records = static_cast<int>(header.exif.Find(ExifIfd::kExif, kMakerNoteTag) != nullptr) +
                          static_cast<int>(has_xmp) + static_cast<int>(!header.flir.empty());
  return origin;
}

void NoteSoftware(Photo& photo) {
  photo.is_resaved_by_viewer =
      HoldsOneOf(photo.software, {"Photo Viewer", "Windows Photo", "Microsoft Photo", "Picasa", "ACDSee"});
  if (photo.is_resaved_by_viewer)
    photo.notes.push_back({RemarkCode::kResaved, {{"software", photo.software}}});
}

// What the three channels of a camera in colour see where its filter lets other light through, as the maker
// writes it ("RGN", "Red, Green, NIR"); empty for red, green and blue.
std::string FilteredChannels(const Photo& photo, const XmpTags& xmp) {
  std::string written = WrittenBandName(xmp);
  std::replace(written.begin(), written.end(), ';', ',');
  if (std::count(written.begin(), written.end(), ',') == 2) {
    const std::string lower = LowerCase(written);
    std::string_view rest = lower;
    for (int channel = 0; channel < 3; ++channel) {
      const std::string_view name = Trim(rest.substr(0, rest.find(',')));
      if (!IsOneOf(name, {"red", "green", "blue", "r", "g", "b"})) return written;
      rest.remove_prefix(std::min(rest.size(), rest.find(',') + 1));
    }
    return "";
  }
  // MAPIR's Survey cameras: "Survey3W_RGN".
  const std::size_t behind = photo.model.rfind('_');
  if (LowerCase(photo.make) != "mapir" || behind == std::string::npos) return "";
  const std::string channels = photo.model.substr(behind + 1);
  return LowerCase(channels) == "rgb" ? "" : channels;
}

void NoteOrientation(const ExifRecord& exif, Photo& photo) {
  if (!exif.orientation || *exif.orientation == 1) return;
  photo.notes.push_back({RemarkCode::kTurnedByExif, {{"orientation", *exif.orientation}}});
}

// A lens without an f-number has one opening.
std::optional<double> ExposureOf(const ExifRecord& exif) {
  if (!exif.exposure_time_s || !exif.iso) return std::nullopt;
  return std::log2(*exif.exposure_time_s * *exif.iso / 100.0) - 2.0 * std::log2(exif.f_number.value_or(1.0));
}

// The rows of a picture that a sensor crops to another aspect take their share of its time. A picture stored
// upright from a sensor on its side does not say which way its rows were read.
std::optional<double> ReadoutOf(const Photo& photo, const XmpTags& xmp) {
  // Cameras write the time of a row also for sensors that expose all rows at once; what a gyro says they
  // write of those that do not.
  const auto row_ns = xmp.Number("Camera:LineReadoutTime");
  if (photo.turning && row_ns && *row_ns > 0.0 && photo.intrinsics.width_px >= photo.intrinsics.height_px) {
    const double readout_s = 1e-9 * *row_ns * photo.intrinsics.height_px;
    if (readout_s <= kLongestReadoutS) return readout_s;
  }
  const auto sensor = camera::FindSensor(photo.model);
  const int width_px = photo.intrinsics.width_px, height_px = photo.intrinsics.height_px;
  const auto whole_s = camera::FindReadoutS(photo.model, 1e-6 * width_px * height_px);
  if (!sensor || !whole_s || width_px < height_px || xmp.Text("drone-dji:ShutterType") == "Mechanical")
    return std::nullopt;
  const double scale =
      camera::ScaleFromNative(width_px, height_px, sensor->native_width_px, sensor->native_height_px);
  return *whole_s * std::min(1.0, height_px / scale / sensor->native_height_px);
}

}  // namespace

Result<Photo> ReadPhotoFrom(const std::string& name, ByteSource& source) {
  SKYQUILT_TRY_ASSIGN(auto header, ReadImageHeader(source));
  Photo photo;
  photo.name = name;
  ExifRecord exif = InterpretExif(header.exif);
  const XmpTags xmp = ReadXmp(header, source, photo.notes);
  photo.notes.insert(photo.notes.end(), exif.notes.begin(), exif.notes.end());
  if (auto panorama = WhyPanorama(header.width_px, header.height_px, xmp)) return *std::move(panorama);
  FillFromXmp(xmp, exif);
  photo.make = exif.make;
  photo.model = exif.model;
  photo.software = exif.software;
  NoteSoftware(photo);
  NoteOrientation(exif, photo);
  const ChosenIntrinsics chosen = ChooseIntrinsics(header.width_px, header.height_px, exif, xmp, photo.notes);
  photo.intrinsics = chosen.intrinsics;
  photo.focal_source = chosen.source;
  photo.band_name = BandNameOf(header, xmp);
  photo.lens = LensOf(header, xmp);
  if (std::string channels = FilteredChannels(photo, xmp); photo.band_name.empty() && !channels.empty())
    photo.notes.push_back({RemarkCode::kOtherChannels, {{"channels", std::move(channels)}}});
  photo.origin = OriginOf(header, exif, xmp);
  photo.sample_kind = header.sample_kind;
  photo.camera_key = CameraKey(photo, exif, xmp);
  TakeCaptureTime(exif, xmp, photo);
  photo.position = PositionFromTags(exif, xmp, photo.notes);
  photo.exif_beside_xmp = ExifBesideXmpFromTags(exif, xmp);
  if (!photo.position) photo.lone_height_above_takeoff_m = HeightAboveTakeoffFromTags(xmp);
  photo.attitude = AttitudeFromTags(xmp, ReadMakerNote(header.exif), photo.make, photo.notes);
  photo.direction = DirectionFromTags(exif);
  photo.velocity_in_enu_mps = VelocityFromTags(xmp);
  photo.turning = TurningFromTags(xmp, photo.notes);
  photo.exposure_time_s = exif.exposure_time_s;
  photo.exposure_log2 = ExposureOf(exif);
  photo.readout_s = ReadoutOf(photo, xmp);
  return photo;
}

Result<Photo> ReadPhotoFromBytes(const std::string& name, std::span<const std::uint8_t> bytes) {
  MemoryBytes source(bytes);
  return ReadPhotoFrom(name, source);
}

Result<Photo> ReadPhoto(const InputFile& file) {
  SKYQUILT_TRY_ASSIGN(auto source, OpenFileBytes(file.path));
  auto photo = ReadPhotoFrom(file.name, *source);
  if (photo) photo->path = file.path;
  return photo;
}

}  // namespace skyquilt::flight
