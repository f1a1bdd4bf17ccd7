// Measurements, and points with words, as files that other programs open. WGS84, longitude first, as GeoJSON and KML have it.
/** @import { LonLat } from './geodesy.js' */
import { h } from '../shared/dom.js';
import { button } from '../shared/icons.js';
import { strings } from '../shared/flight_strings.js';
import { saveText, xmlText } from '../sharing/connect_files.js';
import { onEarth } from './coordinates.js';
import { pathLength, polygonArea } from './geodesy.js';

/**
 * @typedef {object} Measurement
 * @property {string} name
 * @property {string} [text] words beside it
 * @property {LonLat[]} places one of a point, at least two of a path; of an area at least three, its outline not closed
 * @property {number} length_m of the path, or around the area
 * @property {number|null} area_m2 null for a path
 */

const kDigits = 9;
/** To a tenth of a millimetre. */
export const rounded = (/** @type {LonLat} */ place) => onEarth(place).map((degrees) => Number(degrees.toFixed(kDigits)));

/** @param {string} name @param {LonLat[]} places @param {boolean} is_area @returns {Measurement} */
export const measurementOf = (name, places, is_area) => ({ name, places, length_m: pathLength(is_area ? [...places, places[0]] : places), area_m2: is_area ? polygonArea(places) : null });

/** An outline as RFC 7946 wants it: closed, anticlockwise. @param {LonLat[]} places */
function ring(places) {
  const twice = places.reduce((sum, [x, y], i) => {
    const [next_x, next_y] = places[(i + 1) % places.length];
    return sum + (next_x - x) * (next_y + y);
  }, 0);
  const turned = twice > 0 ? [...places].reverse() : places;
  return [...turned, turned[0]];
}

/** @param {LonLat[]} places @returns {GeoJSON.Polygon} */
export const polygonOf = (places) => ({ type: 'Polygon', coordinates: [ring(places).map(rounded)] });

// RFC 7946 wants what crosses the antimeridian cut there (section 3.1.9): other programs draw it round the Earth.

/** @param {LonLat} a @param {LonLat} b @param {number} lon_deg between them @returns {LonLat} on the straight line, as maps draw it */
const between = ([from, a_lat], [to, b_lat], lon_deg) => [lon_deg, a_lat + ((b_lat - a_lat) * (lon_deg - from)) / (to - from)];

/** @param {LonLat[]} places @returns {number[]} the meridians within at which the numbers begin anew, westernmost first */
function meridiansIn(places) {
  const [west, east] = [Math.min(...places.map(([lon]) => lon)), Math.max(...places.map(([lon]) => lon))];
  const meridians = [];
  for (let lon = 360 * Math.floor((west + 180) / 360) + 180; lon < east; lon += 360) if (lon > west) meridians.push(lon);
  return meridians;
}

/** @param {LonLat[]} part on one side @returns {LonLat[]} its longitudes from -180 to 180 */
function onItsSide(part) {
  const [west, east] = [Math.min(...part.map(([lon]) => lon)), Math.max(...part.map(([lon]) => lon))];
  const turn_deg = 360 * Math.round((west + east) / 720);
  return part.map(([lon, lat]) => [lon - turn_deg, lat]);
}

/** @param {LonLat[]} places whose numbers go on across the antimeridian @returns {LonLat[][]} one line or more */
function cutLine(places) {
  const meridians = meridiansIn(places);
  /** @type {LonLat[][]} */
  const parts = [[places[0]]];
  places.slice(1).forEach((to, i) => {
    const from = places[i];
    const crossed = meridians.filter((lon) => (from[0] - lon) * (to[0] - lon) < 0);
    for (const lon of from[0] < to[0] ? crossed : crossed.reverse()) {
      const edge = between(from, to, lon);
      parts[parts.length - 1].push(edge);
      parts.push([edge]);
    }
    parts[parts.length - 1].push(to);
    // One that turns or ends on the meridian itself goes on where it comes from, until it leaves that.
    const next = places[i + 2];
    if (next && meridians.some((lon) => to[0] === lon && (from[0] - lon) * (next[0] - lon) < 0)) parts.push([to]);
  });
  return parts.map(onItsSide);
}

/** @param {LonLat[]} ring not closed @param {number} lon_deg @param {1|-1} side 1: what lies east of it @returns {LonLat[]} */
function sideOf(ring, lon_deg, side) {
  return ring.flatMap((to, i) => {
    const from = ring[(i + ring.length - 1) % ring.length];
    const edge = (from[0] - lon_deg) * (to[0] - lon_deg) < 0 ? [between(from, to, lon_deg)] : [];
    return side * (to[0] - lon_deg) >= 0 ? [...edge, to] : edge;
  });
}

/** @param {LonLat[]} ring not closed; its numbers go on across the antimeridian @returns {LonLat[][]} one or more, not closed */
function cutRing(ring) {
  /** @type {LonLat[][]} */
  const parts = [];
  let rest = ring;
  for (const lon of meridiansIn(ring)) {
    parts.push(sideOf(rest, lon, -1));
    rest = sideOf(rest, lon, 1);
  }
  return [...parts, rest].map(onItsSide);
}

/** @param {LonLat[]} places @returns {GeoJSON.LineString|GeoJSON.MultiLineString} */
function lineInFile(places) {
  const lines = cutLine(places).map((line) => line.map(rounded));
  return lines.length === 1 ? { type: 'LineString', coordinates: lines[0] } : { type: 'MultiLineString', coordinates: lines };
}

