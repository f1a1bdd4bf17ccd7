// What is wrong with a view of the page, found without a reader's eye: words that are cut, words over words, words and controls that
// something covers, views that scroll sideways, words of English on a page in another language.

/** The words of a language as one list. @param {any} words @param {string} [path] @returns {[string, any][]} every text and function by its path */
export const leavesOf = (words, path = '') =>
  typeof words === 'object' && words !== null
    ? Object.entries(words).flatMap(([key, value]) => leavesOf(value, path === '' ? key : `${path}.${key}`))
    : [[path, words]];

/**
 * The sentences of English that another language says otherwise: whole texts, and what stands between the values of those
 * that are made of some.
 * @param {object} english @param {object} spoken @returns {{whole: string[], parts: string[]}}
 */
export function foreignWords(english, spoken) {
  const texts = (/** @type {object} */ words) => leavesOf(words).flatMap(([, value]) => {
    if (typeof value === 'string') return [value];
    return typeof value === 'function' ? [1, 2].map((n) => String(value(...Array(value.length).fill(n)))) : [];
  });
  const own = texts(spoken).join('\n');
  const isForeign = (/** @type {string} */ text) => !own.includes(text);
  const whole = texts(english).map((text) => text.trim()).filter((text) => /[a-z]{3}/i.test(text) && isForeign(text));
  const parts = texts(english).flatMap((text) => text.split(/\d+/)).map((part) => part.trim()).filter((part) => /[a-z]+ [a-z]+ [a-z]+/i.test(part) && isForeign(part));
  return { whole: [...new Set(whole)], parts: [...new Set(parts)] };
}

/**
 * @param {any} page
 * @param {{whole: string[], parts: string[]}} [foreign] of foreignWords, where the page speaks another language
 * @returns {Promise<string[]>} one line a fault
 */
export const faultsOf = (page, foreign = { whole: [], parts: [] }) =>
  page.evaluate(findFaults, foreign);

