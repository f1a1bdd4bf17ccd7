#include "core/flight/photos/read_photo.h"

#include <fmt/format.h>

#include <string_view>

#include "core/base/try.h"
#include "core/camera/sensor_database.h"
#include "core/flight/metadata/attitude_tags.h"
#include "core/flight/metadata/capture_time.h"
#include "core/flight/metadata/dji_maker_note.h"
#include "core/flight/metadata/exif.h"
#include "core/flight/metadata/gyro_tags.h"
#include "core/flight/metadata/position_tags.h"
#include "core/flight/metadata/xmp.h"
#include "core/flight/photos/choose_intrinsics.h"
#include "core/flight/photos/image_header.h"
#include "core/flight/read_flight.h"

namespace skyquilt::flight {
namespace {

constexpr std::uint16_t kMakerNoteTag = 0x927C;
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

// Of a camera that takes one band a picture; empty for colour.
std::string BandNameOf(const ImageHeader& header, const XmpTags& xmp) {
  constexpr std::uint16_t kSamplesPerPixelTag = 0x0115;
  if (!header.flir.empty()) return "LWIR";  // in colours for looking, with the sensor's levels beside
  const bool is_stored_as_levels =
      header.sample_kind == SampleKind::kBytes || header.sample_kind == SampleKind::kLevels;
  if (header.exif.Number(ExifIfd::kImage, kSamplesPerPixelTag) != 1.0 || !is_stored_as_levels) return "";
  std::string name = xmp.Text("Camera:BandName");
  if (name.empty()) name = xmp.Text("drone-dji:BandName");
  return name.find_first_of(",;") == std::string::npos ? name : "";
}

void NoteSoftware(Photo& photo) {
  for (const std::string_view viewer :
       {"Photo Viewer", "Windows Photo", "Microsoft Photo", "Picasa", "ACDSee"}) {
    if (photo.software.find(viewer) == std::string::npos) continue;
    photo.is_resaved_by_viewer = true;
    photo.notes.push_back("Re-saved by " + photo.software +
                          ": the picture may have been turned after its angles were recorded.");
    return;
  }
}

void NoteOrientation(const ExifRecord& exif, Photo& photo) {
  if (!exif.orientation || *exif.orientation == 1) return;
  photo.notes.push_back(fmt::format(
      "EXIF asks viewers to turn the picture (orientation {}); it is used as the sensor stored it.",
      *exif.orientation));
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
  if (exif.make.empty()) exif.make = xmp.Text("tiff:Make");
  if (exif.model.empty()) exif.model = xmp.Text("tiff:Model");
  photo.make = exif.make;
  photo.model = exif.model;
  photo.software = exif.software;
  NoteSoftware(photo);
  NoteOrientation(exif, photo);
  const ChosenIntrinsics chosen = ChooseIntrinsics(header.width_px, header.height_px, exif, xmp, photo.notes);
  photo.intrinsics = chosen.intrinsics;
  photo.focal_source = chosen.source;
  photo.band_name = BandNameOf(header, xmp);
  photo.sample_kind = header.sample_kind;
  photo.camera_key = CameraKey(photo, exif, xmp);
  const CaptureTime time = ChooseCaptureTime(exif, xmp, photo.notes);
  photo.captured_at = time.captured_at;
  photo.captured_at_is_local = time.is_local;
  photo.clock_minus_utc = time.clock_minus_utc;
  photo.position = PositionFromTags(exif, xmp, photo.notes);
  photo.attitude = AttitudeFromTags(xmp, ReadMakerNote(header.exif), photo.make, photo.notes);
  photo.velocity = VelocityFromTags(xmp);
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
