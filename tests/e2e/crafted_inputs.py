"""Files that were made to cost whoever reads them: time, memory, depth. Each is small to send and none is stored: they
are made here. `python3 crafted_inputs.py FOLDER` writes them; crafted_inputs_test.py sends them to a server."""
import gzip
import io
import pathlib
import struct
import sys
import tarfile
import zipfile
import zlib

MIB = 1 << 20


# --- pictures -----------------------------------------------------------------------------------------------------------

def segment(marker, body):
    return struct.pack(">BBH", 0xFF, marker, len(body) + 2) + body


def jpeg(*segments, width=4000, height=3000):
    frame = segment(0xC0, struct.pack(">BHHB", 8, height, width, 3) + bytes([1, 0x11, 0, 2, 0x11, 0, 3, 0x11, 0]))
    return b"\xff\xd8" + b"".join(segments) + frame + segment(0xDA, bytes(10)) + b"\0" * 64 + b"\xff\xd9"


def xmp_packet(attributes="", elements=""):
    return ('<x:xmpmeta xmlns:x="adobe:ns:meta/"><rdf:RDF xmlns:rdf="http://www.w3.org/1999/02/22-rdf-syntax-ns#">'
            f'<rdf:Description xmlns:drone-dji="http://www.dji.com/drone-dji/1.0/" {attributes}>{elements}'
            '</rdf:Description></rdf:RDF></x:xmpmeta>').encode()


def jpeg_with_xmp(packet):
    """In one segment where it fits, else as an extended packet in many."""
    if len(packet) < 65000:
        return jpeg(segment(0xE1, b"http://ns.adobe.com/xap/1.0/\0" + packet))
    head = b"http://ns.adobe.com/xmp/extension/\0" + b"A" * 32
    parts = [segment(0xE1, head + struct.pack(">II", len(packet), at) + packet[at:at + 65000])
             for at in range(0, len(packet), 65000)]
    return jpeg(*parts)


def tiff_block(entries, next_directory=0):
    """A directory at 8; each entry is (tag, type, count, four bytes)."""
    body = struct.pack("<H", len(entries))
    for tag, kind, count, value in entries:
        body += struct.pack("<HHI", tag, kind, count) + value
    return b"II*\0" + struct.pack("<I", 8) + body + struct.pack("<I", next_directory)


def jpeg_with_exif(block):
    return jpeg(segment(0xE1, b"Exif\0\0" + block))


def exif_sharing_values():
    """5000 entries, each of which says that its value is the same 4 KiB and 60 KiB."""
    entries = [(i, 7, 5000, struct.pack("<I", 60000)) for i in range(5000)]
    return (tiff_block(entries) + bytes(65500))[:65500]


def exif_loops():
    long = lambda value: struct.pack("<I", value)
    return tiff_block([(0x8769, 4, 1, long(8)), (0x8825, 4, 1, long(8)), (0xA005, 4, 1, long(8))], 8)


def exif_huge_counts():
    return tiff_block([(0x010F, 2, 0xFFFFFFFF, struct.pack("<I", 8)), (0x9286, 7, 0x7FFFFFFF, struct.pack("<I", 0)),
                       (0x8769, 4, 0xFFFFFFFF, struct.pack("<I", 0xFFFFFFFF))]) + bytes(1000)


def png(width, height, *chunks, more_mib=0):
    """Black; with `more_mib` its compressed rows go on behind the last."""
    def chunk(kind, body):
        return struct.pack(">I", len(body)) + kind + body + struct.pack(">I", zlib.crc32(kind + body))
    row = zlib.compressobj(9)
    pixels = b"".join(row.compress(bytes(MIB)) for _ in range(width * height * 3 // MIB + 1 + more_mib)) + row.flush()
    return (b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0))
            + b"".join(chunk(kind, body) for kind, body in chunks) + chunk(b"IDAT", pixels) + chunk(b"IEND", b""))