/** In the page. @param {{whole: string[], parts: string[]}} foreign */
function findFaults({ whole, parts }) {
  /** @type {string[]} */
  const faults = [];
  const top = [...document.querySelectorAll('dialog[open]')].at(-1) ?? document.body;
  const name = (/** @type {Element} */ element) =>
    `${element.tagName.toLowerCase()}${element.id && `#${element.id}`}${[...element.classList].map((one) => `.${one}`).join('')} "${(element.textContent || element.getAttribute('aria-label') || '').trim().replace(/\s+/g, ' ').slice(0, 50)}"`;
  // A file's name or an address is as long as it is; what lies on the map moves with it.
  const kAsLongAsItIs = '.mono, .filmstrip, .visually-hidden, .maplibregl-marker, .overview-mark, script, style, option, svg, noscript';
  const isShown = (/** @type {Element} */ element) => {
    const { width, height } = element.getBoundingClientRect();
    return width > 1 && height > 1 && element.checkVisibility({ checkOpacity: true, checkVisibilityCSS: true }) && !element.closest('.sheet-closed .panel-body');
  };
  const hasTitle = (/** @type {Element} */ element) => Boolean(element.closest('[title]:not([title=""])'));

  const sideways = [document.documentElement, ...document.querySelectorAll('.panel-body, dialog[open], .card, .stage')];
  for (const element of sideways) {
    if (element.scrollWidth > element.clientWidth + 1 && isShown(element)) faults.push(`scrolls sideways: ${name(element)} ${element.scrollWidth} in ${element.clientWidth}`);
  }

  /** What lies between the edges of an element's nearest ancestor that cuts, which has no bar to scroll by. */
  const cutBy = (/** @type {Element} */ element, /** @type {DOMRect} */ box) => {
    for (let at = /** @type {Element|null} */ (element); at; at = at.parentElement) {
      const { overflowX, overflowY } = getComputedStyle(at);
      const room = at.getBoundingClientRect();
      if (/hidden|clip/.test(overflowX) && (box.left < room.left - 1.5 || box.right > room.right + 1.5)) return at;
      if (/hidden|clip/.test(overflowY) && (box.top < room.top - 3 || box.bottom > room.bottom + 3)) return at;
      if (/auto|scroll/.test(overflowX + overflowY)) return null;
    }
    return box.left < -1 || box.right > innerWidth + 1 ? document.documentElement : null;
  };
  /** Not scrolled out of what has a bar. */
  const isInView = (/** @type {Element} */ element, /** @type {DOMRect} */ box) => {
    for (let at = element.parentElement; at; at = at.parentElement) {
      if (!/auto|scroll|hidden|clip/.test(getComputedStyle(at).overflow)) continue;
      const room = at.getBoundingClientRect();
      if (box.left < room.left - 1 || box.right > room.right + 1 || box.top < room.top || box.bottom > room.bottom) return false;
    }
    return box.left >= 0 && box.top >= 0 && box.right <= innerWidth && box.bottom <= innerHeight;
  };
  const walker = document.createTreeWalker(top, NodeFilter.SHOW_TEXT);
  /** @type {{element: Element, box: DOMRect}[]} lines that are to be read where they are */
  const lines = [];
  for (let node = walker.nextNode(); node; node = walker.nextNode()) {
    const element = node.parentElement;
    const text = node.textContent?.trim() ?? '';
    if (!element || text === '' || element.closest(kAsLongAsItIs) || !isShown(element)) continue;
    const range = document.createRange();
    range.selectNodeContents(node);
    const boxes = [...range.getClientRects()];
    lines.push(...boxes.filter((box) => isInView(element, box)).map((box) => ({ element, box })));
    const cutter = boxes.map((box) => cutBy(element, box)).find(Boolean);
    const holder = getComputedStyle(element).display === 'inline' ? null : element;
    const is_wider = holder && holder.scrollWidth > holder.clientWidth + 1 && holder.clientWidth > 0;
    if ((cutter || is_wider) && !hasTitle(element)) faults.push(`cut: ${name(element)}${cutter ? ` by ${name(cutter).split(' ')[0]}` : ` ${holder?.scrollWidth} in ${holder?.clientWidth}`}`);
    if (whole.includes(text) || parts.some((part) => text.includes(part))) faults.push(`English: "${text.slice(0, 80)}" in ${name(element).split(' ')[0]}`);
  }
  for (const element of top.querySelectorAll('[aria-label], [title], [placeholder], [alt]')) {
    for (const attribute of ['aria-label', 'title', 'placeholder', 'alt']) {
      const text = element.getAttribute(attribute)?.trim() ?? '';
      const is_english = text !== '' && (whole.includes(text) || parts.some((part) => text.includes(part)));
      if (is_english) faults.push(`English: ${attribute}="${text.slice(0, 80)}" of ${name(element).split(' ')[0]}`);
    }
  }

  // Of a line that is seen at all, all is seen: what lies whole below a sheet or a card is not meant to be.
  const foreignAt = (/** @type {Element} */ element, /** @type {number} */ x, /** @type {number} */ y) => {
    const hit = document.elementsFromPoint(x, y).find((one) => one.checkVisibility({ checkOpacity: true, checkVisibilityCSS: true }));
    return hit && !element.contains(hit) && !hit.contains(element) ? hit : null;
  };
  /** @type {{element: Element, box: DOMRect}[]} */
  const seen = [];
  for (const { element, box } of lines) {
    const passes = getComputedStyle(element).pointerEvents === 'none';
    const middle = (box.top + box.bottom) / 2;
    const over = passes ? [] : [0.02, 0.25, 0.5, 0.75, 0.98].map((share) => foreignAt(element, box.left + share * box.width, middle));
    const coverer = over.find(Boolean);
    if (!coverer || over.some((one) => !one)) seen.push({ element, box });
    if (coverer && over.some((one) => !one)) faults.push(`half covered: ${name(element)} by ${name(coverer).split(' ')[0]}`);
  }
  // Letters fill the middle half of their line's height.
  const kLettersFrom = 0.25, kTouching_px = 2;
  const apart = (/** @type {DOMRect} */ a, /** @type {DOMRect} */ b) => {
    const rim = (/** @type {DOMRect} */ box) => kLettersFrom * box.height;
    return Math.min(a.right, b.right) - Math.max(a.left, b.left) < kTouching_px || Math.min(a.bottom - rim(a), b.bottom - rim(b)) - Math.max(a.top + rim(a), b.top + rim(b)) < kTouching_px;
  };
  seen.forEach((one, i) => {
    const other = seen.slice(i + 1).find(({ element, box }) => element !== one.element && !apart(one.box, box));
    if (other) faults.push(`words over words: ${name(one.element)} and ${name(other.element)}`);
  });

  /** Scrolled to, as who uses it would, in what has a bar for it; the answer takes it all back. */
  const bringIntoView = (/** @type {Element} */ element) => {
    /** @type {(() => void)[]} */
    const back = [];
    for (let at = element.parentElement; at; at = at.parentElement) {
      const { overflowX, overflowY } = getComputedStyle(at);
      if (!/auto|scroll/.test(overflowX + overflowY) || (at.scrollHeight <= at.clientHeight && at.scrollWidth <= at.clientWidth)) continue;
      const [holder, top_before, left_before] = [at, at.scrollTop, at.scrollLeft];
      const [box, room] = [element.getBoundingClientRect(), at.getBoundingClientRect()];
      const is_in_view = box.top >= room.top && box.bottom <= room.bottom && box.left >= room.left && box.right <= room.right;
      if (is_in_view) continue;
      at.scrollTop += (box.top + box.bottom - room.top - room.bottom) / 2;
      at.scrollLeft += (box.left + box.right - room.left - room.right) / 2;
      back.push(() => holder.scrollTo({ top: top_before, left: left_before, behavior: 'instant' }));
    }
    return () => back.reverse().forEach((undo) => undo());
  };
  for (const element of top.querySelectorAll('a[href], button, input, select, textarea, summary, [role="button"]')) {
    const style = getComputedStyle(element);
    if (!isShown(element) || style.pointerEvents === 'none' || element.closest('.visually-hidden, .skip, .maplibregl-marker, .overview-mark')) continue;
    const undo = bringIntoView(element);
    // The first line of one that is broken: the middle of its box may be beside its words.
    const box = element.getClientRects()[0];
    const hit = box && document.elementFromPoint(box.left + box.width / 2, box.top + box.height / 2);
    const is_own = hit && (element.contains(hit) || hit.contains(element) || hit.closest('label')?.control === element);
    if (!is_own) faults.push(`covered: ${name(element)} by ${hit ? name(hit).split(' ')[0] : 'the edge of the window'}`);
    undo();
  }
  return faults;
}
