// Small words for building elements. Text only ever enters as text nodes: nothing here reads HTML, so a file or
// flight name can never become markup.

/** @typedef {Node|string|number|null|undefined|false} Child */

/**
 * @template {keyof HTMLElementTagNameMap} K
 * @param {K} tag
 * @param {Record<string, any>} [attributes] `class`, `on` ({event: listener}), properties `hidden`, `disabled`,
 *   `value`, `checked`; everything else becomes an attribute; null and false leave it out
 * @param {...Child} children
 * @returns {HTMLElementTagNameMap[K]}
 */
export function h(tag, attributes = {}, ...children) {
  const element = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) {
    if (value === null || value === undefined || value === false) continue;
    if (name === 'on') {
      for (const [event, listener] of Object.entries(value)) element.addEventListener(event, listener);
    } else if (name === 'value' || name === 'checked') {
      /** @type {any} */ (element)[name] = value;
    } else {
      element.setAttribute(name, value === true ? '' : String(value));
    }
  }
  fill(element, children);
  return element;
}

/**
 * @param {Element} parent
 * @param {Child[]} children
 */
export function fill(parent, children) {
  for (const child of children) {
    if (child === null || child === undefined || child === false) continue;
    parent.append(child instanceof Node ? child : String(child));
  }
}

/**
 * Replaces everything inside.
 * @param {Element} parent
 * @param {...Child} children
 */
export function put(parent, ...children) {
  parent.replaceChildren();
  fill(parent, children);
}

/**
 * Exactly these, in their order. What is there already stays where it is, with its focus.
 * @param {Element} parent
 * @param {Element[]} children
 */
export function arrange(parent, children) {
  const wanted = new Set(children);
  for (const old of [...parent.children]) if (!wanted.has(old)) old.remove();
  children.forEach((child, i) => {
    if (parent.children[i] !== child) parent.insertBefore(child, parent.children[i] ?? null);
  });
}

/**
 * Elements of a list that is drawn anew while somebody uses it: one that shows the same as before is the same, so that a
 * click which begins before and ends after counts, and the focus stays.
 * @template T
 * @template {Element} E
 * @param {(thing: T) => string} idOf
 * @param {(thing: T) => string} shownOf all that its element shows and does
 * @param {(thing: T) => E} make
 * @returns {(things: T[]) => E[]}
 */
export function keptElements(idOf, shownOf, make) {
  /** @type {Map<string, {shown: string, element: E}>} */
  let kept = new Map();
  return (things) => {
    const before = kept;
    kept = new Map();
    for (const thing of things) {
      const [id, shown] = [idOf(thing), shownOf(thing)];
      const old = before.get(id);
      kept.set(id, old?.shown === shown ? old : { shown, element: make(thing) });
    }
    return [...kept.values()].map(({ element }) => element);
  };
}

/**
 * @template {keyof SVGElementTagNameMap} K
 * @param {K} tag
 * @param {Record<string, string|number>} [attributes]
 * @param {...(Node|string)} children
 * @returns {SVGElementTagNameMap[K]}
 */
export function svg(tag, attributes = {}, ...children) {
  const element = document.createElementNS('http://www.w3.org/2000/svg', tag);
  for (const [name, value] of Object.entries(attributes)) element.setAttribute(name, String(value));
  element.append(...children);
  return element;
}

/** A checkbox with its words. @param {string} label @param {string} id @param {boolean} [checked] @param {(on: boolean) => void} [set] */
export function checkRow(label, id, checked = false, set = () => {}) {
  const input = h('input', { type: 'checkbox', id, checked, on: { change: () => set(input.checked) } });
  return { input, row: h('label', { class: 'check', for: id }, input, h('span', {}, label)) };
}

/** @param {HTMLElement} element that has the focus, or holds it @param {(event: KeyboardEvent) => void} run */
export const onEscape = (element, run) => element.addEventListener('keydown', (event) => event.key === 'Escape' && run(event));

/** @param {(element: HTMLElement) => void} run once for each that is observed, when it comes into sight */
export function whenSeen(run) {
  const observer = new IntersectionObserver((entries) => {
    for (const { isIntersecting, target } of entries) {
      if (!isIntersecting) continue;
      observer.unobserve(target);
      run(/** @type {HTMLElement} */ (target));
    }
  });
  return observer;
}

/**
 * The element with this id; a missing one is a mistake in index.html.
 * @param {string} id
 * @returns {HTMLElement}
 */
export function byId(id) {
  const element = document.getElementById(id);
  if (!element) throw new Error(`index.html lacks #${id}`);
  return element;
}

/**
 * Loads a style sheet of the page.
 * @param {string} href
 * @param {Element|null} [before] another one, which overrides it
 * @returns {Promise<void>} also where it cannot be had: what it styles is of use without it
 */
export const loadStyle = (href, before = null) => linkSettled(document.head.insertBefore(h('link', { rel: 'stylesheet', href }), before));

/** @param {Element} link of a style sheet @returns {Promise<void>} when that is there, or cannot be had */
export const linkSettled = (link) => new Promise((resolve) => ['load', 'error'].forEach((event) => link.addEventListener(event, () => resolve())));

/**
 * A style sheet that the document names already.
 * @param {string} href
 * @returns {Promise<void>|null} when it is there, or cannot be had; null: it is not named
 */
export function styleLoaded(href) {
  const link = document.querySelector(`link[rel="stylesheet"][href="${href}"]`);
  if (!(link instanceof HTMLLinkElement)) return null;
  return link.sheet ? Promise.resolve() : linkSettled(link);
}
