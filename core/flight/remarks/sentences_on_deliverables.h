// The sentences of remarks on why a finished map is not taken in, or not handed out in the form asked for.
// remark_sentences.cc joins them with the others. Any thread.
#pragma once

#include <array>

#include "core/flight/remarks/remark_words.h"

namespace skyquilt::flight {

inline constexpr std::array kSentencesOnDeliverables = std::to_array<RemarkSentence>({
    {RemarkCode::kImportNotThere, "import_not_there", "{file} is no file that is there. Check its path."},
    {RemarkCode::kImportNoGeotiff, "import_no_geotiff",
     "{file} cannot be read as a GeoTIFF: it is damaged, cut off or of another kind. Take a GeoTIFF or an "
     "MBTiles."},
    {RemarkCode::kImportNoPicture, "import_no_picture", "{file} holds no picture."},
    {RemarkCode::kImportNoColours, "import_no_colours", "{file} has pixels that cannot be read as colours."},
    {RemarkCode::kImportPixelType, "import_pixel_type",
     "{file} has pixels of type {type}; a map has 8 bits a colour. Make it so first: \"gdal_translate -ot Byte "
     "-scale IN.tif OUT.tif\". Elevation models go with the photos of a flight."},
    {RemarkCode::kImportNotGeoreferenced, "import_not_georeferenced",
     "{file} is not georeferenced: it does not say where on Earth it lies. If a world file (.tfw) belongs to it, "
     "put both into one: \"gdal_translate -a_srs EPSG:CODE IN.tif OUT.tif\"; if it has control points, run "
     "\"gdalwarp -t_srs EPSG:3857 IN.tif OUT.tif\" first."},
    {RemarkCode::kImportWithoutSystem, "import_without_system",
     "{file} does not say its coordinate system. Say it first: \"gdal_translate -a_srs EPSG:CODE IN.tif "
     "OUT.tif\"."},
    {RemarkCode::kImportLocalSystem, "import_local_system",
     "{file} is in a local coordinate system that has no place on Earth. Say the true one first: "
     "\"gdal_translate -a_srs EPSG:CODE IN.tif OUT.tif\"."},
    {RemarkCode::kImportElsewhere, "import_elsewhere",
     "{file} lies where its coordinate system cannot be brought to the web map's. Check that the system it names "
     "is the true one."},
    {RemarkCode::kImportNotWarped, "import_not_warped",
     "{file} cannot be brought to the web map's grid. Try \"gdalwarp -t_srs EPSG:3857 IN.tif OUT.tif\" first."},
    {RemarkCode::kImportTooLarge, "import_too_large",
     "{file} would become {tiles} tiles, more than the {most} that are taken. Make it coarser or cut it first: "
     "\"gdalwarp -tr METRES METRES IN.tif OUT.tif\"."},
    {RemarkCode::kImportTransparent, "import_transparent",
     "{file} is empty: all of its pixels are transparent or \"no data\"."},
    {RemarkCode::kImportNoMbtiles, "import_no_mbtiles",
     "{file} is no MBTiles. Take an MBTiles of pictures (PNG, JPEG or WebP), or a GeoTIFF."},
    {RemarkCode::kImportDamaged, "import_damaged", "{file} is damaged. Copy or download it again."},
    {RemarkCode::kImportWithoutTiles, "import_without_tiles",
     "{file} has no tiles. Take an MBTiles of pictures (PNG, JPEG or WebP), or a GeoTIFF."},
    {RemarkCode::kImportManyTiles, "import_many_tiles",
     "{file} has {tiles} tiles, more than the {most} that are taken. Cut it, or leave out its finest zoom."},
    {RemarkCode::kImportVectorTiles, "import_vector_tiles",
     "{file} holds vector tiles, which are no pictures. Take an MBTiles of pictures (PNG, JPEG or WebP), or a "
     "GeoTIFF."},
    {RemarkCode::kImportRowsFromNorth, "import_rows_from_north",
     "{file} counts its rows from the north (scheme \"xyz\"), which MBTiles does not have. Write it anew with rows "
     "from the south, or take a GeoTIFF."},
    {RemarkCode::kImportOtherSystem, "import_other_system",
     "{file} has tiles of {system}, not of Web Mercator. Take an MBTiles in Web Mercator, or a GeoTIFF."},
    {RemarkCode::kImportTileNoPicture, "import_tile_no_picture",
     "{file} has a tile ({tile}) that is no PNG, JPEG or WebP. Take an MBTiles of pictures, or a GeoTIFF."},
    {RemarkCode::kImportTileDamaged, "import_tile_damaged",
     "{file} has a damaged tile ({tile}). Copy or download it again."},
    {RemarkCode::kImportTilesOfSeveralSizes, "import_tiles_of_several_sizes",
     "{file} has tiles of several sizes, such as {tile} with {width_px} x {height_px} pixels. Take an MBTiles of "
     "one size of tiles, or a GeoTIFF."},
    {RemarkCode::kImportTilesOfOddSize, "import_tiles_of_odd_size",
     "{file} has tiles of {width_px} x {height_px} pixels; 256, 512 and 1024 are known. Take such an MBTiles, or a "
     "GeoTIFF."},
    {RemarkCode::kExportWithoutPlace, "export_without_place",
     "This map is not georeferenced: it has no true place, scale or north, so that a coordinate system, a boundary "
     "or a resolution would mean nothing. Place it first (\"Place on Earth\" on the page, or \"skyquilt place\"), "
     "or leave them out."},
    {RemarkCode::kExportOutsideMap, "export_outside_map",
     "The boundary lies outside the map, which covers {south_deg:.5f},{west_deg:.5f} to "
     "{north_deg:.5f},{east_deg:.5f} (latitude, longitude)."},
    {RemarkCode::kExportNothingWithin, "export_nothing_within",
     "Nothing of the map lies within the boundary. Draw the boundary over the map."},
    {RemarkCode::kExportFinerThanMap, "export_finer_than_map",
     "The map's finest pixels show {finest_m:.4g} m of ground, so that a resolution of {asked_m:.4g} m would add "
     "nothing but bytes. Leave it out, or ask for {finest_m:.4g} m or more."},
    {RemarkCode::kExportBeyondMap, "export_beyond_map",
     "A pixel of {asked_m:.4g} m is larger than the map. Ask for a finer resolution."},
    {RemarkCode::kExportBeyondUtm, "export_beyond_utm",
     "UTM ends at 80 degrees south and 84 north. Give an EPSG code of the region."},
    {RemarkCode::kExportSystemUnknown, "export_system_unknown",
     "EPSG:{epsg} is not known here. Give the code of a coordinate system of this region, or \"utm\"."},
    {RemarkCode::kExportSystemNoPlane, "export_system_no_plane",
     "EPSG:{epsg} is not a map projection or plain longitude and latitude. Give the code of a coordinate system of "
     "this region, or \"utm\"."},
    {RemarkCode::kExportSystemElsewhere, "export_system_elsewhere",
     "EPSG:{epsg} is for {area_words}; the map lies at {lat_deg:.4f},{lon_deg:.4f}. Give the code of a coordinate "
     "system of this region, or \"utm\"."},
    {RemarkCode::kExportSystemUnreachable, "export_system_unreachable",
     "EPSG:{epsg} does not reach the map. Give the code of a coordinate system of this region, or \"utm\"."},
    {RemarkCode::kExportWithoutPrinter, "export_without_printer",
     "This server has no program that makes a PDF. Whoever runs it installs one (apt install weasyprint); until then "
     "print the map's page from the browser."},
    {RemarkCode::kReportNotPrinted, "report_not_printed",
     "The report could not be made a PDF: the program that prints failed. Ask again; whoever runs the server finds why "
     "in its log."},
    {RemarkCode::kIndexWithoutValue, "index_without_value",
     "This index has no value anywhere on the map. Choose another."},
    {RemarkCode::kIndexWithoutBand, "index_without_band", "This map has no band \"{band}\". It has {bands}."},
    {RemarkCode::kExportOneOfLink, "export_one_of_link",
     "A link has one export at a time, and this one's is not made yet. Wait for it, or delete it."},
    {RemarkCode::kExportsOfFlight, "exports_of_flight",
     "This flight has {most} exports already. Delete one, or wait: each goes a day after it was made."},
    {RemarkCode::kExportsOfServer, "exports_of_server",
     "Too many exports wait on this server. Try again later."},
    {RemarkCode::kExportGone, "export_gone",
     "This flight has no such export: it was deleted, or its day is over. Ask for it again."},
});

}  // namespace skyquilt::flight
