// The first thing one sees: what to do, where to drop, and the same for the command line.
import { serverAddress } from '../shared/router.js';
import { h } from '../shared/dom.js';
import { button, icon } from '../shared/icons.js';
import { copyButton } from '../sharing/links_view.js';
import { strings } from '../shared/strings.js';

/**
 * @param {{choose_folder: () => void, choose_files: () => void}} actions
 * @returns {HTMLElement}
 */
export function welcomeView(actions) {
  const words = strings.welcome;
  const command = `photos=(); for f in DCIM/*/*.JPG; do photos+=(-F "files=@$f"); done; curl -F name="${words.curl_flight}" "\${photos[@]}" ${serverAddress()}/api/v1/flights`;
  return h(
    'div',
    { class: 'welcome-inner' },
    h(
      'section',
      { class: 'drop-zone', id: 'drop-zone', 'aria-labelledby': 'welcome-title' },
      h('div', { class: 'drop-art', 'aria-hidden': 'true' }, icon('upload')),
      h('h2', { id: 'welcome-title' }, words.title),
      h('p', { class: 'lead' }, words.lead),
      h(
        'div',
        { class: 'drop-actions' },
        button(strings.drop.folder, actions.choose_folder, { picture: 'folder', class: 'button primary large', id: 'choose-folder' }),
        button(strings.drop.files, actions.choose_files, { picture: 'photo', class: 'button large', id: 'choose-files' }),
      ),
      h('p', { class: 'fine' }, words.kinds),
    ),
    h(
      'ol',
      { class: 'steps' },
      ...words.steps.map(([title, text]) => h('li', {}, h('strong', {}, title), h('span', {}, text))),
    ),
    h(
      'details',
      { class: 'curl' },
      h('summary', {}, words.curl),
      h('div', { class: 'code-box' }, h('pre', { tabindex: 0, 'aria-label': words.curl }, h('code', {}, command)),
        copyButton(words.curl, command)),
    ),
  );
}
