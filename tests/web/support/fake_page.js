// As much of a page as a dialog needs to be opened without a browser: elements that show nothing.
export class FakeElement extends EventTarget {
  returnValue = '';
  value = '';
  is_open = false;
  hidden = false;
  style = {};
  /** @type {any[]} */
  children = [];
  /** @type {Record<string, string>} */
  attributes = {};
  /** @param {string} [tag] */
  constructor(tag = '') {
    super();
    this.tag = tag;
    made.push(this);
  }
  get firstChild() {
    return this.children[0] ?? null;
  }
  append(/** @type {any[]} */ ...more) {
    this.children.push(...more);
  }
  prepend() {}
  replaceChildren() {
    this.children = [];
  }
  remove() {}
  querySelectorAll() {
    return [];
  }
  setAttribute(/** @type {string} */ name, /** @type {string} */ value) {
    this.attributes[name] = value;
  }
  showModal() {
    this.is_open = true;
  }
  close() {
    this.is_open = false;
    this.dispatchEvent(new Event('close'));
  }
}
/** @type {FakeElement[]} all of them */
export const made = [];

/** What is done on the page. */
export const acts = new EventTarget();

Object.assign(globalThis, {
  Node: FakeElement,
  addEventListener: acts.addEventListener.bind(acts),
  location: { pathname: '/', href: 'http://localhost/' },
  document: { body: new FakeElement(), documentElement: {}, createElement: (/** @type {string} */ tag) => new FakeElement(tag), createElementNS: () => new FakeElement(), getElementById: () => new FakeElement(), querySelectorAll: () => [] },
});
