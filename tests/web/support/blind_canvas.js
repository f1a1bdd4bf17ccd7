// A graphics card that takes everything and draws nothing, for cases that look at no pixel of a map. The library that draws
// maps fetches its tiles, places its marks, answers what lies where and comes to rest as ever, but nobody fills the pixels:
// in software, as tests draw, that is half of what a case costs.

/** In the page, before its own scripts. */
export function drawNothing() {
  const { prototype } = WebGL2RenderingContext;
  /** @type {{[name: string]: (...values: any[]) => unknown}} */
  const answers = {
    checkFramebufferStatus: () => prototype.FRAMEBUFFER_COMPLETE,
    getAttribLocation: () => 0,
    getContextAttributes: () => ({}),
    getParameter: (/** @type {number} */ name) => (name === prototype.MAX_TEXTURE_SIZE ? 4096 : 16),
    getProgramParameter: (_, /** @type {number} */ name) => (name === prototype.LINK_STATUS ? true : 0),
    getShaderParameter: () => true,
    isContextLost: () => false,
  };
  const kNames = Object.entries(Object.getOwnPropertyDescriptors(prototype)).filter(([, { value }]) => typeof value === 'function').map(([name]) => name);
  const makeContext = (/** @type {HTMLCanvasElement} */ canvas) => {
    const methods = kNames.map((name) => [name, { value: answers[name] ?? (name.startsWith('create') ? () => ({}) : () => null) }]);
    return Object.create(prototype, {
      ...Object.fromEntries(methods),
      canvas: { value: canvas },
      drawingBufferWidth: { get: () => canvas.width },
      drawingBufferHeight: { get: () => canvas.height },
    });
  };
  const { getContext } = HTMLCanvasElement.prototype;
  /** @type {WeakMap<HTMLCanvasElement, WebGL2RenderingContext>} */
  const made = new WeakMap();
  HTMLCanvasElement.prototype.getContext = /** @type {any} */ (function (/** @type {string} */ kind, /** @type {any} */ options) {
    if (kind !== 'webgl2') return Reflect.apply(getContext, this, [kind, options]);
    if (!made.has(this)) made.set(this, makeContext(this));
    return made.get(this);
  });
}
