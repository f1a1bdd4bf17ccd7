// German: notes and measurements that are kept with a flight.
import { number } from '../../shared/language.js';

/** @type {typeof import('../en/notes.js').note_words} */
export const note_words = {
  heading: 'Notizen und Messungen',
  count: (n) => `(${number(n)})`,
  none: 'Noch nichts notiert. Fügen Sie eine Notiz hinzu oder messen Sie auf der Karte und speichern Sie das Ergebnis hier.',
  add: 'Notiz hinzufügen',
  edit: (name) => `${name} bearbeiten`,
  remove: (name) => `${name} löschen`,
  show: (name) => `${name} auf der Karte zeigen`,
  removed: (name) => `${name} wurde gelöscht.`,
  name: 'Name',
  text: 'Text',
  place: 'Klicken Sie auf die Karte, wo die Notiz hingehört, oder ziehen Sie ihre Marke.',
  at_centre: 'Kartenmitte nehmen',
  mark: 'Ort der Notiz',
  too_long: 'Das ist zu lang.',
  keep: 'Mit dem Flug speichern',
  kept: (name) => `${name} ist mit dem Flug gespeichert, unter Notizen und Messungen.`,
  saved: 'Alle, die diesen Flug öffnen, sehen sie.',
  saving: 'Wird gespeichert \u2026',
  waiting: (why) => `Noch nicht auf dem Server. In diesem Browser gespeichert, wird erneut gesendet: ${why}`,
  failed: (why) => `Nicht auf dem Server. In diesem Browser gespeichert: ${why}`,
  merged: 'Jemand anderes hat dieselben Notizen inzwischen geändert. Beide Fassungen bleiben erhalten.',
  own_copy: (name) => `${name} (meine Fassung)`,
  file_name: 'Notizen',
  unread: (why) => `Die Notizen lassen sich nicht lesen: ${why}`,
};
