// Ready settings for other programs, written here from the map's address: nothing needs to be typed there.
/** @import { Flight, TileJson } from '../shared/types.js' */
import { tileBox } from '../map/tile_addresses.js';

/** @param {string} text @returns {string} safe inside XML text and attributes */
export function xmlText(text) {
  return text.replace(/[\u0000-\u0008\u000b\u000c\u000e-\u001f\ufffe\uffff]/g, '').replace(
    /[&<>"']/g,
    (c) => ({ '&': '&amp;', '<': '&lt;', '>': '&gt;', '"': '&quot;', "'": '&apos;' })[c] ?? c,
  );
}

const kEdge_m = 20037508.342789244;

/**
 * GDAL's own description of an XYZ service: gdalinfo, gdal_translate and QGIS open it as a raster. The window is the
 * map's own, on the tile grid of its lowest zoom: the whole world at a drone's resolution has more pixels than GDAL
 * can count.
 * @param {string} template with {z}, {x}, {y}
 * @param {TileJson} tilejson
 */
export function gdalXml(template, tilejson) {
  const address = template.replace('{z}', '${z}').replace('{x}', '${x}').replace('{y}', '${y}');
  const side = tilejson.tileSize ?? 256;
  const [low, high] = [tilejson.minzoom ?? 0, tilejson.maxzoom ?? 22];
  const { from, to } = tileBox(tilejson.across_bounds ?? tilejson.bounds ?? [-180, -85.05, 180, 85.05], low);
  const first = { x: Math.floor(from.x), y: Math.floor(from.y) };
  const last = { x: Math.ceil(to.x), y: Math.ceil(to.y) };
  const tiles = 2 ** (high - low);
  const metres = (/** @type {number} */ tile) => ((2 * tile) / 2 ** low - 1) * kEdge_m;
  return `<GDAL_WMS>
  <Service name="TMS"><ServerUrl>${xmlText(address)}</ServerUrl></Service>
  <DataWindow>
    <UpperLeftX>${metres(first.x)}</UpperLeftX><UpperLeftY>${-metres(first.y)}</UpperLeftY>
    <LowerRightX>${metres(last.x)}</LowerRightX><LowerRightY>${-metres(last.y)}</LowerRightY>
    <SizeX>${(last.x - first.x) * tiles * side}</SizeX><SizeY>${(last.y - first.y) * tiles * side}</SizeY>
    <TileX>${first.x * tiles}</TileX><TileY>${first.y * tiles}</TileY><TileLevel>${high}</TileLevel>
    <YOrigin>top</YOrigin>
  </DataWindow>
  <Projection>EPSG:3857</Projection>
  <OverviewCount>${high - low}</OverviewCount>
  <BlockSizeX>${side}</BlockSizeX><BlockSizeY>${side}</BlockSizeY>
  <BandsCount>4</BandsCount>
  <ZeroBlockHttpCodes>204,404</ZeroBlockHttpCodes>
</GDAL_WMS>
`;
}

/**
 * For QGIS: Browser, XYZ Tiles, Load Connections.
 * @param {string} name
 * @param {string} template
 * @param {TileJson} tilejson
 */
export function qgisXml(name, template, tilejson) {
  return `<!DOCTYPE connections>
<qgsXYZTilesConnections version="1.0">
  <xyztiles name="${xmlText(name)}" url="${xmlText(template)}" zmin="${tilejson.minzoom ?? 0}" zmax="${tilejson.maxzoom ?? 22}" username="" password="" authcfg="" referer="" tilePixelRatio="${(tilejson.tileSize ?? 256) >= 512 ? 2 : 1}"/>
</qgsXYZTilesConnections>
`;
}

/**
 * What JOSM's imagery preferences take.
 * @param {string} template
 * @param {TileJson} tilejson
 */
export function josmAddress(template, tilejson) {
  return `tms[${tilejson.minzoom ?? 0},${tilejson.maxzoom ?? 22}]:${template.replace('{z}', '{zoom}')}`;
}

/**
 * @param {Flight} flight
 * @param {TileJson} tilejson
 * @param {string} template of the tiles' addresses, with whatever a program needs to read them
 * @returns {{label: string, file: string, text: string}[]}
 */
export function connectFiles(flight, tilejson, template) {
  const base = flight.name.replace(/[^\p{L}\p{N}._-]+/gu, '_').slice(0, 60) || 'map';
  return [
    { label: 'QGIS', file: `${base}.qgis.xml`, text: qgisXml(flight.name, template, tilejson) },
    { label: 'GDAL', file: `${base}.gdal.xml`, text: gdalXml(template, tilejson) },
  ];
}

/**
 * Saves a text as a file.
 * @param {string} file
 * @param {string} text
 * @param {string} [type]
 */
export function saveText(file, text, type = 'application/xml') {
  const address = URL.createObjectURL(new Blob([text], { type }));
  const link = document.createElement('a');
  link.href = address;
  link.download = file;
  link.click();
  setTimeout(() => URL.revokeObjectURL(address), 10_000);
}