/** @param {LonLat[]} places @returns {GeoJSON.Polygon|GeoJSON.MultiPolygon} */
function areaInFile(places) {
  const areas = cutRing(places).map((part) => [ring(part).map(rounded)]);
  return areas.length === 1 ? { type: 'Polygon', coordinates: areas[0] } : { type: 'MultiPolygon', coordinates: areas };
}

const millimetres = (/** @type {number} */ value) => Number(value.toFixed(3));
const isPoint = (/** @type {Measurement} */ { places, area_m2 }) => area_m2 === null && places.length === 1;

/** @param {Measurement} measurement @returns {GeoJSON.Feature} */
function feature(measurement) {
  const { name, text, places, length_m, area_m2 } = measurement;
  const words = text ? { name, text } : { name };
  if (isPoint(measurement)) return { type: 'Feature', properties: words, geometry: { type: 'Point', coordinates: rounded(places[0]) } };
  return area_m2 === null
    ? { type: 'Feature', properties: { ...words, length_m: millimetres(length_m) }, geometry: lineInFile(places) }
    : { type: 'Feature', properties: { ...words, area_m2: millimetres(area_m2), perimeter_m: millimetres(length_m) }, geometry: areaInFile(places) };
}

/** @param {Measurement[]} measurements @returns {string} GeoJSON */
export const measurementsGeoJson = (measurements) => `${JSON.stringify({ type: 'FeatureCollection', features: measurements.map(feature) }, null, 2)}\n`;

/** @param {Measurement} measurement */
function placemark(measurement) {
  const { name, text, places, length_m, area_m2 } = measurement;
  const line = (/** @type {LonLat[]} */ of) => `<coordinates>${of.map((place) => rounded(place).join(',')).join(' ')}</coordinates>`;
  const geometry = isPoint(measurement)
    ? `<Point>${line(places)}</Point>`
    : area_m2 === null
      ? `<LineString><tessellate>1</tessellate>${line(places)}</LineString>`
      : `<Polygon><outerBoundaryIs><LinearRing>${line(ring(places))}</LinearRing></outerBoundaryIs></Polygon>`;
  const data = (/** @type {string} */ key, /** @type {number} */ value) => `<Data name="${key}"><value>${value.toFixed(3)}</value></Data>`;
  const values = isPoint(measurement) ? '' : area_m2 === null ? data('length_m', length_m) : data('area_m2', area_m2) + data('perimeter_m', length_m);
  return `<Placemark>
  <name>${xmlText(name)}</name>${text ? `\n  <description>${xmlText(text)}</description>` : ''}${values ? `\n  <ExtendedData>${values}</ExtendedData>` : ''}
  ${geometry}
</Placemark>`;
}

/** @param {Measurement[]} measurements @returns {string} KML 2.2 */
export const measurementsKml = (measurements) => `<?xml version="1.0" encoding="UTF-8"?>
<kml xmlns="http://www.opengis.net/kml/2.2"><Document>${measurements.map(placemark).join('\n')}</Document></kml>
`;

/** @param {Measurement} measurement */
function gpxPart(measurement) {
  const { name, text, places, area_m2 } = measurement;
  const words = `<name>${xmlText(name)}</name>${text ? `\n  <desc>${xmlText(text)}</desc>` : ''}`;
  const points = (area_m2 === null ? places : ring(places)).map(rounded);
  if (isPoint(measurement)) return `<wpt lat="${points[0][1]}" lon="${points[0][0]}">\n  ${words}\n</wpt>`;
  return `<trk>
  ${words}
  <trkseg>${points.map(([lon, lat]) => `<trkpt lat="${lat}" lon="${lon}"/>`).join('')}</trkseg>
</trk>`;
}

/** Waypoints and tracks for receivers in the field, an area's track closed. @param {Measurement[]} measurements @returns {string} GPX 1.1 */
export function measurementsGpx(measurements) {
  // The format wants its waypoints before its tracks.
  const parts = [...measurements.filter(isPoint), ...measurements.filter((measurement) => !isPoint(measurement))].map(gpxPart);
  return `<?xml version="1.0" encoding="UTF-8"?>
<gpx version="1.1" creator="Skyquilt" xmlns="http://www.topografix.com/GPX/1/1">${parts.join('\n')}</gpx>
`;
}

/** @typedef {'geojson'|'kml'|'gpx'} FileForm */
/** @type {Record<FileForm, {label: string, type: string, write: (measurements: Measurement[]) => string}>} */
const kForms = {
  geojson: { label: 'GeoJSON', type: 'application/geo+json', write: measurementsGeoJson },
  kml: { label: 'KML', type: 'application/vnd.google-earth.kml+xml', write: measurementsKml },
  gpx: { label: 'GPX', type: 'application/gpx+xml', write: measurementsGpx },
};

/**
 * @param {string} id the buttons' begin with it
 * @param {() => {file: string, measurements: Measurement[]}|null} what is saved, in a file of this name; null: nothing now
 * @returns {HTMLElement} a button for each kind of file
 */
export function savingRow(id, what) {
  const save = (/** @type {FileForm} */ form) => {
    const found = what();
    if (found) saveText(`${found.file}.${form}`, kForms[form].write(found.measurements), kForms[form].type);
  };
  return h(
    'div',
    { class: `row ${id}-save` },
    h('span', { class: 'fine' }, strings.measure.save),
    ...Object.entries(kForms).map(([form, { label }]) => button(label, () => save(/** @type {FileForm} */ (form)), { id: `${id}-${form}` })),
  );
}
