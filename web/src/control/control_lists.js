// Lists of surveyed points as people have them: ODM's gcp_list.txt (reference system, then a row per mark) and tables of
// name, x, y, height with commas, semicolons, tabs or blanks, with or without a header. Pure; never throws.
import { parseNumber } from '../shared/format.js';

/** @typedef {{photo: string, x: number, y: number}} ControlMark pixels: the centre of the first one is (0, 0) */
/**
 * @typedef {object} ControlPoint
 * @property {string} name
 * @property {number} x east or longitude, in the list's reference system
 * @property {number} y north or latitude
 * @property {number|null} height
 * @property {ControlMark[]} marks
 * @property {number} [lon] degrees, once the server has said them
 * @property {number} [lat]
 */
/**
 * @typedef {object} ReadList
 * @property {string} reference_system '' where the list names none
 * @property {ControlPoint[]} points heights in the unit of that system
 * @property {number[]} bad_lines counted from 1
 * @property {boolean} is_height_unit_unknown heights are in feet, and whether those of the system are is not known here
 */

const kMaxRows = 20_000;
const kMaxPoints = 2000;
const kUnmarked = '-';
// A pixel counts from its middle here and from the corner of the first one in gcp_list.txt.
const kMiddleOfPixel = 0.5;

const kPicture = /.\.(jpe?g|tiff?|png|dng)"?$/i;
const kSystem = /^\s*(EPSG:\d{3,6}\b.*|WGS ?84\b[^,;]*|\+proj=.*)\s*$/i;
// Systems that say what heights count from: with others it is the ellipsoid.
const kSystemOfHeights = /^(EPSG\D*\d+\s*\+|COMPD_CS|COMPOUNDCRS)/i;
// Systems whose heights are in metres, whatever a list's are in.
const kMetric = /^\s*(EPSG:(4258|4269|4326|4979|6318|258\d\d|32[67]\d\d)(\+(3855|5703|5773))?(?![\d+])|WGS ?84\b[^+]*$|\+proj=(longlat|utm)\b(?!.*(units=(?!m\b)|to_meter=)))/i;
// Systems whose numbers say which of two is the easting: UTM's keep within its zone, and no latitude is beyond 90.
const kUtm = /^\s*(EPSG:(258\d\d|269([01]\d|2[0-3])|32[67]\d\d)(?!\d)|WGS ?84\b.*\bUTM\b|\+proj=utm\b(?!.*(units=(?!m\b)|to_meter=)))/i;
const kDegrees = /^\s*(EPSG:(4258|4269|4326|4979|6318)(?!\d)|WGS ?84\s*$|\+proj=longlat\b)/i;
const kFeet = /^(ft|feet|foot|ift|sft|usft|ftus)$/;
const kFoot_m = 0.3048;  // the survey foot differs by two millionths

/** @type {[keyof Columns, RegExp][]} */
const kColumnNames = [
  ['name', /^(name|id|nr|no|point|point ?(name|id|nr|no)|label|gcp|code|punkt|punktname|punktnummer|bezeichnung)$/],
  ['x', /^(x|e|east|easting|lon|long|longitude|longitude deg|lng|ost|ostwert|rechtswert|rechts|länge)$/],
  ['y', /^(y|n|north|northing|lat|latitude|latitude deg|nord|nordwert|hochwert|hoch|breite)$/],
  ['height', /^(z|h|height|alt|altitude|elev|elevation|höhe|hoehe)$/],
  ['ellipsoidal', /^(ellipsoidal height|ellipsoid height|ell height|h ell|ellipsoidische höhe)$/],
  ['system', /^(epsg|crs|srs|system)$/],
  ['check', /^check$/],
];
/**
 * The text of a list's file: UTF-8, UTF-16 as its first two bytes say, or else as Windows saves tables of its own in the west.
 * @param {Uint8Array} bytes
 */
export function listText(bytes) {
  const [first, second] = bytes;
  if (first === 0xff && second === 0xfe) return new TextDecoder('utf-16le').decode(bytes);
  if (first === 0xfe && second === 0xff) return new TextDecoder('utf-16be').decode(bytes);
  try {
    return new TextDecoder('utf-8', { fatal: true }).decode(bytes);
  } catch {
    return new TextDecoder('windows-1252').decode(bytes);
  }
}

/** @typedef {{name?: number, x?: number, y?: number, height?: number, ellipsoidal?: number, system?: number, check?: number}} Columns */

/**
 * A photo's name that blanks cut is one field, as the stitcher reads it: up to its ending, from the quote that opens it or
 * else from behind the last number.
 * @param {string} line
 * @returns {string[]}
 */
function splitAtBlanks(line) {
  /** @type {{text: string, at: number}[]} */
  const words = [];
  for (const { 0: text, index } of line.matchAll(/\S+/g)) words.push({ text, at: index ?? 0 });
  const fields = words.map(({ text }) => text);
  const last = fields.findIndex((field) => kPicture.test(field));
  if (last < 0) return fields;
  const is_quoted = fields[last].endsWith('"') && fields.slice(0, last + 1).some((field) => field.startsWith('"'));
  const isFirst = (/** @type {number} */ i) => i === 0 || (is_quoted ? fields[i].startsWith('"') : !Number.isNaN(parseNumber(fields[i - 1])));
  let first = last;
  while (!isFirst(first)) first -= 1;
  return [...fields.slice(0, first), line.slice(words[first].at, words[last].at + words[last].text.length), ...fields.slice(last + 1)];
}

