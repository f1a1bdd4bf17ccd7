// German: heights below the cursor, along a line, and volumes.

/** @type {typeof import('../en/heights.js').height_words} */
export const height_words = {
  heading: 'Höhenprofil',
  along: 'Höhe entlang der Linie',
  how: 'Zeigen Sie auf das Profil, um den Ort auf der Karte zu sehen.',
  at: (distance, height) => `${height} bei ${distance}`,
  unknown_at: (distance) => `Keine Höhe bei ${distance}`,
  lowest: 'Tiefster Punkt',
  highest: 'Höchster Punkt',
  climb: 'Anstieg',
  descent: 'Abstieg',
  zero: 'Über dem Ellipsoid WGS 84, wie die Drohne es aufgezeichnet hat. Unterschiede sind genauer als die Höhen selbst.',
  waiting: 'Höhen werden geladen …',
  none: 'Diese Karte enthält keine Geländehöhen.',
  level: 'Diese Karte nimmt ebenes Gelände an und hat deshalb kein Höhenprofil.',
  beside: 'Die Linie liegt neben der Karte.',
  at_over: (distance, height, ground) => `${height} bei ${distance}, Boden ${ground}`,
  surface: 'Oberfläche',
  ground: 'Boden',
  here: 'Höhe der Oberfläche',
  over_ground: 'über dem Boden',
  change: {
    since: 'Höhenänderung seit',
    none: 'Nicht gezeigt',
    least: (height) => `Änderungen unter ${height} werden nicht gezeigt.`,
    shifted: (up, sideways) => `Die beiden Karten liegen in der Höhe ${up} und seitlich ${sideways} auseinander; das ist herausgerechnet.`,
  },
};

/** @type {typeof import('../en/heights.js').volume_words} */
export const volume_words = {
  heading: 'Volumen',
  base: 'Bezugsfläche',
  bases: { lowest: 'Tiefster Punkt des Randes', plane: 'Ebene durch den Rand', given: 'Gegebene Höhe' },
  since: (flight) => `Höhen von ${flight}`,
  given: 'Höhe der Bezugsfläche',
  no_number: 'Geben Sie die Höhe als Zahl ein.',
  above: 'Oberhalb (Abtrag)',
  below: 'Unterhalb (Auftrag)',
  added: 'Seitdem hinzugekommen',
  taken: 'Seitdem abgetragen',
  net: 'Netto',
  height: 'Bezugshöhe',
  mean_height: 'Mittlere Bezugshöhe',
  with_error: (volume, error) => `${volume} ± ${error}`,
  unknown_error: 'unbekannt',
  little_measured: (share) => `Nur ${share} dieser Höhen sind gemessen; der Rest ist aus der Umgebung ergänzt.`,
  partly: (share) => `Nur für ${share} dieser Fläche sind Höhen bekannt; der Rest zählt nicht mit.`,
  unknown: 'Hier sind keine Höhen bekannt. Zeichnen Sie die Fläche auf der Karte, oder geben Sie die Bezugshöhe an.',
  waiting: 'Volumen wird berechnet …',
};