def tiff_chain(length, closes):
    """Directories of one entry, each naming the next; the last one names the first where the chain closes."""
    chain = [b"II*\0" + struct.pack("<I", 8)]
    for i in range(length):
        following = 8 + 18 * (i + 1) if i + 1 < length else (8 if closes else 0)
        chain.append(struct.pack("<H", 1) + struct.pack("<HHII", 256, 3, 1, 4000) + struct.pack("<I", following))
    return b"".join(chain)


def geotiff(width, height, *, rows_per_strip=None, strips=None, directories=1, sample_format=3, wkt_bytes=0):
    """An elevation model; its strips are all the same compressed zeros, and stand for rows_per_strip rows each."""
    rows_per_strip = rows_per_strip or height
    count = (height + rows_per_strip - 1) // rows_per_strip
    packer = zlib.compressobj(9)
    left = width * rows_per_strip * 4
    data = b""
    while left > 0:
        data += packer.compress(bytes(min(left, 16 * MIB)))
        left -= 16 * MIB
    data += packer.flush()
    keys = struct.pack("<16H", 1, 1, 0, 3, 1024, 0, 1, 2, 1025, 0, 1, 1, 2048, 0, 1, 4326)
    scale, tie = struct.pack("<3d", 1e-5, 1e-5, 0), struct.pack("<6d", 0, 0, 0, 8.5, 47.5, 0)
    blob, offsets = b"", {}
    base = 8 + (2 + 12 * 14 + 4) * directories

    def put(name, content):
        nonlocal blob
        offsets[name] = base + len(blob)
        blob += content + b"\0" * (len(content) % 2)
    put("data", data)
    put("offsets", struct.pack(f"<{count}I", *[offsets["data"]] * count))
    put("counts", struct.pack(f"<{count}I", *[len(data)] * count))
    for name, content in (("keys", keys), ("scale", scale), ("tie", tie)):
        put(name, content)
    put("text", b"x" * max(wkt_bytes, 8))
    value = lambda number: struct.pack("<I", number)
    entries = [(256, 4, 1, value(width)), (257, 4, 1, value(height)), (258, 3, 1, value(32)), (259, 3, 1, value(8)),
               (262, 3, 1, value(1)), (273, 4, count, value(offsets["offsets"] if count > 1 else offsets["data"])),
               (277, 3, 1, value(1)), (278, 4, 1, value(rows_per_strip)),
               (279, 4, count, value(offsets["counts"] if count > 1 else len(data))), (339, 3, 1, value(sample_format)),
               (33550, 12, 3, value(offsets["scale"])), (33922, 12, 6, value(offsets["tie"])),
               (34735, 3, 16, value(offsets["keys"])), (34737, 2, max(wkt_bytes, 8), value(offsets["text"]))]
    head = b"II*\0" + value(8)
    for i in range(directories):
        body = struct.pack("<H", len(entries)) + b"".join(struct.pack("<HHI", *entry[:3]) + entry[3] for entry in entries)
        following = 8 + (len(body) + 4) * (i + 1) if i + 1 < directories else 0
        head += body + value(following)
    return head + blob


# --- logs ---------------------------------------------------------------------------------------------------------------

def ulog(*messages):
    head = bytes([0x55, 0x4C, 0x6F, 0x67, 0x01, 0x12, 0x35, 1]) + bytes(8)
    return head + b"".join(struct.pack("<HB", len(body), ord(kind)) + body for kind, body in messages)


def ulog_nested(subscriptions):
    """Types of 20 members of the type before, eight deep, and messages of the last one."""
    definitions = [("F", b"t0:uint8_t[0] a;")]
    for level in range(1, 8):
        members = b"".join(b"t%d m%d;" % (level - 1, i) for i in range(20))
        definitions.append(("F", b"t%d:%suint64_t timestamp;" % (level, members)))
    definitions.append(("F", b"vehicle_imu:t7 a;t7 b;uint64_t timestamp;float[3] delta_angle;"))
    subscribed = [("A", b"\0" + struct.pack("<H", i % 60000) + b"vehicle_imu") for i in range(subscriptions)]
    return ulog(*definitions, *subscribed, ("D", struct.pack("<H", 0) + bytes(40)))