/** @param {string} line @returns {string[]} */
function split(line) {
  const separator = [';', '\t', ','].find((one) => line.split(one).length > 2);
  return (separator ? line.split(separator) : splitAtBlanks(line)).map((field) => field.trim().replace(/^"(.*)"$/, '$1'));
}

/** @param {string} heading */
const plainHeading = (heading) => heading.toLowerCase().replace(/^#\s*/, '').replace(/_/g, ' ').trim();

/** @param {string[]} fields @returns {Columns|null} where the row names x and y */
function columnsOf(fields) {
  /** @type {Columns} */
  const columns = {};
  fields.forEach((field, i) => {
    const word = plainHeading(field).replace(/\s*[[(].*$/, '').replace(/ (m|metres?|meters?|(us )?(ft|feet|foot|survey feet))$/, '').trim();
    const kind = kColumnNames.find(([, pattern]) => pattern.test(word))?.[0];
    if (kind && columns[kind] === undefined) columns[kind] = i;
  });
  return columns.x !== undefined && columns.y !== undefined ? columns : null;
}

/**
 * As surveyors write it, "point, northing, easting, elevation", where no row can be meant otherwise.
 * @param {string[][]} rows
 * @param {number} x the two columns, as they stand
 * @param {number} y
 * @param {string} system
 */
function isNorthFirst(rows, x, y, system) {
  const pairs = rows.map((fields) => [parseNumber(fields[x] ?? ''), parseNumber(fields[y] ?? '')]).filter((pair) => !pair.some(Number.isNaN));
  if (kUtm.test(system)) return pairs.length > 0 && pairs.every(([first, second]) => first > 1e6 && first < 1e7 && second > 1e5 && second < 9e5);
  return kDegrees.test(system) && pairs.some(([, second]) => Math.abs(second) > 90) && pairs.every(([first]) => Math.abs(first) <= 90);
}

/** Without a header: a name first, but for three numbers alone. @param {string[][]} rows @param {string} system @returns {Columns} */
function guessedColumns(rows, system) {
  const is_nameless = rows.every((fields) => fields.length === 3 && fields.every((field) => /\d[.,]\d/.test(field)));
  const [x, y] = is_nameless ? [0, 1] : [1, 2];
  const order = isNorthFirst(rows, x, y, system) ? { x: y, y: x } : { x, y };
  return is_nameless ? { ...order, height: 2 } : { name: 0, ...order, height: 3 };
}

/** @param {Columns} columns @param {string} system */
const heightColumn = ({ ellipsoidal, height }, system) => (ellipsoidal !== undefined && !kSystemOfHeights.test(system) ? ellipsoidal : height);

/** @param {string} heading @returns {'m'|'ft'|''} '' where it names no unit */
function unitOf(heading) {
  const words = plainHeading(heading).split(/[^a-z]+/);
  return words.some((word) => kFeet.test(word)) ? 'ft' : words.some((word) => /^(m|metres?|meters?)$/.test(word)) ? 'm' : '';
}

/**
 * Heights of a column that names its unit, in that of the system: of one of which nothing is known here, in that of its easting.
 * @param {ReadList} list
 * @param {string} system
 * @param {Columns} columns
 * @param {string[]} headings
 */
function convertHeights(list, system, columns, headings) {
  const unit = unitOf(headings[heightColumn(columns, system) ?? -1] ?? '');
  const wanted = kMetric.test(system) ? 'm' : unitOf(headings[columns.x ?? -1] ?? '');
  if (unit === '' || unit === wanted) return;
  list.is_height_unit_unknown = wanted === '' && unit === 'ft';
  if (wanted === '') return;
  const factor = unit === 'ft' ? kFoot_m : 1 / kFoot_m;
  for (const point of list.points) if (point.height !== null) point.height = Number((point.height * factor).toFixed(4));
}

/** A mark of gcp_list.txt. @param {string[]} fields */
const isMarkRow = (fields) =>
  fields.length >= 6 && fields.slice(0, 5).every((field, i) => !Number.isNaN(parseNumber(field)) || (i === 2 && /^nan$/i.test(field))) && Number.isNaN(parseNumber(fields[5]));

/**
 * @param {string} text
 * @param {string} [system] where the list names none
 * @returns {ReadList}
 */
export function parseControlList(text, system = '') {
  /** @type {ReadList} */
  const list = { reference_system: '', points: [], bad_lines: [], is_height_unit_unknown: false };
  /** @type {{fields: string[], line: number}[]} */
  const rows = [];
  /** @type {Columns|null} */
  let columns = null;
  /** @type {string[]} */
  let headings = [];
  text.replace(/^\uFEFF/, '').split(/\r\n|\r|\n/, kMaxRows).forEach((line, i) => {
    const named_system = rows.length === 0 && list.reference_system === '' ? line.match(kSystem) : null;
    if (named_system) {
      list.reference_system = named_system[1].trim();
      return;
    }
    if (line.trim() === '') return;
    const fields = split(line);
    if (rows.length === 0 && !columns && (columns = columnsOf(fields))) {
      headings = fields;
      return;
    }
    if (!line.startsWith('#')) rows.push({ fields, line: i + 1 });
  });
  const named = /** @type {Columns|null} */ (columns);
  if (rows.some(({ fields }) => isMarkRow(fields) && (named === null || kPicture.test(fields[5])))) readMarks(rows, named ?? { x: 0, y: 1 }, list);
  else readTable(rows, named ?? guessedColumns(rows.map(({ fields }) => fields), list.reference_system || system), system, list);
  if (named) convertHeights(list, list.reference_system || system, named, headings);
  return list;
}

/** Does it only check the map? @param {string} name of the point */
export const isCheckPoint = (name) => /check$/i.test(name);

/** A point that only checks the map is called so, as the stitcher does. @param {string} name @param {string[]} fields @param {Columns} columns */
function nameOfPoint(name, fields, columns) {
  const is_check = /^(1|yes|true|x|check)$/i.test(fields[columns.check ?? -1] ?? '') || (fields.length === 8 && /^check$/i.test(fields[7]));
  return is_check && !isCheckPoint(name) ? `${name}_check` : name;
}

/** @param {{fields: string[], line: number}[]} rows @param {Columns} columns @param {ReadList} list */
function readMarks(rows, columns, list) {
  /** @type {Map<string, ControlPoint>} */
  const known = new Map();
  for (const { fields, line } of rows) {
    if (!isMarkRow(fields)) {
      list.bad_lines.push(line);
      continue;
    }
    const [first, second, z, pixel_x, pixel_y] = fields.slice(0, 5).map(parseNumber);
    const [x, y] = columns.y === 0 ? [second, first] : [first, second];
    const key = `${x} ${y} ${z}`;
    let point = known.get(key);
    if (!point) {
      if (known.size === kMaxPoints) continue;
      point = { name: nameOfPoint((columns.check !== 6 && fields[6]) || `gcp${known.size + 1}`, fields, columns), x, y, height: Number.isNaN(z) ? null : z, marks: [] };
      known.set(key, point);
      list.points.push(point);
    }
    if (fields[5] !== kUnmarked && !point.marks.some(({ photo }) => photo === fields[5]))
      point.marks.push({ photo: fields[5], x: pixel_x - kMiddleOfPixel, y: pixel_y - kMiddleOfPixel });
  }
}

/** @param {{fields: string[], line: number}[]} rows @param {Columns} columns @param {string} usual_system @param {ReadList} list */
function readTable(rows, columns, usual_system, list) {
  for (const { fields, line } of rows) {
    const at = (/** @type {number|undefined} */ column) => (column === undefined ? '' : (fields[column] ?? ''));
    const [x, y] = [parseNumber(at(columns.x)), parseNumber(at(columns.y))];
    if (Number.isNaN(x) || Number.isNaN(y) || list.points.length === kMaxPoints) {
      list.bad_lines.push(line);
      continue;
    }
    const system = at(columns.system);
    if (system !== '' && list.reference_system === '') list.reference_system = /^\d+$/.test(system) ? `EPSG:${system}` : system;
    const height = parseNumber(at(heightColumn(columns, list.reference_system || usual_system)));
    const name = nameOfPoint(at(columns.name) || `gcp${list.points.length + 1}`, fields, columns);
    list.points.push({ name, x, y, height: Number.isNaN(height) ? null : height, marks: [] });
  }
}

/** As the stitcher compares names of photos: in any case, with or without their ending. @param {string} name */
export const photoKey = (name) => name.replace(/\.[^.]*$/, '').toLowerCase();

/** Which of two points it is nobody knows. @param {ControlPoint[]} points @returns {string} a name of several in different places, else '' */
export function nameOfSeveral(points) {
  const named = new Map(points.map((point) => [point.name, point]));
  return points.find(({ name, x, y, height }) => named.get(name)?.x !== x || named.get(name)?.y !== y || named.get(name)?.height !== height)?.name ?? '';
}

/**
 * Points of a list among those that are there: the same name has its coordinates replaced and its marks kept.
 * @param {ControlPoint[]} points
 * @param {ControlPoint[]} added
 * @param {string[]} photos of the flight: marks name them as they are called
 * @returns {ControlPoint[]}
 */
export function withPoints(points, added, photos) {
  const names = new Map(photos.map((name) => [photoKey(name), name]));
  const merged = new Map(points.map((point) => [point.name, point]));
  for (const point of added) {
    const before = merged.get(point.name);
    const marks = new Map((before?.marks ?? []).map((mark) => [photoKey(mark.photo), mark]));
    for (const mark of point.marks) marks.set(photoKey(mark.photo), { ...mark, photo: names.get(photoKey(mark.photo)) ?? mark.photo });
    merged.set(point.name, { ...point, marks: [...marks.values()] });
  }
  return [...merged.values()];
}
