// Figures with their names, below a measurement.
import { h } from '../shared/dom.js';

/** @param {string} id @param {[label: string, text: string][]} figures */
export const figureList = (id, figures) =>
  h('dl', { class: 'heights-figures', id }, ...figures.map(([label, text]) => h('div', {}, h('dt', {}, label), h('dd', {}, text))));
