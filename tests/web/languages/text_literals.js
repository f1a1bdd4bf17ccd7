// Finds text for people that stands in code instead of among the words of the languages. By the syntax tree: what is
// put into an element, what is said aloud or shown as a note, attributes that people read, and whole sentences anywhere.

/** What is the same in every language. */
const kNames = /Skyquilt|GeoJSON|GPX|KML|QGIS|GDAL|JOSM|Natural Earth|iframe/g;
/** Arguments from this one on are text. @type {Record<string, number>} */
const kSpeakers = { h: 2, svg: 2, put: 1, fill: 1, announce: 0, showNote: 0, alert: 0, confirm: 0, OwnDataError: 0, ApiError: 1 };
const kAttributes = new Set(['aria-label', 'aria-description', 'aria-roledescription', 'title', 'placeholder', 'alt', 'label']);
const kTextProperties = new Set(['textContent', 'innerText', 'title', 'ariaLabel', 'placeholder']);
/** What developers read. */
const kForDevelopers = /^(console\.\w+|Error|DOMException|TypeError)$/;

const isWord = (/** @type {string} */ text) => /\p{L}{2,}/u.test(text.replace(kNames, ''));
const isSentence = (/** @type {string} */ text) => /^[^\p{L}<]*\p{Lu}\p{Ll}+('\p{Ll}+)?,? \p{Ll}+/u.test(text.replace(kNames, ''));

/**
 * @param {any} ts the TypeScript compiler
 * @param {string} code
 * @returns {string[]}
 */
export function literalsIn(ts, code) {
  const source = ts.createSourceFile('page.js', code, ts.ScriptTarget.ES2022, true, ts.ScriptKind.JS);
  /** @type {Set<string>} */
  const found = new Set();
  const isText = (/** @type {any} */ node) => ts.isStringLiteral(node) || ts.isNoSubstitutionTemplateLiteral(node) || ts.isTemplateHead(node) || ts.isTemplateMiddle(node) || ts.isTemplateTail(node);
  const report = (/** @type {any} */ node) => found.add(`${source.getLineAndCharacterOfPosition(node.getStart()).line + 1}: ${node.text.trim()}`);

  /** The values that an expression may have; calls and conditions inside are looked at for themselves. @param {any} node */
  const readText = (node) => {
    if (isText(node)) {
      if (isWord(node.text)) report(node);
    } else if (ts.isTemplateExpression(node)) {
      [node.head, ...node.templateSpans.map((/** @type {any} */ span) => span.literal)].forEach(readText);
      node.templateSpans.forEach((/** @type {any} */ span) => readText(span.expression));
    } else if (ts.isConditionalExpression(node)) {
      readText(node.whenTrue);
      readText(node.whenFalse);
    } else if (ts.isBinaryExpression(node)) {
      const is_choice = [ts.SyntaxKind.AmpersandAmpersandToken, ts.SyntaxKind.BarBarToken, ts.SyntaxKind.QuestionQuestionToken, ts.SyntaxKind.PlusToken].includes(node.operatorToken.kind);
      if (is_choice) [node.left, node.right].forEach(readText);
    } else if (ts.isParenthesizedExpression(node)) {
      readText(node.expression);
    } else if (ts.isArrayLiteralExpression(node)) {
      node.elements.forEach(readText);
    }
  };

  /** @param {any} node */
  const visit = (node) => {
    if (ts.isImportDeclaration(node)) return;
    if (ts.isCallExpression(node) || ts.isNewExpression(node)) {
      const name = node.expression.getText();
      if (kForDevelopers.test(name)) return;
      const from = Object.hasOwn(kSpeakers, name) ? kSpeakers[name] : Infinity;
      (node.arguments ?? []).slice(from).forEach(readText);
      if (/\.setAttribute$/.test(name) && kAttributes.has(node.arguments[0]?.text)) readText(node.arguments[1]);
    }
    if (ts.isPropertyAssignment(node) && kAttributes.has(node.name.text)) readText(node.initializer);
    if (ts.isBinaryExpression(node) && node.operatorToken.kind === ts.SyntaxKind.EqualsToken && ts.isPropertyAccessExpression(node.left) && kTextProperties.has(node.left.name.text)) readText(node.right);
    if (isText(node) && isSentence(node.text)) report(node);
    ts.forEachChild(node, visit);
  };
  visit(source);
  return [...found];
}
