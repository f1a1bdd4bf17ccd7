// Many made-up flights over Europe, for the home view at its size.

const kTowns = ['Bern', 'Zürich', 'Genève', 'Łódź', 'Köln', 'Málaga', 'Tromsø', 'Ærø', 'Lugano', 'Brno'];

/** @param {any} mock @param {number} count */
export function seedMany(mock, count) {
  for (let i = 0; i < count; i += 1) {
    const flight = mock.seedReady(`${kTowns[i % kTowns.length]}, field ${i + 1}`, 3);
    Object.assign(flight.place, { lon: -8 + ((i * 37) % 300) / 10, lat: 38 + ((i * 53) % 200) / 10, season: i });
    const day = `2026-${String(1 + (i % 9)).padStart(2, '0')}-${String(1 + (i % 27)).padStart(2, '0')}`;
    flight.captured = { first: `${day}T09:31:00+02:00`, last: `${day}T09:52:34+02:00` };
  }
}