def ulog_flags(count):
    flags = bytes(8) + bytes([1]) + bytes(7) + struct.pack("<3Q", 100, 200, 300)
    return ulog(*[("B", flags)] * count, ("F", b"a:uint64_t timestamp;"), ("A", b"\0\0\0a"), ("D", bytes(10)))


def dataflash(*messages):
    return b"".join(messages)


def fmt(kind, length, name, codes, labels):
    return struct.pack("<BBBBB4s16s64s", 0xA3, 0x95, 128, kind, length, name, codes, labels)


def dataflash_layout_storm(count):
    """Layouts without end, each message followed by another meaning for its type."""
    storm = fmt(10, 14, b"GPS", b"QB", b"TimeUS,I") + bytes([0xA3, 0x95, 10]) + bytes(9)
    return fmt(128, 89, b"FMT", b"BBnNZ", b"Type,Length,Name,Format,Columns") + storm * count


def dataflash_dense(count):
    """Positions of ten bytes, which take ten times as much once they are read."""
    head = fmt(128, 89, b"FMT", b"BBnNZ", b"Type,Length,Name,Format,Columns") + fmt(10, 10, b"GPS", b"Ibbb", b"T,Status,Lat,Lng")
    return head + b"".join(struct.pack("<BBBIbbb", 0xA3, 0x95, 10, 1 + i, 3, 1 + i % 80, 1 + i // 80 % 80) for i in range(count))


def tlog_kinds(count):
    def packet(number):
        body = struct.pack("<BBBBBBB", 0xFD, 1, 0, 0, 0, 1, 1) + struct.pack("<I", 100000 + number)[:3] + bytes(1 + 2)
        return struct.pack(">Q", 1_700_000_000_000_000 + number) + body
    return b"".join(packet(number) for number in range(count))


def tlog_garbage(size):
    return tlog_kinds(20) + (struct.pack(">Q", 1_700_000_000_000_000) + b"\xfd\xff") * (size // 10)


def gpx(points):
    return b'<?xml version="1.0"?><gpx><trk><trkseg>' + points + b"</trkseg></trk></gpx>"


def gpx_dense(count):
    return gpx(b"".join(b'<trkpt lat="47.%06d" lon="8.5"><time>2024-05-01T%02d:%02d:%02dZ</time></trkpt>'
                        % (i % 1000000, i // 3600 % 24, i // 60 % 60, i % 60) for i in range(count)))


def gpx_attributes():
    """Tags of 64 KiB of attributes that are called lat but are none, and blanks behind them."""
    return gpx((b"<trkpt " + b"lat " * 8000 + b" " * 32000 + b"></trkpt>") * 24)


def csv_rows(count):
    return b"t,wx,wy,wz,ax,ay,az,lat,lon,alt_msl\n" + b"".join(
        b"%.3f,0,0,0,0,0,-9.8,47.%06d,8.5,500\n" % (i * 0.01, i % 1000000) for i in range(count))


# --- archives -----------------------------------------------------------------------------------------------------------

def zip_of(*entries, method=zipfile.ZIP_DEFLATED):
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w", method) as archive:
        for name, content in entries:
            archive.writestr(name, content)
    return buffer.getvalue()


def zip_many(count):
    """As many entries as wanted in the directory, all of them the one empty file at the start."""
    local = struct.pack("<IHHHHHIIIHH", 0x04034B50, 20, 0, 0, 0, 0, 0, 0, 0, 1, 0) + b"a"
    entry = lambda name: struct.pack("<IHHHHHHIIIHHHHHII", 0x02014B50, 20, 20, 0, 0, 0, 0, 0, 0, 0, len(name), 0, 0, 0,
                                     0, 0, 0) + name
    directory = b"".join(entry(b"%07d" % i) for i in range(count))
    at = len(local)
    end64 = struct.pack("<IQHHIIQQQQ", 0x06064B50, 44, 45, 45, 0, 0, count, count, len(directory), at)
    locator = struct.pack("<IIQI", 0x07064B50, 0, at + len(directory), 1)
    end = struct.pack("<IHHHHIIH", 0x06054B50, 0, 0, 0xFFFF, 0xFFFF, 0xFFFFFFFF, 0xFFFFFFFF, 0)
    return local + directory + end64 + locator + end


def zip_overlapping(count, size):
    """Many names for the same compressed zeros."""
    packed = zlib.compress(bytes(size), 9)[2:-4]
    crc = zlib.crc32(bytes(size))
    local = struct.pack("<IHHHHHIIIHH", 0x04034B50, 20, 0, 8, 0, 0, crc, len(packed), size, 1, 0) + b"a"
    entry = lambda name: struct.pack("<IHHHHHHIIIHHHHHII", 0x02014B50, 20, 20, 0, 8, 0, 0, crc, len(packed), size,
                                     len(name), 0, 0, 0, 0, 0, 0) + name
    directory = b"".join(entry(b"%05d.jpg" % i) for i in range(count))
    at = len(local) + len(packed)
    return local + packed + directory + struct.pack("<IHHHHIIH", 0x06054B50, 0, 0, count, count, len(directory), at, 0)


def tar_gz(name, size):
    """One entry of zeros. Written by hand: the tar would not fit."""
    entry = tarfile.TarInfo(name)
    entry.size = size
    buffer = io.BytesIO()
    with gzip.GzipFile(fileobj=buffer, mode="wb", compresslevel=9) as out:
        out.write(entry.tobuf(tarfile.GNU_FORMAT))
        for _ in range(size // MIB):
            out.write(bytes(MIB))
        out.write(bytes(10240))
    return buffer.getvalue()


# --- the list -----------------------------------------------------------------------------------------------------------

def attributes(count):
    return " ".join(f'a{i}="1"' for i in range(count))


def entities(levels):
    lines = ['<!DOCTYPE x [<!ENTITY e0 "lol">']
    for level in range(1, levels):
        lines.append(f'<!ENTITY e{level} "' + f"&e{level - 1};" * 10 + '">')
    return ("".join(lines) + "]>").encode()


def photo_inputs():
    yield "xmp_attributes_1_mib", "a.jpg", jpeg_with_xmp(xmp_packet(attributes(80_000))[:MIB])
    yield "xmp_attributes_60_kb", "a.jpg", jpeg_with_xmp(xmp_packet(attributes(5_000)))
    yield "xmp_attributes_behind_a_comment", "a.jpg", jpeg_with_xmp(
        xmp_packet("", "<!-- ' --><e " + attributes(70_000) + "/>"))
    yield "xmp_16_mib", "a.jpg", jpeg_with_xmp(xmp_packet(attributes(1_200_000))[:16 * MIB])
    yield "xmp_deep", "a.jpg", jpeg_with_xmp(xmp_packet("", "<a>" * 100_000 + "</a>" * 100_000))
    yield "xmp_elements", "a.jpg", jpeg_with_xmp(xmp_packet("", "<a/>" * 200_000))
    yield "xmp_long_names", "a.jpg", jpeg_with_xmp(
        xmp_packet("", f"<{'n' * 300_000}>{'<b/>' * 80_000}</{'n' * 300_000}>"))
    yield "xmp_entities", "a.jpg", jpeg_with_xmp(entities(40) + xmp_packet("", "<a>&e39;</a>"))
    yield "exif_shared_values", "a.jpg", jpeg_with_exif(exif_sharing_values())
    yield "exif_loops", "a.jpg", jpeg_with_exif(exif_loops())
    yield "exif_huge_counts", "a.jpg", jpeg_with_exif(exif_huge_counts())
    yield "jpeg_largest_size", "a.jpg", jpeg(width=65535, height=65535)
    yield "jpeg_segments", "a.jpg", jpeg(*[segment(0xE1, b"x")] * 400_000)
    yield "jpeg_large_segments", "a.jpg", jpeg(*[segment(0xE1, bytes(65533))] * 600)
    yield "jpeg_stray_bytes", "a.jpg", b"\xff\xd8" + (bytes(60_000) + segment(0xE5, b"")) * 500
    yield "jpeg_padding", "a.jpg", b"\xff\xd8" + b"\xff" * (30 * MIB)
    yield "png_400_mpx", "a.png", png(20_000, 20_000)
    yield "png_goes_on", "a.png", png(400, 300, more_mib=1024)
    yield "png_exif_chunks", "a.png", png(4000, 3000, *[(b"eXIf", exif_sharing_values())] * 300)
    yield "png_text_chunks", "a.png", png(
        4000, 3000, *[(b"iTXt", b"XML:com.adobe.xmp\0\0\0\0\0" + xmp_packet(attributes(60_000)))] * 40)
    yield "tiff_directory_chain", "a.tif", tiff_chain(65_000, False)
    yield "tiff_directory_loop", "a.tif", tiff_chain(3, True)


def log_inputs():
    yield "ulog_nested_types", "a.ulg", ulog_nested(900)
    yield "ulog_million_subscriptions", "a.ulg", ulog_nested(1_000_000)
    yield "ulog_flag_messages", "a.ulg", ulog_flags(100_000)
    yield "ulog_definitions", "a.ulg", ulog(
        *[("F", b"t%d:" % i + b"".join(b"t%d m%d;" % (i + 1, j) for j in range(900))) for i in range(1500)],
        *[("A", b"\0\0\0t0")] * 1000, ("D", bytes(10)))
    yield "dataflash_layouts", "a.bin", dataflash_layout_storm(60_000)
    yield "dataflash_dense_positions", "a.bin", dataflash_dense(3_000_000)
    yield "tlog_kinds", "a.tlog", tlog_kinds(300_000)
    yield "tlog_garbage", "a.tlog", tlog_garbage(8 * MIB)
    yield "gpx_dense", "a.gpx", gpx_dense(21_000)
    yield "gpx_attributes", "a.gpx", gpx_attributes()
    yield "gpx_deep", "a.gpx", gpx(b"<trkpt>" * 100_000 + b"<a>" * 200_000)
    yield "kml_deep", "a.kml", b"<kml>" + b"<Folder>" * 190_000
    yield "csv_one_line", "a.csv", b"t,lat,lon," + b"1," * (50 * MIB)
    yield "csv_columns", "a.csv", (b"t,lat,lon," + b",".join(b"c%d" % i for i in range(100_000)) + b"\n") * 8
    yield "csv_rows", "a.csv", csv_rows(100_000)
    yield "csv_quotes", "a.csv", b"t,lat,lon\n" + b'"' * (20 * MIB)
    yield "kml_deep", "a.kml", b"<kml>" + b"<gx:Track><when>" * 100_000 + b"<" * 200_000
    yield "geojson_deep", "a.geojson", b'{"type":"Feature","x":' + b"[" * 1_000_000
    yield "geojson_line", "a.geojson", b'{"type":"Feature","geometry":{"coordinates":[' + b"[8,47,1,1466717469]," * 100_000 + b"[8,47]]}}"
    yield "ass_calls", "a.ass", b"[Events]\n" + b"Dialogue: 0,0:00:01.00,0:00:02.00,,,,,,,gps(gps(gps(gps(\n" * 30_000
    yield "srt_endless", "a.srt", b"1\n00:00:01,000 --> 00:00:02,000\ngps(8.5,47.4,19) H 5.0m\n\n" * 60_000
    yield "srt_one_cue", "a.srt", b"1\n00:00:01,000 --> 00:00:02,000\n" + b"gps(8.5,47.4,19) h:::: " * 200_000
    yield "mrk_cells", "a.mrk", (b"1\t100000.5\t[2300]\t" + b"1,N\t1,E\t1,V\t47.4,Lat\t8.5,Lon\t400,Ellh\t1,1,1\t"
                                 + b"1,2,3\t" * 100_000 + b"\n") * 8
    yield "gcp_list", "gcp_list.txt", b"EPSG:32632\n" + b"".join(
        b"%d %d 400 5 5 a.jpg\n" % (400_000 + i % 1000, 5_200_000 + i // 1000) for i in range(400_000))
    yield "geo_txt", "geo.txt", b"EPSG:32632\n" + b"a.jpg 99999999999 99999999999\n" * 300_000
    yield "nmea", "a.nmea", b"$GPGGA,100000.00,4724.0,N,00830.0,E,1,08,1.0,400.0,M,47.0,M,,\n" * 60_000


def elevation_inputs():
    yield "dem_block_of_2_gib", "a.tif", geotiff(23_000, 23_000)
    yield "dem_huge_raster", "a.tif", geotiff(1_000_000, 900_000, rows_per_strip=1)
    yield "dem_directories", "a.tif", geotiff(100, 100, directories=20_000)
    yield "dem_long_text", "a.tif", geotiff(100, 100, wkt_bytes=MIB)
    vrt = ('<VRTDataset rasterXSize="9" rasterYSize="9"><VRTRasterBand band="1" dataType="Float32"><SimpleSource>'
           '<SourceFilename relativeToVRT="0">{}</SourceFilename></SimpleSource></VRTRasterBand></VRTDataset>')
    yield "dem_vrt_of_a_file", "a.tif", vrt.format("/etc/passwd").encode()
    yield "dem_vrt_of_an_address", "a.vrt", vrt.format("/vsicurl/http://127.0.0.1:9/a.tif").encode()


def thin_photo(number, width, height, above_m):
    """Its footprint is a line across the map, whose box is all but empty."""
    tags = {"GpsLatitude": f"{47.4 + number * 1e-5:.7f}", "GpsLongitude": "8.5", "RelativeAltitude": f"+{above_m}",
            "AbsoluteAltitude": f"+{400 + above_m}", "GimbalPitchDegree": "-90.0", "GimbalYawDegree": "45.0",
            "GimbalRollDegree": "0.0"}
    packet = xmp_packet(" ".join(f'drone-dji:{name}="{value}"' for name, value in tags.items()))
    focal = tiff_block([(0x8769, 4, 1, struct.pack("<I", 26))]) + struct.pack("<HHHIII", 1, 0xA405, 3, 1, 10, 0)
    return jpeg(segment(0xE1, b"Exif\0\0" + focal), segment(0xE1, b"http://ns.adobe.com/xap/1.0/\0" + packet),
                width=width, height=height)


def archive_inputs():
    yield "zip_of_thin_photos", "a.zip", zip_of(*((f"{i:04}.jpg", thin_photo(i, *((30_000, 16, 500) if i % 2 else (16, 16, 5))))
                                                  for i in range(300)))
    yield "zip_bomb", "a.zip", zip_of(("a.jpg", bytes(256 * MIB)))
    yield "zip_nested", "a.zip", zip_of(("b.zip", zip_of(("c.zip", zip_of(("a.jpg", bytes(64 * MIB)))))))
    yield "zip_overlapping", "a.zip", zip_overlapping(15_000, MIB)
    yield "zip_million_entries", "a.zip", zip_many(1_000_000)
    yield "tar_gz_bomb", "a.tar.gz", tar_gz("a.jpg", 1024 * MIB)
    yield "tar_gz_bomb_in_clutter", "a.tar.gz", tar_gz("__MACOSX/a.jpg", 3 * 1024 * MIB)


def json_inputs():
    """Bodies for POST /api/v1/flights."""
    yield "json_deep", b"[" * 60_000
    yield "json_deep_objects", b'{"a":' * 12_000 + b"1" + b"}" * 12_000
    yield "json_large", b'{"name":"' + b"x" * (8 * MIB) + b'"}'
    yield "json_many_fields", b"{" + b",".join(b'"f%d":1' % i for i in range(5_000)) + b"}"
    yield "json_numbers", b'{"options":{"gsd_m":1e' + b"9" * 50_000 + b"}}"


def uploads():
    for group in (photo_inputs, log_inputs, elevation_inputs, archive_inputs):
        yield from group()


def main():
    folder = pathlib.Path(sys.argv[1])
    for kind, name, content in uploads():
        (folder / kind).mkdir(parents=True, exist_ok=True)
        (folder / kind / name).write_bytes(content)
        print(f"{kind:34} {len(content):>12,} bytes")
    for kind, content in json_inputs():
        (folder / f"{kind}.json").write_bytes(content)
        print(f"{kind:34} {len(content):>12,} bytes")


if __name__ == "__main__":
    main()
